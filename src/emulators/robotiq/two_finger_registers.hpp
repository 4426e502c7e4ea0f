#pragma once
#include <array>
#include <cstdint>
#include <map>
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
  static constexpr int kCount = 3;        ///< command registers
  static constexpr int kStatusCount = 8;  ///< zeros beyond the third; drivers read six
  using Commands = std::array<std::uint16_t, kCount>;
  using Status = std::array<std::uint16_t, kStatusCount>;

  /// `id`: the gripper's own on its serial line, which the text socket knows as SID.
  TwoFingerRegisters(GripperPlant& plant, const GripperFile& file, int id = 9);
  /// A master writes command registers [first, first + values).
  void write(int first, std::span<const std::uint16_t> values);
  void advance(double seconds);
  [[nodiscard]] Status status() const;
  [[nodiscard]] Commands commands() const;
  void set_faults(const GripperFaults& faults) { faults_ = faults; }

  /// Answers a line of the URCap's text socket: "ack", "POS 120", or "?" for what is not understood.
  [[nodiscard]] std::string answer(const std::string& line);
  /// Answers a line that was sent without its end, as Robotiq's own scripts do: the value alone, of PRE with
  /// three digits, of FLT with two.
  [[nodiscard]] std::string bare_answer(const std::string& line);

 private:
  enum class Phase { kReset, kActivating, kReady, kReleasing, kReleased };
  using Bytes = std::array<std::uint8_t, 2 * kCount>;

  void written(const Bytes& bytes);
  void accept();
  void await_motion();
  void command_plant();
  [[nodiscard]] std::string value_of(const std::string& variable) const;
  [[nodiscard]] bool set(Bytes& bytes, const std::string& variable, int value);
  [[nodiscard]] int fault_code() const;
  [[nodiscard]] int object_status() const;
  [[nodiscard]] int stage() const;
  [[nodiscard]] int position() const;

  GripperPlant* plant_;
  GripperFile file_;
  int id_;
  GripperFaults faults_;
  Bytes written_{};   // by the master
  Bytes accepted_{};  // what the controller acts upon and echoes
  double since_write_ = 0.0;
  Phase phase_ = Phase::kReset;
  int step_ = 0;  // of the activation: open, close, open
  double in_step_ = 0.0;
  double slipped_ = 0.0;  // counts
  AxisReport finger_;
  std::map<std::string, int> kept_;  // variables of the text socket without an effect here
};

}  // namespace stonestack::emulators
