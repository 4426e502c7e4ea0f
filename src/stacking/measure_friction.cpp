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
constexpr double kDragged[] = {0.004, 0.007, 0.003, 0.000};  // m
constexpr std::size_t kThere = 2;                            // readings of the way there
constexpr double kDragSpeed = 0.010;                         // m/s
constexpr double kMinPress = 1.5;                            // N: less says nothing
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

ExecutionResult PlanExecutor::measure_friction(const PlanStep& step) const {
  const Joints q = cell.arm.state().q;
  const Pose T_R_T = forward(scene.robot, q) * scene.T_F_T;
  Eigen::Vector3d n_W_drag = (cell.layout.T_W_R * T_R_T).linear().col(0);
  n_W_drag.z() = 0.0;
  n_W_drag.normalize();
  const Eigen::Vector3d n_R_drag = cell.layout.T_W_R.linear().transpose() * n_W_drag;
  TimingLimits limits = timing_limits(scene.robot, options);
  limits.tool_speed = kDragSpeed;
  std::vector<double> there, back;
  for (std::size_t i = 0; i < std::size(kDragged); ++i) {
    const Pose T_R_T_goal = Eigen::Translation3d(kDragged[i] * n_R_drag) * T_R_T;
    const auto path = straight_path(scene.robot, scene.T_F_T, cell.arm.state().q, T_R_T_goal);
    if (!path) return {};
    PlanStep drag = step;
    drag.name = "drag " + stone.name;
    drag.trajectory = time_path(*path, limits, scene.robot, scene.T_F_T);
    if (const ExecutionResult moved = follow(drag); moved.status == Status::kStopped) return moved;
    const Eigen::Vector3d f_W = wrist.force_W();
    if (f_W.z() < kMinPress) continue;
    (i < kThere ? there : back).push_back(-f_W.dot(n_W_drag) / f_W.z());
  }
  ExecutionResult result;
  result.friction = friction_of_drag(there, back);
  return result;
}

}  // namespace stonestack::stacking
