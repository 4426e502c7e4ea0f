#include <algorithm>
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
#include "search_trace.hpp"
#include "stacking/reach.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/detection/detect_stones.hpp"
#include "stonestack/hardware/cell.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/motion/fit_for_hand.hpp"
#include "stonestack/report/run_report.hpp"
#include "stonestack/search/find_next_pose.hpp"
#include "stonestack/stacking/build_tower.hpp"
#include "stonestack/stacking/observe.hpp"

namespace stonestack::apps {
namespace {

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
  int levels = 1;
  SearchOptions options;
  DetectionOptions detection;
  MotionOptions motion;
};

/// What was found: the next placement, or one a level; other poses for the first, should the arm refuse it.
struct Found {
  std::vector<Placement> placements, alternatives;
  std::string reason;
  bool repeatable = true;  ///< not ended by the clock or the user: the same seed gives the same
};

/// What the search starts from, by whatever way it was given.
SearchProblem read_problem(const SearchCommand& command, const Catalogue& catalogue,
                           const ShapeList& shapes) {
  SearchProblem problem;
  problem.shapes = &shapes;
  problem.site = command.site.empty() ? CellLayout{}.site : parse_point(command.site);
  if (command.input.empty()) {
    require(!command.stones.empty(), "no scene and no stones; give SCENE or --stones a,b,c");
    for (const auto& name : split(command.stones, ','))
      problem.available.push_back({catalogue.index(name), Pose::Identity()});
    return problem;
  }
  if (is_scene_file(command.input)) {
    const SceneFile scene = read_scene_file(command.input);
    for (const auto& item : scene.stack)
      problem.stack.stones.push_back({catalogue.index(item.stone), item.T_W_O});
    for (const auto& item : scene.stones)
      problem.available.push_back({catalogue.index(item.stone), item.T_W_O});
    if (!problem.stack.stones.empty() || !problem.available.empty()) return problem;
    if (scene.depth_file.empty() && scene.cloud_file.empty())
      throw FileError(command.input, "has no stones, no depth and no cloud",
                      "add stones with their poses or a view of them");
  }
  const DetectionModels models(catalogue.stones, command.detection);
  const SceneView view = read_view(command.input, command.camera_pose);
  const DetectionResult seen = detect_stones(view.image, models, {}, command.detection);
  check_level(view, seen.table_C, command.input);
  if (seen.detections.empty())
    throw Error(command.input + ": nothing detected: " + seen.note, ExitCode::kNothingDetected);
  std::vector<PlacedStone> placed;
  const Pose T_W_C = view.T_W_C ? *view.T_W_C : camera_over_table(seen.table_C, command.input);
  for (const auto& found : seen.detections) placed.push_back({found.stone, T_W_C * found.T_C_O});
  const Arrangement arrangement = sort_by_site(shapes, problem.site, placed);
  problem.stack.stones = arrangement.stack;
  problem.available = arrangement.loose;
  log_info(concat(arrangement.stack.size(), " stones stand at the site, ", arrangement.loose.size(),
                  " lie loose"));
  return problem;
}

/// A stack that was measured a little off is built on as it comes to rest, so that placements touch what is
/// told of below them. One that does not stand is left to the search to refuse.
void let_come_to_rest(const SearchOptions& options, SearchProblem* problem) {
  check_problem(*problem, options);
  std::string unused;
  const auto stack = standing_stack(*problem->shapes, problem->stack, options, &unused);
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
    found.repeatable = command.options.budget == 0.0 && !interrupt_noted();
    return found;
  }
  SearchOptions options = command.options;
  options.trace = options.trace || !command.trace.empty();
  SearchResult result = find_next_pose(problem, options, progress);
  if (!command.trace.empty()) write_trace(command.trace, catalogue, result);
  found.reason = result.reason;
  found.repeatable = command.options.budget == 0.0 && !interrupt_noted();
  if (result.best.empty()) return found;
  found.placements.push_back(result.best.front());
  found.alternatives.assign(result.best.begin() + 1, result.best.end());
  return found;
}

void print(const SearchCommand& command, const Catalogue& catalogue, const SearchProblem& problem,
           const Found& found) {
  if (!command.common.json) return print_table(catalogue, found.placements);
  nlohmann::json stack = nlohmann::json::array();
  for (const PlacedStone& placed : problem.stack.stones)
    stack.push_back({{"stone", catalogue.stones[static_cast<std::size_t>(placed.stone)].name},
                     {"T_W_O", pose_json(placed.T_W_O)}});
  const auto list = [&](const std::vector<Placement>& placements) {
    nlohmann::json array = nlohmann::json::array();
    for (const auto& p : placements) array.push_back(placement_json(catalogue, p));
    return array;
  };
  std::cout << nlohmann::json{{"schema", "stonestack.search/1"},
                              {"placements", list(found.placements)},
                              {"alternatives", list(found.alternatives)},
                              {"stack", stack},
                              {"reason", found.reason},
                              {"repeatable", found.repeatable},
                              {"seed", command.common.seed}}
                   .dump(2)
            << '\n';
}

void search(SearchCommand& command) {
  command.common.begin();
  command.options.seed = command.detection.seed = command.common.seed;
  if (!command.robot.empty()) command.options.largest_tilt = BuildOptions{}.search.largest_tilt;
  command.common.settings.apply(
      join({nest("search", fields(command.options)), nest("detection", fields(command.detection)),
            nest("motion", fields(command.motion))}));
  require(command.trace.empty() || command.levels == 1, "--trace tells of one level; give --levels 1");
  const Catalogue catalogue = command.common.read();
  const ShapeList shapes = make_contact_shapes(catalogue.stones);
  SearchProblem problem = read_problem(command, catalogue, shapes);
  let_come_to_rest(command.options, &problem);
  ask_the_arm(command, catalogue, &problem);
  const Found found = find(command, catalogue, problem);
  write_outputs(command, catalogue, tower_of(problem, found.placements), problem.site);
  print(command, catalogue, problem, found);
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
  sub->add_option("--stones", command->stones,
                  "Stones to plan with when there is no scene, by name, comma-separated");
  sub->add_option("--site", command->site,
                  "Where the tower stands, x,y in metres (default: the cell's site)");
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
  command->common.settings.bind(
      sub->add_option(
             "--budget", command->options.budget,
             "Seconds after which it ends with the best so far (may differ from run to run); 0: none")
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
      "A cloud without --camera-pose is taken to be in the world frame (z up, table at z = 0), unless it is "
      "organised as a\n"
      "depth camera's: then the table that is seen becomes z = 0. A stack in a scene file is built on, from "
      "its last "
      "stone up.\nCtrl-C ends the search with the best so far (exit code 130).");
  sub->callback([command] { search(*command); });
}

}  // namespace stonestack::apps
