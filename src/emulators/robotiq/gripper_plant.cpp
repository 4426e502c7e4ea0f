#include "stonestack/emulators/robotiq/gripper_plant.hpp"

#include <algorithm>
#include <cmath>

#include "stonestack/core/error.hpp"

namespace stonestack::emulators {

FieldList fields(IdealGripperOptions& o) {
  const FieldRange count{0.0, 255.0};
  return {
      field("min_count", o.min_count, count, "count", "Robotiq manual: open reports 6 to 7"),
      field("max_count", o.max_count, count, "count", "ours"),
      field("scissor", o.scissor, count, "count", "Robotiq manual: 0x89 in basic mode"),
      field("moving_current", o.moving_current, {0.0, 2.5}, "A", "Robotiq manual: 0x0F counts"),
  };
}

IdealGripperPlant::IdealGripperPlant(const IdealGripperOptions& options) : options_(options) {
  require(options.min_count < options.max_count, "the fingers need a stroke, got counts ", options.min_count,
          " to ", options.max_count);
  for (auto& obstacle : obstacle_) obstacle = 256.0;
  for (std::size_t i = 0; i < 3; ++i) report_[i].position = options.min_count;
  report_[3].position = options.scissor;
}

void IdealGripperPlant::command(const std::array<AxisCommand, kGripperAxes>& axes) {
  command_ = axes;
}

void IdealGripperPlant::set_obstacles(const std::array<double, kGripperAxes>& closing) {
  for (std::size_t i = 0; i < closing.size(); ++i) obstacle_[i] = closing[i];
}

std::array<AxisReport, kGripperAxes> IdealGripperPlant::advance(double seconds) {
  for (std::size_t i = 0; i < report_.size(); ++i) {
    AxisReport& axis = report_[i];
    axis.current = 0.0;
    if (!command_[i].go) continue;
    const bool finger = i < 3;
    const double target = finger ? std::clamp(command_[i].target, options_.min_count, options_.max_count)
                                 : std::clamp(command_[i].target, 0.0, 255.0);
    const double reach =
        target > axis.position ? std::max(axis.position, std::min(target, obstacle_[i].load())) : target;
    const double remaining = reach - axis.position, step = command_[i].speed * seconds;
    axis.position = std::abs(remaining) <= step ? reach : axis.position + std::copysign(step, remaining);
    if (axis.position != reach) {
      axis.status = AxisReport::Status::kMoving;
      axis.current = options_.moving_current;
    } else {
      axis.status = reach < target ? AxisReport::Status::kContactClosing : AxisReport::Status::kAtRequest;
    }
  }
  return report_;
}

}  // namespace stonestack::emulators
