#include <cmath>
#include <iostream>
#include <numbers>

#include "commands.hpp"
#include "common_options.hpp"
#include "scene_input.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/report/results.hpp"
#include "stonestack/stacking/observe.hpp"

namespace stonestack::apps {
namespace {

constexpr double kAnyTilt = std::numbers::pi;  // rad, without a robot no grasp limits how a stone is turned

struct SearchCommand {
  CommonOptions common;
  std::string picture, out, trace;
  SceneSearchTask task;
};

/// Refuses what can be refused before stones are read, which takes seconds.
void check(const SearchCommand& command) {
  const SceneSearchTask& task = command.task;
  require(command.trace.empty() || (task.levels == 1 && task.wall.empty()),
          "--trace shows one level; give --levels 1");
  if (!task.wall.empty()) {
    (void)read_wall_target(task.wall);
    require(task.search.method == "default" && task.levels == 1,
            "--wall, --bridge and --target go with neither --levels nor --method paper");
  }
  if (!task.scene.empty()) require_readable(task.scene);
  if (!task.robot.empty()) (void)read_robot(task.robot);
  for (const std::string& path : {command.out, command.picture})
    if (!path.empty()) require_writable(path);
  if (!command.trace.empty()) require_writable(command.trace + "/candidates.json");
}

/// All that the budget covers: catalogue, view, shapes, arm and search.
SceneSearch search_in_time(const SceneSearchTask& task) {
  const auto clock = make_steady_clock();
  const TimeLimit limit(task.search.budget, *clock);
  return search_in_scene(task, [&](const std::string& best) {
    const double now = clock->now();
    show_progress({"search", std::round(now), task.search.budget, "s", best, now});
  });
}

void write_outputs(const SearchCommand& command, const SceneSearch& found) {
  std::vector<PlacedStone> shown = found.supports;
  for (const PlacedStone& placed : planned_tower(found)) shown.push_back(placed);
  if (found.trace && !command.trace.empty()) {
    const std::string path = command.trace + "/candidates.json";
    write_file(path, search_trace_json(found));
    log_info(concat("wrote ", path, ": ", found.trace->size(), " candidates"));
  }
  if (!command.out.empty()) {
    write_scene_file(command.out, scene_of(found));
    log_info("wrote " + command.out);
    if (!found.supports.empty())
      log_warning(command.out +
                  " has the stones without the target's blocks, which scene files do not hold: `check` "
                  "would see them in the air");
  }
  if (!command.picture.empty()) {
    draw_tower(command.picture, found.catalogue, shown, found.start.problem.site);
    log_info("wrote " + command.picture);
  }
}

void search(SearchCommand& command) {
  SceneSearchTask& task = command.task;
  const std::string& catalogue = command.common.catalogue;
  task.catalogue = catalogue.empty() ? data_path("stones") : catalogue;
  task.search.seed = task.detection.seed = command.common.seed;
  if (task.robot.empty()) task.search.max_tilt = kAnyTilt;
  command.common.settings.apply(
      join({nest("search", fields(task.search)), nest("detection", fields(task.detection)),
            nest("motion", fields(task.motion)), nest("gripper", {gripper_field(task.gripper)})}));
  task.search.trace = task.search.trace || !command.trace.empty();
  check(command);
  const SceneSearch found = search_in_time(task);
  write_outputs(command, found);
  const std::string next = next_command(found, task, catalogue, command.out);
  clear_progress();
  std::cout << (command.common.json ? search_json(found, task.search.seed, next) : search_text(found, next));
  throw_if_interrupted();
  const std::size_t levels = found.placements.size();
  if (levels == 0) throw Error("no stable pose: " + found.reason, ExitCode::kNoStablePose);
  if (!found.repeatable)
    log_info(concat("the clock may have ended it (--budget ", task.search.budget,
                    "): another run may find something else"));
  if (found.wall && !found.reason.empty())
    log_warning(found.wall->metrics.asked > 0
                    ? concat(levels, " of ", found.wall->metrics.asked, " stones: ", found.reason)
                    : concat("not all that was asked for: ", found.reason));
  if (!found.wall && static_cast<int>(levels) < task.levels)
    log_warning(concat(levels, " of ", task.levels, " levels: ", found.reason));
}

}  // namespace

void add_search(CLI::App& app) {
  const auto [sub, command] =
      add_subcommand<SearchCommand>(app, "search", "Find the next stable stacking pose", search);
  SceneSearchTask& task = command.task;
  Settings& settings = command.common.settings;
  sub.add_option(
      "SCENE", task.scene,
      "Cloud (PLY, PCD), scene file, depth PNG or recording (folder); without it, --stones plans from the "
      "empty table");
  sub.add_option("--camera-pose", task.camera_pose,
                 "The cloud is in the camera frame, taken from here: x,y,z,qx,qy,qz,qw or a scene file");
  register_depth_input(sub, task.depth);
  sub.add_flag("--world", task.world, "The cloud is in the world frame (z up, table at z = 0)");
  sub.add_option("--stones", task.stones,
                 "Stones to plan with when there is no scene: names, comma-separated, or all");
  add_structure(sub, task.wall, nullptr);
  sub.add_option(
      "--site", task.site,
      "Where the tower stands, x,y in metres (default: the cell's site; for a cloud alone where one "
      "stands, else the best place in view)");
  sub.add_option("--robot", task.robot,
                 "Only poses to which this arm (name, URDF or YAML) brings the stones from where they lie");
  sub.add_option("--levels", task.levels, "Plan on as if each placement had succeeded")
      ->check(CLI::Range(1, 50))
      ->capture_default_str();
  settings.bind(sub.add_option("--method", task.search.method, "default or paper")
                    ->check(CLI::IsMember({"default", "paper"}))
                    ->capture_default_str(),
                "search.method");
  add_objective(sub, task.search.objective, settings);
  settings.bind(sub.add_option("--friction", task.search.friction, "Assumed friction, stone on stone")
                    ->check(CLI::Range(1e-3, 2.0))
                    ->capture_default_str(),
                "search.friction");
  settings.bind(sub.add_option("--budget", task.search.budget,
                               "Seconds after which it ends with the best so far, loading and detection "
                               "included (may differ from run to run); 0: none")
                    ->check(CLI::NonNegativeNumber)
                    ->capture_default_str(),
                "search.budget");
  add_path(sub, "--trace", command.trace,
           "Write every candidate here: path to contact, polygon, terms, outcome", "DIR");
  sub.add_option("--out", command.out, "Write the planned tower as a scene file");
  sub.add_option("--picture", command.picture, "Draw the planned tower (PNG)");
  command.common.register_on(sub);
  sub.footer(
      "Examples:\n"
      "  stonestack search --stones limestone_1,limestone_2,limestone_3 --levels 3 --picture tower.png\n"
      "  stonestack search scene.ply --camera-pose 0.7,-0.18,0.7,1,0,0,0 --json\n"
      "  stonestack search scene.yaml --site 0.7,0.28 --method paper\n"
      "  stonestack search scene.yaml --robot ur10 --json > next.json    # for stonestack plan --search\n"
      "  stonestack search --stones all --wall 3+2 --friction 0.3 --picture wall.png --out wall.yaml\n"
      "  stonestack search scene.yaml --wall 2+1 --robot ur10    # a wall that the arm can build\n"
      "  stonestack search --stones all --bridge 0.08 --friction 0.3 --picture bridge.png\n"
      "  stonestack search scene.ply                # a cloud alone: on the tower in view, or the best "
      "place\n"
      "A cloud without --camera-pose is taken as in the camera's frame, and the table that is seen becomes z "
      "= 0;\n"
      "or as in the world frame (z up, table at z = 0), if most of it lies about z = 0. --robot needs the "
      "camera's pose,\nor --world for a cloud in the cell's frame. A stack in a scene file is built on, from "
      "its last stone up.\nWithout --robot a stone may be turned any way up, as search.max_tilt limits "
      "what one grasp can do.\nCtrl-C ends the search with the best so far (exit code 130).");
}

}  // namespace stonestack::apps
