#pragma once
#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "emulators/robotiq/gripper_plant.hpp"
#include "emulators/robotiq/gripper_simulator.hpp"
#include "kinematics/gripper_file.hpp"

namespace stonestack::emulators {

/// The controller inside a 2F-85, 2F-140 or Hand-E: command registers in, status registers out, fingers moved
/// by a plant. Instruction manuals, "Control"; times that they do not give are design choices.
class TwoFingerRegisters {
 public:
  static constexpr int kCount = 3;  ///< registers each way
  using Words = std::array<std::uint16_t, kCount>;

  TwoFingerRegisters(GripperPlant& plant, const GripperFile& file);
  /// A master writes command registers [first, first + values).
  void write(int first, std::span<const std::uint16_t> values);
  void advance(double seconds);
  [[nodiscard]] Words status() const;
  [[nodiscard]] Words commands() const;
  void set_faults(const GripperFaults& faults) { faults_ = faults; }

  /// Answers a line of the URCap's text socket: "ack", "POS 120", or "?" for what is not understood.
  [[nodiscard]] std::string answer(const std::string& line);

 private:
  enum class Phase { kReset, kActivating, kReady, kReleasing, kReleased };
  using Bytes = std::array<std::uint8_t, 2 * kCount>;

  void written(const Bytes& bytes);
  void accept();
  void command_plant();
  [[nodiscard]] int fault_code() const;
  [[nodiscard]] int object_status() const;
  [[nodiscard]] int stage() const;
  [[nodiscard]] int position() const;

  GripperPlant* plant_;
  GripperFile file_;
  GripperFaults faults_;
  Bytes written_{};   // by the master
  Bytes accepted_{};  // what the controller acts upon and echoes
  double since_write_ = 0.0;
  Phase phase_ = Phase::kReset;
  int step_ = 0;  // of the activation: open, close, open
  double in_step_ = 0.0;
  double slipped_ = 0.0;  // counts
  AxisReport finger_;
};

}  // namespace stonestack::emulators
