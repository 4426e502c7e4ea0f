#pragma once
#include <string>

#include "stonestack/core/rooms.hpp"

#pragma GCC visibility push(default)

namespace stonestack::hardware {

/// State that the gripper reports. `opening` in metres between the finger pads.
struct GripperState {
  double opening = 0.155;
  bool moving = false;
  bool object = false;     ///< stopped by an object while closing
  std::string fault;       ///< empty: none
  double host_time = 0.0;  ///< s of `host_seconds`, when it was read; in a simulated cell of its clock
};

/// A gripper whose fingers close on one axis (x of T).
class Gripper {
 public:
  virtual ~Gripper() = default;
  [[nodiscard]] virtual GripperState state() = 0;
  /// Moves to an opening (m) with a speed (m/s) and force (N a finger); returns when at rest. Throws
  /// DeviceError on a fault or when it does not come to rest within its deadline.
  virtual GripperState move(double opening, double speed, double force) = 0;
  /// Brings the two fingers that stand side by side (B and C) to `spacing` (m) between their pads, with an
  /// empty hand; returns when at rest. Throws as `move`.
  virtual void spread(double spacing) = 0;
};

}  // namespace stonestack::hardware

#pragma GCC visibility pop
