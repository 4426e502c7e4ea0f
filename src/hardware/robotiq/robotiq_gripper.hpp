#pragma once
#include "stonestack/hardware/devices.hpp"

namespace stonestack::hardware {

/// A gripper of Robotiq: it must be activated before it moves.
class RobotiqGripper : public Gripper {
 public:
  /// Opens and closes the fingers fully, after a reset when there is a major fault. With an empty gripper
  /// only.
  virtual void activate() = 0;
  [[nodiscard]] virtual bool is_active() = 0;
};

}  // namespace stonestack::hardware
