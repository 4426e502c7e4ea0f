#include <algorithm>
#include <array>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "cell_input.hpp"
#include "commands.hpp"
#include "common_options.hpp"
#include "geometry/pose_json.hpp"
#include "scene_input.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/hardware/cell.hpp"
#include "stonestack/motion/pick_and_place.hpp"
#include "stonestack/report/plan_preview.hpp"
#include "stonestack/stacking/observe.hpp"

namespace stonestack::apps {
namespace {

struct PlanCommand {
  CommonOptions common;
  std::string robot;  ///< empty: the cell's, or a UR10
  std::string cell;
  std::string start;
  std::string scene;
  std::string stone;
  std::string target;
  std::string search;
  std::string csv;
  std::string plot;
  std::string frames;
  int frame_width = 640;  // pixels
  MotionOptions options;
};

/// Plan with its task; the task points into the catalogue.
struct Planned {
  PlanningScene scene;
  PickAndPlaceTask task;
  PickAndPlacePlan plan;
};

constexpr double kSamplePeriod = 0.008;  // s: the control period of a CB3
constexpr double kUnit = 1e-3;           // by which a quaternion's norm may be off
constexpr double kPlotPeriod = 0.02;     // s

const char* kind_text(PlanStep::Kind kind) {
  switch (kind) {
    case PlanStep::Kind::kOpen:
      return "open";
    case PlanStep::Kind::kTransit:
      return "transit";
    case PlanStep::Kind::kApproach:
      return "approach";
    case PlanStep::Kind::kGrasp:
      return "grasp";
    case PlanStep::Kind::kLift:
      return "lift";
    case PlanStep::Kind::kDescent:
      return "descent";
    case PlanStep::Kind::kRelease:
      return "release";
    case PlanStep::Kind::kRetreat:
      return "retreat";
  }
  return "unknown";
}

/// `path`: of the file that holds it.
NamedPose read_placement(const nlohmann::json& entry, const std::string& path) {
  const auto& t = entry.at("T_W_O");
  const auto number = [&](const char* key) { return t.at(key).get<double>(); };
  const Eigen::Quaterniond q(number("qw"), number("qx"), number("qy"), number("qz"));
  if (!(std::abs(q.norm() - 1.0) < kUnit))
    throw FileError(path, concat("a target's quaternion has the norm ", q.norm(), ", not 1"),
                    "make it with `stonestack search --json`");
  return {entry.at("stone").get<std::string>(), make_pose({number("x"), number("y"), number("z")}, q)};
}

/// Stones and targets, the first that can be carried out counts: from --stone and --target, or the first
/// placement of `search --json` and its alternatives.
std::vector<NamedPose> read_targets(const PlanCommand& command) {
  require(command.search.empty() || (command.stone.empty() && command.target.empty()),
          "--search FILE brings stone and target: --stone and --target cannot be given with it");
  if (command.search.empty()) {
    require(!command.stone.empty() && !command.target.empty(), "give --stone and --target, or --search FILE");
    return {{command.stone, parse_pose(command.target)}};
  }
  try {
    const auto json = nlohmann::json::parse(read_file(command.search, std::size_t{1} << 24));
    std::vector<NamedPose> targets{read_placement(json.at("placements").at(0), command.search)};
    if (json.contains("alternatives"))
      for (const auto& entry : json.at("alternatives"))
        targets.push_back(read_placement(entry, command.search));
    return targets;
  } catch (const nlohmann::json::exception& problem) {
    throw FileError(command.search, concat("holds no placement: ", problem.what()),
                    "make it with `stonestack search --json`");
  }
}

nlohmann::json step_json(const PlanStep& step) {
  nlohmann::json points = nlohmann::json::array();
  const auto& t = step.trajectory;
  for (std::size_t i = 0; i < t.time.size(); ++i)
    points.push_back({{"t", t.time[i]},
                      {"q", std::vector<double>(t.q[i].begin(), t.q[i].end())},
                      {"qd", std::vector<double>(t.qd[i].begin(), t.qd[i].end())}});
  return {{"kind", kind_text(step.kind)}, {"name", step.name},           {"opening", step.opening},
          {"spacing", step.spacing},      {"threshold", step.threshold}, {"trajectory", points}};
}

/// All motions one after the other, sampled at the control period.
std::string csv_text(const PickAndPlacePlan& plan) {
  const auto number = [](double value) {  // so many digits that accelerations can be told from differences
    std::array<char, 32> digits{};
    std::snprintf(digits.data(), digits.size(), ",%.12g", value);
    return std::string(digits.data());
  };
  std::string text = "step,kind,t,q0,q1,q2,q3,q4,q5,qd0,qd1,qd2,qd3,qd4,qd5\n";
  for (std::size_t s = 0; s < plan.steps.size(); ++s) {
    const auto& trajectory = plan.steps[s].trajectory;
    if (trajectory.time.empty()) continue;
    const auto samples = static_cast<long>(std::ceil(trajectory.duration() / kSamplePeriod));
    for (long i = 0; i <= samples; ++i) {
      const double t = std::min(trajectory.duration(), static_cast<double>(i) * kSamplePeriod);
      const JointState state = sample(trajectory, t);
      text += concat(s, ',', kind_text(plan.steps[s].kind)) + number(t);
      for (const double q : state.q) text += number(q);
      for (const double qd : state.qd) text += number(qd);
      text += '\n';
    }
  }
  return text;
}

/// Joint angles of --start; where the arm cannot stand is refused.
Joints parse_start(const std::string& text, const RobotModel& robot) {
  const std::vector<double> q = parse_numbers(text, 6, "q1,q2,q3,q4,q5,q6 in rad");
  const Joints joints = Eigen::Map<const Joints>(q.data());
  for (Eigen::Index i = 0; i < 6; ++i)
    require(joints[i] >= robot.lower[i] && joints[i] <= robot.upper[i], "--start: joint ", i + 1, " at ",
            joints[i], " rad is outside the limits of ", robot.name, ", ", robot.lower[i], " to ",
            robot.upper[i], " rad", std::abs(joints[i]) > 6.4 ? "; angles are in rad, not degrees" : "");
  return joints;
}

/// For the first target that can be carried out; fails with what stands in the way of each.
Planned make_plan(const PlanCommand& command, const Catalogue& catalogue,
                  const std::vector<NamedPose>& targets) {
  CellLayout layout;
  const std::string& robot_name = command.robot;
  std::optional<RobotModel> cell_robot;
  if (!command.cell.empty()) {
    const CellFile cell = read_cell(command.cell);
    require(robot_name.empty() || robot_name == cell.cell.robot, "--robot ", robot_name,
            " is not the robot of ", command.cell, ", ", cell.cell.robot);
    layout = to_layout(cell.cell);
    cell_robot = read_cell_robot(cell.cell);
  }
  const RobotModel robot = cell_robot ? *cell_robot : read_robot(robot_name.empty() ? "ur10" : robot_name);
  const Joints q_start = command.start.empty() ? home_joints() : parse_start(command.start, robot);
  const SceneFile file = read_scene_file(command.scene);
  Arrangement arrangement;
  for (const auto& item : file.stack) arrangement.stack.push_back({catalogue.index(item.stone), item.T_W_O});
  for (const auto& item : file.stones) arrangement.loose.push_back({catalogue.index(item.stone), item.T_W_O});
  const std::vector<PairPadding> cell_paddings = layout.paddings;
  layout.obstacles.insert(layout.obstacles.end(), file.obstacles.begin(), file.obstacles.end());
  for (PairPadding pair : file.paddings) {  // a scene may ask for more room than the cell, not for less
    for (const PairPadding& of_cell : cell_paddings)
      if (of_cell.b == pair.b) pair.m = std::max(pair.m, of_cell.m);
    layout.paddings.push_back(pair);
  }
  const PlanningScene scene = make_planning_scene(layout, robot, catalogue, arrangement);
  std::string refusals;
  for (const NamedPose& target : targets) {
    throw_if_interrupted();
    const int stone = catalogue.index(target.stone);
    Planned planned{scene, make_task(catalogue, arrangement, stone, target.T_W_O, q_start), {}};
    planned.plan.reason = scene_problem(planned.scene, planned.task);
    if (planned.plan.reason.empty()) {
      planned.plan = plan_pick_and_place(planned.scene, planned.task, command.options);
      if (planned.plan.status == PickAndPlacePlan::Status::kPlanned) return planned;
    }
    const std::string refusal = concat(target.stone, ": ", planned.plan.reason);
    if (refusals.find(refusal) == std::string::npos) refusals += (refusals.empty() ? "" : "; ") + refusal;
  }
  throw Error(concat("no plan: ", refusals,
                     command.search.empty()
                         ? ""
                         : "; `search --robot` offers poses that the arm reaches, `run` turns stones over"),
              ExitCode::kExecutionFailed);
}

/// One PNG for the start and for the end of each motion: frames/00_start.png, 01_transit.png, ...
void write_frames(const PlanCommand& command, const Planned& planned,
                  const std::vector<PlanMoment>& moments) {
  View view;
  view.p_W_eye = {2.1, -1.5, 1.1};
  view.p_W_target = {0.45, 0.05, 0.35};
  view.width = command.frame_width;
  view.height = 3 * command.frame_width / 4;
  const auto keys = key_moments(moments);
  for (std::size_t i = 0; i < keys.size(); ++i) {
    throw_if_interrupted();
    const auto& step = planned.plan.steps[keys[i].step];
    const std::string path = concat(command.frames, '/', i < 10 ? "0" : "", i, '_',
                                    i == 0 ? "start" : kind_text(step.kind), ".png");
    write_png(path, draw(drawn_moment(planned.scene, planned.task, planned.plan, keys[i]), view));
  }
}

void write_files(const PlanCommand& command, const Planned& planned) {
  if (!command.csv.empty()) write_file(command.csv, csv_text(planned.plan));
  if (command.plot.empty() && command.frames.empty()) return;
  const auto moments = preview(planned.scene, planned.task, planned.plan, kPlotPeriod);
  if (!command.plot.empty()) write_file(command.plot, plan_plot(planned.plan, moments));
  if (!command.frames.empty()) write_frames(command, planned, moments);
}

void plan(PlanCommand& command) {
  command.common.begin();
  command.options.seed = command.common.seed;
  command.common.settings.apply(nest("motion", fields(command.options)));
  const auto targets = read_targets(command);
  require_readable(command.scene);
  for (const std::string& path : {command.csv, command.plot})
    if (!path.empty()) require_writable(path);
  if (!command.frames.empty()) require_writable(command.frames + "/00_start.png");
  const Catalogue catalogue = command.common.read();
  const Planned planned = make_plan(command, catalogue, targets);
  const PickAndPlacePlan& plan = planned.plan;
  write_files(command, planned);
  if (command.common.json) {
    nlohmann::json steps = nlohmann::json::array();
    for (const auto& step : plan.steps) steps.push_back(step_json(step));
    std::cout << nlohmann::json{{"schema", "stonestack.plan/1"},
                                {"stone", planned.task.stone->name},
                                {"T_W_O", pose_json(planned.task.T_W_O_place)},
                                {"steps", steps},
                                {"T_O_T", pose_json(plan.T_O_T)},
                                {"seconds", plan.seconds}}
                     .dump(1)
              << '\n';
    return;
  }
  const auto& p_W = planned.task.T_W_O_place.translation();
  std::printf("%s to %.3f, %.3f, %.3f\n", planned.task.stone->name.c_str(), p_W.x(), p_W.y(), p_W.z());
  for (const auto& step : plan.steps)
    std::printf("%-10s %6.2f s  %s\n", kind_text(step.kind), step.trajectory.duration(), step.name.c_str());
  std::printf("%.1f s of motion\n", plan.seconds);
}

}  // namespace

void add_plan(CLI::App& app) {
  auto command = std::make_shared<PlanCommand>();
  CLI::App* sub = app.add_subcommand("plan", "Plan grasp and motion for one stone");
  sub->add_option("SCENE", command->scene,
                  "Scene file with the stones' poses and, if there are any, obstacles")
      ->required();
  sub->add_option("--robot", command->robot,
                  "Robot name, URDF, or YAML of a calibrated robot (default: the cell's, or ur10)");
  sub->add_option(
         "--cell", command->cell,
         "Cell file, or the name of one that comes with stonestack: takes its robot and layout (mounts, "
         "masses, obstacles, padding)")
      ->type_name("FILE");
  sub->add_option("--start", command->start,
                  "Where the arm stands: q1,q2,q3,q4,q5,q6 in rad (default: where a run begins)");
  sub->add_option("--stone", command->stone, "Which stone to move");
  sub->add_option("--target", command->target, "T_W_O to bring it to: x,y,z,qx,qy,qz,qw");
  sub->add_option(
      "--search", command->search,
      "Take stone and target from this output of `search --json`; its alternatives if the first fails");
  command->common.settings.bind(sub->add_option("--jerk", command->options.jerk,
                                                "Limit every joint's jerk, rad/s^3 (default: no limit)")
                                    ->check(CLI::Range(1.0, 10000.0)),
                                "motion.jerk");
  sub->add_option("--csv", command->csv, "Write the trajectories, sampled every 8 ms");
  sub->add_option("--plot", command->plot, "Write joints, tool speed and clearance over time as SVG");
  sub->add_option("--frames", command->frames, "Write pictures of the key frames (PNG) into this folder");
  sub->add_option("--frame-width", command->frame_width, "Width of these pictures, pixels")
      ->check(CLI::Range(64, 4096))
      ->capture_default_str();
  command->common.register_on(*sub);
  sub->footer(
      "Examples:\n"
      "  stonestack render --out scene --seed 1\n"
      "  stonestack search scene/scene.yaml --robot ur10 --json > next.json\n"
      "  stonestack plan scene/scene.yaml --search next.json --csv motion.csv\n"
      "  stonestack plan scene/scene.yaml --search next.json --plot motion.svg --frames frames\n"
      "  stonestack plan scene/scene.yaml --search next.json --cell my_lab.yaml --start "
      "0.3,-1.75,1.85,-1.67,-1.57,0\n"
      "  stonestack plan scene/scene.yaml --stone limestone_3 --target 0.7,0.28,0.06,0,0,0,1 --json");
  sub->callback([command] { plan(*command); });
}

}  // namespace stonestack::apps
