#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "common_options.hpp"
#include "geometry/pose_json.hpp"
#include "scene_input.hpp"
#include "search/search_context.hpp"
#include "search_scene.hpp"
#include "search_trace.hpp"
#include "stacking/reach.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/hardware/cell.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/motion/planning_scene.hpp"
#include "stonestack/report/run_report.hpp"
#include "stonestack/search/find_next_pose.hpp"
#include "stonestack/stacking/build_tower.hpp"
#include "stonestack/stacking/observe.hpp"

namespace stonestack::apps {
namespace {

constexpr double kAnyTilt = 3.14159265;  // rad, without a robot no grasp limits how a stone is turned

struct SearchCommand {
  CommonOptions common;
  std::string input;
  std::string camera_pose;
  std::string stones;
  std::string site;
  std::string picture;
  std::string out;
  std::string trace;
  std::string robot;
  bool world = false;
  int levels = 1;
  SearchOptions options;
  DetectionOptions detection;
  MotionOptions motion;
  DepthInput depth;
};

/// Result of a search: the next placement, or one a level; other poses for the first, should the arm refuse
/// it.
struct Found {
  std::vector<Placement> placements, alternatives;
  std::string reason;
  bool repeatable = true;  ///< not ended by the clock or the user: the same seed gives the same
};

/// A stack that was measured a little off is built on as it comes to rest, so that placements touch what is
/// told of below them. One that does not stand is left to the search to refuse.
void let_come_to_rest(const SearchOptions& options, SearchProblem* problem) {
  check_problem(*problem, options);
  std::string unused;
  const auto stack = settled_stack(*problem->shapes, problem->stack, options, &unused);
  if (!stack) return;
  double moved = 0.0;
  for (std::size_t i = 0; i < stack->stones.size(); ++i)
    moved = std::max(moved, difference(problem->stack.stones[i].T_W_O, stack->stones[i].T_W_O).translation);
  if (moved > 0.0)
    log_info(concat("the given stack comes to rest up to ", 0.01 * std::round(1e5 * moved),
                    " mm from where it is said to be; searching on that"));
  problem->stack = *stack;
}

nlohmann::json placement_json(const Catalogue& catalogue, const Placement& p) {
  return {{"stone", catalogue.stones[static_cast<std::size_t>(p.stone)].name},
          {"T_W_O", pose_json(p.T_W_O)},
          {"cost", p.cost},
          {"terms", p.terms},
          {"predicted_success", p.predicted_success},
          {"support", {{"area_m2", p.support.area}, {"margin_m", p.support.margin}}}};
}

void print_table(const Catalogue& catalogue, const std::vector<Placement>& placements) {
  std::printf("%-20s %8s %6s %10s   position (m)\n", "stone", "cost", "p(ok)", "area (cm2)");
  for (const auto& p : placements) {
    const auto& t = p.T_W_O.translation();
    std::printf("%-20s %8.3f %6.2f %10.2f   %7.4f %7.4f %7.4f\n",
                catalogue.stones[static_cast<std::size_t>(p.stone)].name.c_str(), p.cost, p.predicted_success,
                1e4 * p.support.area, t.x(), t.y(), t.z());
  }
}

/// The stack with the placements on it.
std::vector<PlacedStone> tower_of(const SearchProblem& problem, const std::vector<Placement>& placements) {
  std::vector<PlacedStone> tower = problem.stack.stones;
  for (const auto& p : placements) tower.push_back({p.stone, p.T_W_O});
  return tower;
}

void write_outputs(const SearchCommand& command, const Catalogue& catalogue,
                   const std::vector<PlacedStone>& tower, const Eigen::Vector2d& site) {
  if (!command.out.empty()) {
    SceneFile scene;
    for (const auto& placed : tower)
      scene.stack.push_back({catalogue.stones[static_cast<std::size_t>(placed.stone)].name, placed.T_W_O});
    write_scene_file(command.out, scene);
    log_info("wrote " + command.out);
  }
  if (command.picture.empty()) return;
  const auto meshes = drawn_stones(catalogue, tower);
  double top = 0.0;
  for (const auto& item : meshes) top = std::max(top, bounds(transformed(item.mesh, item.T_W_A)).max().z());
  write_png(command.picture, draw(meshes, view_of_site(site, top)));
  log_info("wrote " + command.picture);
}

/// Stones that hand and arm cannot carry are left where they lie; fails where that leaves none.
void leave_what_is_too_heavy(const PlanningScene& scene, const Catalogue& catalogue, SearchProblem& problem) {
  std::string heavy;
  std::erase_if(problem.available, [&](const auto& item) {
    const Stone& stone = catalogue.stones[static_cast<std::size_t>(item.stone)];
    const std::string who = overload(stone.mass.mass, scene.gripper, scene.robot);
    if (!who.empty())
      heavy += concat(heavy.empty() ? "" : ", ", stone.name, " (", stone.mass.mass, " kg, ", who, ")");
    return !who.empty();
  });
  if (problem.available.empty() && !heavy.empty())
    throw Error("no stone of the scene can be carried: " + heavy, ExitCode::kExecutionFailed);
  if (!heavy.empty()) log_info("left where they lie, too heavy: " + heavy);
}

/// With --robot only poses are wanted to which that arm can bring the stones from where they lie, in one go.
void ask_the_arm(const SearchCommand& command, const Catalogue& catalogue, SearchProblem* problem) {
  if (command.robot.empty()) return;
  require(!command.input.empty(), "--robot asks how stones are reached where they lie; give a SCENE");
  const RobotModel robot = read_robot(command.robot);
  const Arrangement arrangement{problem->stack.stones, problem->available};
  CellLayout layout;
  if (is_scene_file(command.input)) {
    const SceneFile file = read_scene_file(command.input);
    layout.obstacles = file.obstacles;
    layout.paddings = file.paddings;
  }
  const PlanningScene scene = make_planning_scene(layout, robot, catalogue, arrangement);
  leave_what_is_too_heavy(scene, catalogue, *problem);
  const auto reach = std::make_shared<Reach>(arrangement, scene, catalogue, command.motion);
  problem->reachable = [reach](int stone, const Pose& T_W_O, const Stack& below) {
    return reach->in_one_go(stone, T_W_O, below);
  };
}

Found find(const SearchCommand& command, const Catalogue& catalogue, const SearchProblem& problem) {
  Found found;
  const auto progress = [](const std::string& line) { log_progress(line); };
  if (command.levels > 1) {
    found.placements = plan_tower(problem, command.levels, command.options, &found.reason, progress);
    return found;
  }
  SearchOptions options = command.options;
  options.trace = options.trace || !command.trace.empty();
  SearchResult result = find_next_pose(problem, options, progress);
  if (!command.trace.empty()) write_trace(command.trace, catalogue, result);
  found.reason = result.reason;
  if (result.best.empty()) return found;
  found.placements.push_back(result.best.front());
  found.alternatives.assign(result.best.begin() + 1, result.best.end());
  return found;
}

/// A word as a shell takes it.
std::string quoted(const std::string& word) {
  const auto plain = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || std::string("_-./,:=+@%").find(c) < 12;
  };
  if (!word.empty() && std::all_of(word.begin(), word.end(), plain)) return word;
  std::string result = "'";
  for (const char c : word) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return result + "'";
}

/// Returns the command to type next, for a result that was found in a view; empty for others.
std::string next_command(const SearchCommand& command, const SearchStart& start) {
  if (!start.seen) return {};
  const auto with = [](const char* name, const std::string& value) {
    return value.empty() ? std::string() : concat(' ', name, ' ', quoted(value));
  };
  const std::string catalogue = with("--catalogue", command.common.catalogue);
  if (!command.out.empty()) return concat("stonestack check ", quoted(command.out), catalogue);
  const DepthInput& depth = command.depth;
  const std::string view = concat(with("--units", depth.units == "m" ? "" : depth.units),
                                  with("--depth-unit", depth.unit == 0.0 ? "" : concat(depth.unit)),
                                  with("--camera", depth.camera), with("--distortion", depth.distortion),
                                  with("--frame", depth.frame == 0 ? "" : concat(depth.frame)));
  const std::string again = concat("stonestack search ", quoted(command.input), view, catalogue,
                                   with("--camera-pose", command.camera_pose),
                                   command.world ? " --world" : "", with("--site", command.site));
  if ((start.frame == "camera_pose" || command.world) && command.robot.empty())
    return again + " --robot ur10 --json > next.json";
  return concat(again, with("--robot", command.robot), " --out tower.yaml --picture tower.png");
}

void print_text(const SearchCommand& command, const Catalogue& catalogue, const SearchStart& start,
                const Found& found) {
  if (start.seen) {
    std::printf("frame  %s", start.frame_text.c_str());
    if (start.T_W_C) {
      const Eigen::Vector3d p = start.T_W_C->translation();
      std::printf("; camera at %.3f %.3f %.3f m", p.x(), p.y(), p.z());
    }
    std::printf("\nstack  %s\n", start.site_text.c_str());
  }
  print_table(catalogue, found.placements);
  if (start.seen && !found.placements.empty())
    std::printf("next   %s\n", next_command(command, start).c_str());
}

nlohmann::json frame_json(const SearchStart& start) {
  nlohmann::json frame = {{"defined_by", start.frame}, {"text", start.frame_text}, {"T_W_C", nullptr}};
  if (start.T_W_C) frame["T_W_C"] = pose_json(*start.T_W_C);
  return frame;
}

void print(const SearchCommand& command, const Catalogue& catalogue, const SearchStart& start,
           const Found& found) {
  clear_progress();
  if (!command.common.json) return print_text(command, catalogue, start, found);
  const auto stones = [&](const std::vector<PlacedStone>& list) {
    nlohmann::json array = nlohmann::json::array();
    for (const PlacedStone& placed : list)
      array.push_back({{"stone", catalogue.stones[static_cast<std::size_t>(placed.stone)].name},
                       {"T_W_O", pose_json(placed.T_W_O)}});
    return array;
  };
  const auto list = [&](const std::vector<Placement>& placements) {
    nlohmann::json array = nlohmann::json::array();
    for (const auto& p : placements) array.push_back(placement_json(catalogue, p));
    return array;
  };
  const SearchProblem& problem = start.problem;
  std::cout << nlohmann::json{{"schema", "stonestack.search/1"},
                              {"frame", frame_json(start)},
                              {"site", {{"x", problem.site.x()}, {"y", problem.site.y()}}},
                              {"placements", list(found.placements)},
                              {"alternatives", list(found.alternatives)},
                              {"stack", stones(problem.stack.stones)},
                              {"loose", stones(problem.available)},
                              {"next", found.placements.empty() ? "" : next_command(command, start)},
                              {"reason", found.reason},
                              {"repeatable", found.repeatable},
                              {"seed", command.common.seed}}
                   .dump(2)
            << '\n';
}

/// All that the budget covers: catalogue, view, shapes, arm and search. Where the time is over before there
/// is a result the start is empty, or as far as it came.
Found find_in_time(const SearchCommand& command, const Clock& clock, Catalogue* catalogue,
                   SearchStart* start) {
  const TimeLimit limit(command.options.budget, clock);
  Found found;
  try {
    *catalogue = command.common.read();
    *start = read_start({command.input, command.camera_pose, command.stones, command.site, command.world,
                         !command.robot.empty(), command.depth},
                        *catalogue, command.detection);
    let_come_to_rest(command.options, &start->problem);
    ask_the_arm(command, *catalogue, &start->problem);
    found = find(command, *catalogue, start->problem);
  } catch (const Interrupted&) {
    if (!limit.is_over()) throw;
    found.reason = kTimeOver;
  }
  found.repeatable = command.options.budget == 0.0 && !interrupt_noted();
  return found;
}

void search(SearchCommand& command) {
  command.common.begin();
  command.options.seed = command.detection.seed = command.common.seed;
  if (command.robot.empty()) command.options.max_tilt = kAnyTilt;
  command.common.settings.apply(
      join({nest("search", fields(command.options)), nest("detection", fields(command.detection)),
            nest("motion", fields(command.motion))}));
  require(command.trace.empty() || command.levels == 1, "--trace tells of one level; give --levels 1");
  if (!command.input.empty()) require_readable(command.input);
  if (!command.robot.empty()) (void)read_robot(command.robot);
  for (const std::string& path : {command.out, command.picture})
    if (!path.empty()) require_writable(path);
  if (!command.trace.empty()) require_writable(command.trace + "/candidates.json");
  Catalogue catalogue;
  SearchStart start;
  const auto clock = make_steady_clock();
  const Found found = find_in_time(command, *clock, &catalogue, &start);
  const SearchProblem& problem = start.problem;
  write_outputs(command, catalogue, tower_of(problem, found.placements), problem.site);
  print(command, catalogue, start, found);
  throw_if_interrupted();
  if (found.placements.empty()) throw Error("no stable pose: " + found.reason, ExitCode::kNoStablePose);
  if (!found.repeatable)
    log_info(concat("the clock may have ended it (--budget ", command.options.budget,
                    "): another run may find something else"));
  if (static_cast<int>(found.placements.size()) < command.levels)
    log_warning(concat(found.placements.size(), " of ", command.levels, " levels: ", found.reason));
}

}  // namespace

