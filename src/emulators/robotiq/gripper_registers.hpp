#pragma once
#include <array>
#include <cstdint>
#include <span>

#include "emulators/robotiq/gripper_plant.hpp"
#include "emulators/robotiq/gripper_simulator.hpp"

namespace stonestack::emulators {

/// The controller inside the gripper: command registers in, status registers out, axes moved by a plant.
/// Robotiq 3-finger instruction manual, "Control"; times that it does not give are design choices.
class GripperRegisters {
 public:
  static constexpr int kCount = 8;  ///< registers each way
  using Words = std::array<std::uint16_t, kCount>;

  explicit GripperRegisters(GripperPlant& plant) : plant_(&plant) {}
  /// A master writes command registers [first, first + values).
  void write(int first, std::span<const std::uint16_t> values);
  void advance(double seconds);
  [[nodiscard]] Words status() const;
  [[nodiscard]] Words commands() const;
  void set_faults(const GripperFaults& faults) { faults_ = faults; }

 private:
  enum class Phase { kReset, kActivating, kModeChange, kReady, kReleasing, kReleased };
  using Bytes = std::array<std::uint8_t, 2 * kCount>;

  void start_activation();
  void await_motion();
  void advance_activation();
  void advance_mode();
  void accept();
  void command_plant();
  [[nodiscard]] std::array<AxisCommand, kGripperAxes> requested() const;
  [[nodiscard]] bool moving() const;
  [[nodiscard]] int fault_code() const;
  [[nodiscard]] int axis_status(std::size_t axis) const;
  [[nodiscard]] int motion_status() const;

  GripperPlant* plant_;
  GripperFaults faults_;
  Bytes written_{};   // by the master
  Bytes accepted_{};  // what the controller acts upon and echoes
  double since_write_ = 0.0;
  Phase phase_ = Phase::kReset;
  int stage_ = 0;  // of the activation: open, close, open
  double in_stage_ = 0.0;
  int mode_ = 0;
  double slipped_ = 0.0;  // counts
  std::array<AxisReport, kGripperAxes> axes_{};
};

}  // namespace stonestack::emulators
