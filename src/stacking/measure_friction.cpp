#include "stacking/measure_friction.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "motion/cartesian.hpp"
#include "motion/timing.hpp"
#include "stacking/plan_executor.hpp"
#include "stacking/record.hpp"

namespace stonestack::stacking {
namespace {

// Along the tool's x axis, on which the fingers close, from where the stone touched: there and back, with two
// readings each, the first of which follows more sliding than the pads yield (1 mm).
constexpr double kDragged[] = {0.008, 0.016, 0.008, 0.000};  // m
constexpr std::size_t kThere = 2;                            // readings of the way there
constexpr double kDragSpeed = 0.020;                         // m/s
constexpr double kMinPress = 1.5;                            // N: less says nothing
constexpr double kMaxDrag = 25.0;                            // N: whatever resists that much is no table
constexpr double kMaxDifference = 0.25;                      // between two readings of one direction

using Status = ExecutionResult::Status;

}  // namespace

std::optional<double> friction_of_drag(const std::vector<double>& there, const std::vector<double>& back) {
  if (there.empty() || back.empty()) return std::nullopt;
  const auto mean = [](const std::vector<double>& ratios) {
    double sum = 0.0;
    for (const double ratio : ratios) sum += ratio;
    return sum / static_cast<double>(ratios.size());
  };
  for (const auto* ratios : {&there, &back}) {
    const auto [low, high] = std::minmax_element(ratios->begin(), ratios->end());
    if (*high - *low > kMaxDifference) return std::nullopt;
  }
  // Slope of the table and error of the tare count with opposite signs.
  const double friction = 0.5 * (mean(there) - mean(back));
  return friction > 0 ? std::optional(friction) : std::nullopt;
}

ExecutionResult PlanExecutor::measure_friction() const {
  record(journal, StepBegun{"drag " + stone.name});
  const Pose T_R_T = forward(scene.robot, cell.arm.state().q) * scene.T_F_T;
  Eigen::Vector3d n_W_drag = (cell.layout.T_W_R * T_R_T).linear().col(0);
  n_W_drag.z() = 0.0;
  n_W_drag.normalize();
  const Eigen::Vector3d n_R_drag = cell.layout.T_W_R.linear().transpose() * n_W_drag;
  TimingLimits limits = timing_limits(scene.robot, options);
  limits.tool_speed = kDragSpeed;
  std::vector<double> there, back;
  double along = 0.0;
  Eigen::Vector3d f_W = wrist.force_W();
  for (std::size_t i = 0; i < std::size(kDragged); ++i) {
    const Pose T_R_T_goal = Eigen::Translation3d(kDragged[i] * n_R_drag) * T_R_T;
    const auto path = straight_path(scene.robot, scene.T_F_T, cell.arm.state().q, T_R_T_goal);
    if (!path) return {};
    GuardedMotion drag;
    drag.trajectory = time_path(*path, limits, scene.robot, scene.T_F_T);
    drag.n_W_direction = kDragged[i] > along ? n_W_drag : Eigen::Vector3d(-n_W_drag);
    drag.threshold = kMaxDrag;
    along = kDragged[i];
    const MotionResult moved = cell.arm.follow_guarded(drag);
    if (moved.status == MotionResult::Status::kContact) return {};
    if (moved.status != MotionResult::Status::kNoContact)
      return {Status::kStopped, moved.force, "dragging " + stone.name + ": " + moved.reason};
    // The guard's force is the one above its start. Only the moving arm feels all: a stone that sticks and
    // slips lets go of a part when it stops.
    const double resistance = moved.mean_force - f_W.dot(drag.n_W_direction);
    const double press_before = f_W.z();
    f_W = wrist.force_W();
    const double press = 0.5 * (press_before + f_W.z());
    if (press < kMinPress) continue;
    if (i < kThere)
      there.push_back(resistance / press);
    else
      back.push_back(-resistance / press);
  }
  ExecutionResult result;
  result.friction = friction_of_drag(there, back);
  return result;
}

}  // namespace stonestack::stacking
