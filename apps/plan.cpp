#include <cmath>
#include <iostream>

#include "commands.hpp"
#include "common_options.hpp"
#include "scene_input.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/emulators/simulated_servers.hpp"
#include "stonestack/report/results.hpp"
#include "stonestack/stacking/observe.hpp"

namespace stonestack::apps {
namespace {

struct PlanCommand {
  CommonOptions common;
  std::string robot;  ///< empty: the cell's, or a UR10
  std::string cell, gripper, start, scene, stone, target, search, csv, plot, frames;
  int frame_width = 640;  // pixels
  MotionOptions options;
};

/// Stones and targets, the first that can be carried out counts: from --stone and --target, or the first
/// placement of `search --json` and its alternatives.
std::vector<NamedPose> targets(const PlanCommand& command) {
  require(command.search.empty() || (command.stone.empty() && command.target.empty()),
          "--search FILE brings stone and target: --stone and --target cannot be given with it");
  if (!command.search.empty()) return read_search_targets(command.search);
  require(!command.stone.empty() && !command.target.empty(), "give --stone and --target, or --search FILE");
  return {{command.stone, parse_pose(command.target)}};
}

/// Joint angles of --start; a configuration outside the joint limits is refused.
Joints parse_start(const std::string& text, const RobotModel& robot) {
  const std::vector<double> q = parse_numbers(text, 6, "q1,q2,q3,q4,q5,q6 in rad");
  const Joints joints = Eigen::Map<const Joints>(q.data());
  for (Eigen::Index i = 0; i < 6; ++i)
    require(joints[i] >= robot.lower[i] && joints[i] <= robot.upper[i], "--start: joint ", i + 1, " at ",
            joints[i], " rad is outside the limits of ", robot.name, ", ", robot.lower[i], " to ",
            robot.upper[i], " rad", std::abs(joints[i]) > 6.4 ? "; angles are in rad, not degrees" : "");
  return joints;
}

/// Robot, layout and start of the arm.
void set_cell(const PlanCommand& command, ScenePlanTask& task) {
  if (command.cell.empty()) {
    task.robot = read_robot(command.robot.empty() ? "ur10" : command.robot);
  } else {
    const CellFile file = read_cell(command.cell);
    require(command.robot.empty() || command.robot == file.robot(), "--robot ", command.robot,
            " is not the robot of ", command.cell, ", ", file.robot());
    task.layout = to_layout(file.cell());
    task.robot = read_cell_robot(file.cell());
  }
  task.layout = with_option_gripper(task.layout, command.gripper, !command.cell.empty());
  task.q_start = command.start.empty() ? home_joints() : parse_start(command.start, task.robot);
}

void plan(PlanCommand& command) {
  command.options.seed = command.common.seed;
  command.common.settings.apply(
      join({nest("motion", fields(command.options)), nest("gripper", {gripper_field(command.gripper)})}));
  ScenePlanTask task;
  task.scene = command.scene;
  task.options = command.options;
  task.targets = targets(command);
  require_readable(command.scene);
  for (const std::string& path : {command.csv, command.plot})
    if (!path.empty()) require_writable(path);
  if (!command.frames.empty()) require_writable(command.frames + "/00_start.png");
  const Catalogue catalogue = command.common.read();
  set_cell(command, task);
  const ScenePlan planned = plan_in_scene(task, catalogue);
  if (planned.plan.status != PickAndPlacePlan::Status::kPlanned)
    throw Error(concat("no plan: ", planned.plan.reason,
                       command.search.empty()
                           ? ""
                           : "; `search --robot` offers poses that the arm reaches, `run` turns stones over"),
                ExitCode::kExecutionFailed);
  if (!command.csv.empty()) write_file(command.csv, plan_csv(planned));
  if (!command.plot.empty()) plot_plan(command.plot, planned);
  if (!command.frames.empty()) draw_plan(command.frames, planned, command.frame_width);
  std::cout << (command.common.json ? plan_json(planned) : plan_table(planned));
}

}  // namespace

void add_plan(CLI::App& app) {
  const auto [sub, command] =
      add_subcommand<PlanCommand>(app, "plan", "Plan grasp and motion for one stone", plan);
  sub.add_option("SCENE", command.scene, "Scene file with the stones' poses and, if there are any, obstacles")
      ->required();
  sub.add_option("--robot", command.robot,
                 "Robot name, URDF, or YAML of a calibrated robot (default: the cell's, or ur10)");
  add_path(sub, "--cell", command.cell,
           "Cell file, or the name of one that comes with stonestack: takes its robot and layout (mounts, "
           "masses, obstacles, padding)");
  sub.add_option("--start", command.start,
                 "Start configuration of the arm: q1,q2,q3,q4,q5,q6 in rad (default: where a run begins)");
  sub.add_option("--stone", command.stone, "Which stone to move");
  sub.add_option("--target", command.target, "T_W_O to bring it to: x,y,z,qx,qy,qz,qw");
  sub.add_option(
      "--search", command.search,
      "Take stone and target from this output of `search --json`; its alternatives if the first fails");
  command.common.settings.bind(
      sub.add_option("--jerk", command.options.jerk, "Limit every joint's jerk, rad/s^3 (default: no limit)")
          ->check(CLI::Range(1.0, 10000.0)),
      "motion.jerk");
  sub.add_option("--csv", command.csv, "Write the trajectories, sampled every 8 ms");
  sub.add_option("--plot", command.plot, "Write joints, tool speed and clearance over time as SVG");
  sub.add_option("--frames", command.frames, "Write pictures of the key frames (PNG) into this folder");
  sub.add_option("--frame-width", command.frame_width, "Width of these pictures, pixels")
      ->check(CLI::Range(64, 4096))
      ->capture_default_str();
  command.common.register_on(sub);
  sub.footer(
      "Examples:\n"
      "  stonestack render --out scene --seed 1\n"
      "  stonestack search scene/scene.yaml --robot ur10 --json > next.json\n"
      "  stonestack plan scene/scene.yaml --search next.json --csv motion.csv\n"
      "  stonestack plan scene/scene.yaml --search next.json --plot motion.svg --frames frames\n"
      "  stonestack plan scene/scene.yaml --search next.json --cell my_lab.yaml --start "
      "0.3,-1.75,1.85,-1.67,-1.57,0\n"
      "  stonestack plan scene/scene.yaml --stone limestone_3 --target 0.7,0.28,0.06,0,0,0,1 --json");
}

}  // namespace stonestack::apps
