#include "report/plan_preview.hpp"

#include <algorithm>
#include <cmath>

#include "motion/collision.hpp"
#include "report/drawn_arm.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::report {
namespace {

using Kind = PlanStep::Kind;

const Eigen::Vector3d kMovedColour(0.80, 0.52, 0.25), kOtherColour(0.75, 0.72, 0.66);

/// Gripper motion during a step.
struct Stage {
  bool held = false, placed = false;
  double opening = 0.0;  ///< [m]
};

Stage stage_of(const PickAndPlacePlan& plan, std::size_t step) {
  Stage stage;
  for (std::size_t i = 0; i <= step; ++i) {
    const PlanStep& s = plan.steps[i];
    if (s.kind != Kind::kOpen && s.kind != Kind::kGrasp && s.kind != Kind::kRelease) continue;
    stage.held = s.kind == Kind::kGrasp;
    stage.placed = stage.placed || s.kind == Kind::kRelease;
    stage.opening = s.opening;
  }
  return stage;
}

/// The scene with the stone where it lies during a stage.
PlanningScene scene_at(PlanningScene scene, const PickAndPlaceTask& task, const Stage& stage) {
  if (task.object >= 0 && stage.placed)
    scene.objects[static_cast<std::size_t>(task.object)].T_W_object = task.T_W_O_place;
  return scene;
}

/// The gripper with its fingers as the plan wants them.
GripperModel gripper_of_plan(const PlanningScene& scene, const PickAndPlacePlan& plan) {
  return plan.spacing > 0 ? with_spacing(scene.gripper, plan.spacing) : scene.gripper;
}

CollisionChecker checker_of(PlanningScene scene, const PickAndPlaceTask& task, const PickAndPlacePlan& plan,
                            std::size_t step) {
  const Stage stage = stage_of(plan, step);
  const Kind kind = plan.steps[step].kind;
  scene.gripper = gripper_of_plan(scene, plan);
  CollisionRules rules;
  rules.opening = stage.opening;
  if (stage.held) {
    rules.left_out = task.object;
    if (kind == Kind::kLift) rules.held_may_touch = {kTableObject};
    if (kind == Kind::kDescent) rules.held_may_touch = {task.support};
    const HeldObject held{task.stone->name, task.stone->pieces, plan.T_O_T.inverse()};
    return CollisionChecker(scene, rules, &held);
  }
  if (task.object >= 0 && (kind == Kind::kApproach || kind == Kind::kRetreat))
    rules.gripper_may_touch = {task.object};
  return CollisionChecker(scene_at(scene, task, stage), rules);
}

Eigen::Vector3d tool(const PlanningScene& scene, const Joints& q) {
  return (scene.T_W_R * forward(scene.robot, q) * scene.T_F_T).translation();
}

/// When the tool is where the target wants it; the plan of a guarded descent goes further.
double contact_time(const PlanningScene& scene, const JointTrajectory& descent, double z) {
  double early = 0.0, late = descent.duration();
  if (tool(scene, descent.q.back()).z() > z) return late;
  while (late - early > 1e-6) {
    const double t = 0.5 * (early + late);
    (tool(scene, sample(descent, t).q).z() > z ? early : late) = t;
  }
  return late;
}

}  // namespace

std::vector<PlanMoment> preview(const PlanningScene& scene, const PickAndPlaceTask& task,
                                const PickAndPlacePlan& plan, double period) {
  require(plan.status == PickAndPlacePlan::Status::kPlanned, "there is no plan to preview: ", plan.reason);
  require(period > 0.0, "the period must be positive, got ", period, " s");
  std::vector<PlanMoment> moments;
  double begin = 0.0;
  for (std::size_t s = 0; s < plan.steps.size(); ++s) {
    throw_if_interrupted();
    const auto& trajectory = plan.steps[s].trajectory;
    if (trajectory.time.empty()) continue;
    const CollisionChecker checker = checker_of(scene, task, plan, s);
    const double end =
        plan.steps[s].kind == Kind::kDescent
            ? contact_time(scene, trajectory, (task.T_W_O_place * plan.T_O_T).translation().z())
            : trajectory.duration();
    const auto samples = static_cast<long>(std::ceil(end / period));
    for (long i = 0; i <= samples; ++i) {
      const double t = std::min(end, static_cast<double>(i) * period);
      const JointState state = sample(trajectory, t);
      constexpr double kStep = 1e-4;  // s, for the derivative
      const Eigen::Vector3d moved =
          tool(scene, state.q + kStep * state.qd) - tool(scene, state.q - kStep * state.qd);
      moments.push_back(
          {begin + t, s, state.q, moved.norm() / (2 * kStep), checker.clearance(state.q).distance});
    }
    begin += end;
  }
  return moments;
}

std::vector<DrawnMesh> drawn_moment(const PlanningScene& scene, const PickAndPlaceTask& task,
                                    const PickAndPlacePlan& plan, const PlanMoment& moment) {
  const Stage stage = stage_of(plan, moment.step);
  std::vector<DrawnMesh> meshes = drawn_arm(scene.robot, gripper_of_plan(scene, plan), scene.T_W_R,
                                            scene.T_F_T, {moment.q, stage.opening});
  const Pose T_W_T = scene.T_W_R * forward(scene.robot, moment.q) * scene.T_F_T;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    if (static_cast<int>(i) == task.object) continue;
    for (const auto& piece : scene.objects[i].pieces)
      meshes.push_back({piece, scene.objects[i].T_W_object, kOtherColour});
  }
  const Pose T_W_O = stage.held     ? T_W_T * plan.T_O_T.inverse()
                     : stage.placed ? task.T_W_O_place
                                    : task.T_W_O_pick;
  for (const auto& piece : task.stone->pieces) meshes.push_back({piece, T_W_O, kMovedColour});
  return meshes;
}

std::vector<PlanMoment> key_moments(const std::vector<PlanMoment>& moments) {
  std::vector<PlanMoment> keys;
  for (std::size_t i = 0; i < moments.size(); ++i)
    if (i == 0 || i + 1 == moments.size() || moments[i + 1].step != moments[i].step)
      keys.push_back(moments[i]);
  return keys;
}

}  // namespace stonestack::report