void add_search(CLI::App& app) {
  auto command = std::make_shared<SearchCommand>();
  CLI::App* sub = app.add_subcommand("search", "Find the next stable stacking pose");
  sub->add_option("SCENE", command->input,
                  "Point cloud (PLY, PCD) or scene file; without it, --stones plans from the empty table");
  sub->add_option("--camera-pose", command->camera_pose,
                  "The cloud is in the camera frame, taken from here: x,y,z,qx,qy,qz,qw or a scene file");
  register_depth_input(*sub, command->depth);
  sub->add_flag("--world", command->world, "The cloud is in the world frame (z up, table at z = 0)");
  sub->add_option("--stones", command->stones,
                  "Stones to plan with when there is no scene, by name, comma-separated");
  sub->add_option(
      "--site", command->site,
      "Where the tower stands, x,y in metres (default: the cell's site; for a cloud alone where one "
      "stands, else the best place in view)");
  sub->add_option("--robot", command->robot,
                  "Only poses to which this arm (name, URDF or YAML) brings the stones from where they lie");
  sub->add_option("--levels", command->levels, "Plan on as if each placement had succeeded")
      ->check(CLI::Range(1, 50))
      ->capture_default_str();
  command->common.settings.bind(sub->add_option("--method", command->options.method, "default or paper")
                                    ->check(CLI::IsMember({"default", "paper"}))
                                    ->capture_default_str(),
                                "search.method");
  command->common.settings.bind(
      sub->add_option("--friction", command->options.friction, "Assumed friction, stone on stone")
          ->check(CLI::Range(1e-3, 2.0))
          ->capture_default_str(),
      "search.friction");
  command->common.settings.bind(sub->add_option("--budget", command->options.budget,
                                                "Seconds after which it ends with the best so far, loading "
                                                "and detection included (may differ from "
                                                "run to run); 0: none")
                                    ->check(CLI::NonNegativeNumber)
                                    ->capture_default_str(),
                                "search.budget");
  sub->add_option("--trace", command->trace,
                  "Write every candidate here: path to contact, polygon, terms, outcome")
      ->type_name("DIR");
  sub->add_option("--out", command->out, "Write the planned tower as a scene file");
  sub->add_option("--picture", command->picture, "Draw the planned tower (PNG)");
  command->common.register_on(*sub);
  sub->footer(
      "Examples:\n"
      "  stonestack search --stones limestone_1,limestone_2,limestone_3 --levels 3 --picture tower.png\n"
      "  stonestack search scene.ply --camera-pose 0.7,-0.18,0.7,1,0,0,0 --json\n"
      "  stonestack search scene.yaml --site 0.7,0.28 --method paper\n"
      "  stonestack search scene.yaml --robot ur10 --json > next.json    # for stonestack plan --search\n"
      "  stonestack search scene.ply                # a cloud alone: on the tower in view, or the best "
      "place\n"
      "A cloud without --camera-pose is taken as in the camera's frame, and the table that is seen becomes z "
      "= 0;\n"
      "or as in the world frame (z up, table at z = 0), if most of it lies about z = 0. --robot needs the "
      "camera's "
      "pose,\nor --world for a cloud in the cell's frame. A stack in a scene file is built on, from "
      "its last "
      "stone up.\nWithout --robot a stone may be turned any way up, as search.max_tilt limits what one "
      "grasp "
      "can do.\nCtrl-C ends the search with the best so far (exit code 130).");
  sub->callback([command] { search(*command); });
}

}  // namespace stonestack::apps
