#include "stonestack/motion/regrasp.hpp"

#include <algorithm>
#include <limits>
#include <numbers>

#include "stonestack/core/error.hpp"
#include "stonestack/motion/collision.hpp"
#include "stonestack/motion/grasp_check.hpp"

namespace stonestack {
namespace {

/// The stone with orientation R_W_O on the table, its centre of mass above `at`.
Pose standing(const Stone& stone, const Eigen::Quaterniond& R_W_O, const Eigen::Vector2d& at,
              double table_z) {
  double lowest = std::numeric_limits<double>::infinity();
  for (const auto& v : stone.scan.vertices) lowest = std::min(lowest, (R_W_O * v).z());
  const Eigen::Vector3d p_W_M = R_W_O * stone.mass.p_O_M;
  return make_pose({at.x() - p_W_M.x(), at.y() - p_W_M.y(), table_z - lowest}, R_W_O);
}

/// A circle seen from above around things.
struct Footprint {
  Eigen::Vector2d centre;
  double radius = 0.0;
};

Footprint footprint(const std::vector<Mesh>& pieces, const Pose& T_W_object) {
  Eigen::AlignedBox2d box;
  for (const auto& piece : pieces)
    for (const auto& v : piece.vertices) box.extend((T_W_object * v).head<2>());
  Footprint print{box.center(), 0.0};
  for (const auto& piece : pieces)
    for (const auto& v : piece.vertices)
      print.radius = std::max(print.radius, ((T_W_object * v).head<2>() - print.centre).norm());
  return print;
}

bool has_room(const PlanningScene& scene, const PickAndPlaceTask& task, const Pose& T_W_O, double apart) {
  const Footprint own = footprint(task.stone->pieces, T_W_O);
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    if (static_cast<int>(i) == task.object || scene.objects[i].pieces.empty()) continue;
    const Footprint other = footprint(scene.objects[i].pieces, scene.objects[i].T_W_object);
    if ((own.centre - other.centre).norm() < own.radius + other.radius + apart) return false;
  }
  return true;
}

/// Where the stone could be set down: in every other pose of rest, turned about the vertical, first where it
/// lies, then beside.
std::vector<Pose> places(const PlanningScene& scene, const PickAndPlaceTask& task,
                         const RegraspOptions& regrasp) {
  const Eigen::Vector2d here = (task.T_W_O_pick * task.stone->mass.p_O_M).head<2>();
  const auto rests = rest_orientations(*task.stone, regrasp);
  std::vector<Pose> all;
  for (const Eigen::Vector2d& side : {Eigen::Vector2d(0, 0), Eigen::Vector2d(0, 1), Eigen::Vector2d(0, -1),
                                      Eigen::Vector2d(1, 0), Eigen::Vector2d(-1, 0)}) {
    for (const auto& rest : rests) {
      for (int k = 0; k < regrasp.turns; ++k) {
        const Eigen::AngleAxisd turn(2 * std::numbers::pi * k / regrasp.turns, Eigen::Vector3d::UnitZ());
        const Pose T = standing(*task.stone, turn * rest, here + regrasp.beside * side, scene.table_z);
        if (has_room(scene, task, T, regrasp.apart)) all.push_back(T);
      }
    }
  }
  return all;
}

/// The second half of the task, and the scene in which it begins.
PickAndPlaceTask onward(const PickAndPlaceTask& task, const Pose& T_W_O_between, const Joints& q_start) {
  PickAndPlaceTask second = task;
  second.T_W_O_pick = T_W_O_between;
  second.q_start = q_start;
  return second;
}
PlanningScene with_stone_at(PlanningScene scene, const PickAndPlaceTask& task, const Pose& T_W_O) {
  if (task.object >= 0) scene.objects[static_cast<std::size_t>(task.object)].T_W_object = T_W_O;
  return scene;
}

/// Both plans over one place; says in `reason` which half has none.
RegraspPlan both_plans(const PlanningScene& scene, const PickAndPlaceTask& task, const Pose& T_W_O_between,
                       const MotionOptions& options) {
  using Status = PickAndPlacePlan::Status;
  RegraspPlan plan;
  plan.T_W_O_between = T_W_O_between;
  PickAndPlaceTask aside = task;
  aside.T_W_O_place = T_W_O_between;
  aside.support = kTableObject;
  plan.first = plan_pick_and_place(scene, aside, options);
  if (plan.first.status != Status::kPlanned) {
    plan.reason = "setting it down: " + plan.first.reason;
    return plan;
  }
  const Joints q = plan.first.steps.back().trajectory.q.back();
  plan.second =
      plan_pick_and_place(with_stone_at(scene, task, T_W_O_between), onward(task, T_W_O_between, q), options);
  plan.planned = plan.second.status == Status::kPlanned;
  if (!plan.planned) plan.reason = "after setting it down: " + plan.second.reason;
  return plan;
}

}  // namespace

FieldList fields(RegraspOptions& o) {
  return {field("rest_margin", o.rest_margin, {0, 0.1}, "m", "ours: a stone set down a little askew stays"),
          field("flat", o.flat, {0, 0.02}, "m", "ours"),
          field("turns", o.turns, {1, 64}, "", "ours"),
          field("beside", o.beside, {0, 0.5}, "m", "ours"),
          field("apart", o.apart, {0, 0.2}, "m", "ours"),
          field("attempts", o.attempts, {1, 1000}, "", "ours")};
}

RegraspPlan plan_regrasp(const PlanningScene& scene, const PickAndPlaceTask& task,
                         const MotionOptions& options, const RegraspOptions& regrasp) {
  const GraspFinder lying(scene, *task.stone, task.object, task.T_W_O_pick, options);
  RegraspPlan last;
  const auto candidates = places(scene, task, regrasp);
  int attempts = 0, served = 0;
  for (const Pose& T_W_O_between : candidates) {
    throw_if_interrupted();
    if (attempts >= regrasp.attempts) break;
    if (!lying.serves(T_W_O_between)) continue;
    ++served;
    const PlanningScene then = with_stone_at(scene, task, T_W_O_between);
    const GraspFinder anew(then, *task.stone, task.object, T_W_O_between, options);
    if (!anew.serves(task.T_W_O_place)) continue;
    ++attempts;
    last = both_plans(scene, task, T_W_O_between, options);
    if (last.planned) return last;
  }
  last.reason = concat(task.stone->name, ": of ", candidates.size(), " places to set it down ", served,
                       " tried can be reached with a grasp, ", attempts, " also serve the target",
                       last.reason.empty() ? "" : "; ", last.reason);
  return last;
}

}  // namespace stonestack
