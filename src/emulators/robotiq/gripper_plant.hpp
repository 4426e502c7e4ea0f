#pragma once
#include <array>
#include <atomic>
#include <memory>

#include "stonestack/core/options.hpp"

namespace stonestack::simulation {
class SharedWorld;
}

namespace stonestack::emulators {

/// Axes of the 3-finger gripper, in the order of every array: fingers A, B, C, and the scissor.
inline constexpr int kGripperAxes = 4;

/// Command of the gripper's controller to one axis. Counts: 0 open to 255 closed.
struct AxisCommand {
  bool go = false;      ///< false: stay where it is
  double target = 0.0;  ///< counts
  double speed = 0.0;   ///< counts/s
  double force = 0.0;   ///< [N]
};

/// State of one axis.
struct AxisReport {
  enum class Status { kMoving, kContactOpening, kContactClosing, kAtRequest };
  double position = 0.0;  ///< counts
  Status status = Status::kAtRequest;
  double current = 0.0;  ///< A
};

/// The mechanics behind a simulated gripper's registers. Called by one thread at a time.
class GripperPlant {
 public:
  virtual ~GripperPlant() = default;
  virtual void command(const std::array<AxisCommand, kGripperAxes>& axes) = 0;
  /// Where the axes are after `seconds` more.
  virtual std::array<AxisReport, kGripperAxes> advance(double seconds) = 0;
};

/// Fingers that move at once with constant speed, and stop at obstacles.
struct IdealGripperOptions {
  double min_count = 6.0;        ///< position [counts], software limit when open
  double max_count = 241.0;      ///< position [counts], when closed
  double scissor = 137.0;        ///< position [counts], where it starts
  double moving_current = 0.15;  ///< A
};
[[nodiscard]] FieldList fields(IdealGripperOptions& options);

class IdealGripperPlant final : public GripperPlant {
 public:
  explicit IdealGripperPlant(const IdealGripperOptions& options = {});
  void command(const std::array<AxisCommand, kGripperAxes>& axes) override;
  std::array<AxisReport, kGripperAxes> advance(double seconds) override;
  /// Something stands where each axis cannot pass: closing stops there; 255 or more: nothing there.
  /// Thread-safe.
  void set_obstacles(const std::array<double, kGripperAxes>& closing);

 private:
  IdealGripperOptions options_;
  std::array<std::atomic<double>, kGripperAxes> obstacle_;
  std::array<AxisCommand, kGripperAxes> command_{};
  std::array<AxisReport, kGripperAxes> report_{};
};

/// Positions of a gripper in counts.
struct GripperCounts {
  double open = 0.0;      ///< fully open
  double closed = 255.0;  ///< where the pads meet
  double min = 6.0;       ///< where the software limit of a real gripper ends opening
};
/// The fingers of a simulated cell; the scissor moves freely. Drives them as long as it lives. The world must
/// outlive it.
[[nodiscard]] std::unique_ptr<GripperPlant> make_world_gripper(SharedWorld& world,
                                                               const GripperCounts& counts = {});

}  // namespace stonestack::emulators
