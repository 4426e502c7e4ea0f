#include <algorithm>
#include <cmath>

#include "core/constants.hpp"
#include "motion/constants.hpp"
#include "motion/path/tool_speed.hpp"
#include "motion/pick_and_place/pick_attempt.hpp"
#include "motion/timing.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::motion {
namespace {

constexpr double kMinForce = 50.0;  ///< the 3-finger gripper can do 15 to 60 N a finger, others more [N]

using Kind = PlanStep::Kind;

PlanStep gripper_step(Kind kind, std::string name, double opening, double speed) {
  PlanStep step;
  step.kind = kind;
  step.name = std::move(name);
  step.opening = opening;
  step.finger_speed = speed;
  return step;
}

/// Sufficient for the stone's weight at both ends, with the factor that grasps were judged by.
double close_force(const PlanningScene& scene, const PickAndPlaceTask& task, const Grasp& grasp) {
  double force = kMinForce;
  for (const Pose& T_W_O : {task.T_W_O_pick, task.T_W_O_place}) {
    const Eigen::Vector3d n_T_down = -(T_W_O * grasp.T_O_T).linear().row(2).transpose();
    force = std::max(force, GraspOptions{}.force_factor *
                                holding_force(grasp, kGravity * task.stone->mass.mass, n_T_down));
  }
  return std::min(force, scene.gripper.force);
}

/// Distance from the tool's tip to the furthest point of the held stone [m].
double reach_of(const Stone& stone, const Grasp& grasp) {
  const Pose T_T_O = grasp.T_O_T.inverse();
  double reach = 0.0;
  for (const Mesh& piece : stone.pieces)
    for (const auto& v : piece.vertices) reach = std::max(reach, (T_T_O * v).norm());
  return reach;
}

/// Writes the steps one after the other; motions are timed as they are added.
class StepWriter {
 public:
  StepWriter(const PlanningScene& scene, const MotionOptions& options)
      : scene_(scene), limits_(timing_limits(scene.robot, options)) {}

  void gripper(PlanStep step) { steps_.push_back(std::move(step)); }
  void transit(std::string name, const Transit& transit, const ToolSpeed& tool_speed) {
    TimingLimits limits = limits_;
    limits.blend = transit.blend;
    add(Kind::kTransit, std::move(name),
        time_path(transit.path, limits, scene_.robot, scene_.T_F_T, tool_speed));
  }
  void straight(Kind kind, std::string name, const JointPath& path, double tool_speed) {
    TimingLimits limits = limits_;
    limits.tool_speed = tool_speed;
    limits.blend = kStraightBlend;
    add(kind, std::move(name), time_path(path, limits, scene_.robot, scene_.T_F_T));
  }
  [[nodiscard]] std::vector<PlanStep>& steps() { return steps_; }

 private:
  /// Blend [rad]: waypoints of a straight motion lie so that cutting their corners moves the tool by less
  /// than 0.5 mm.
  static constexpr double kStraightBlend = 0.0003;

  void add(Kind kind, std::string name, JointTrajectory trajectory) {
    PlanStep step;
    step.kind = kind;
    step.name = std::move(name);
    step.trajectory = std::move(trajectory);
    steps_.push_back(std::move(step));
  }
  const PlanningScene& scene_;
  TimingLimits limits_;
  std::vector<PlanStep> steps_;
};

}  // namespace

double contact_threshold(double mass, const MotionOptions& options) {
  require(std::isfinite(mass) && mass > 0, "a stone's mass must be positive, got ", mass, " kg");
  return std::max({options.min_threshold, 6 * options.force_noise, kThresholdShare * kGravity * mass});
}

std::vector<PlanStep> timed_steps(const PlanningScene& scene, const PickAndPlaceTask& task,
                                  const MotionOptions& options, const Grasp& grasp, const PickPaths& paths) {
  const std::string& name = task.stone->name;
  StepWriter out(scene, options);
  out.gripper(gripper_step(Kind::kOpen, "open the gripper", grasp.pre_opening, kFingerSpeed));
  out.steps().back().spacing = grasp.spacing;
  out.transit("move to " + name, paths.to_pick, transit_speed(scene, options));
  out.straight(Kind::kApproach, "approach " + name, paths.approach,
               std::min(options.approach_speed, kGuardedSpeed));
  out.steps().back().threshold = options.early_threshold;
  out.gripper(gripper_step(Kind::kGrasp, "grasp " + name, grasp.opening, kGripSpeed));
  out.steps().back().force = close_force(scene, task, grasp);
  out.straight(Kind::kLift, "lift " + name, paths.lift, options.approach_speed);
  out.transit("carry " + name + " above its place", paths.carry,
              transit_speed(scene, options, task.object, reach_of(*task.stone, grasp)));
  out.straight(Kind::kApproach, "lower " + name, paths.lower, options.approach_speed);
  out.steps().back().threshold = options.early_threshold;
  out.straight(Kind::kDescent, "set " + name + " down", paths.descent, options.descent_speed);
  out.steps().back().threshold = contact_threshold(task.stone->mass.mass, options);
  const double loose = std::min(grasp.pre_opening, grasp.opening + kLoosen);
  out.gripper(gripper_step(Kind::kRelease, "let go of " + name, loose, kGripSpeed));
  out.gripper(gripper_step(Kind::kRelease, "open the gripper", grasp.pre_opening, kFingerSpeed));
  out.straight(Kind::kRetreat, "retreat from " + name, paths.retreat, options.approach_speed);
  return std::move(out.steps());
}

}  // namespace stonestack::motion
