#pragma once
#include "core/export.hpp"
#include "stonestack/hardware/ur/rtde_client.hpp"
#include "stonestack/hardware/ur/script_writer.hpp"

/// State of arm and program in one RTDE sample.
namespace stonestack::hardware {

struct STONESTACK_EXPORT UrStatus {
  static constexpr std::uint32_t kPausing = 3, kPaused = 4, kResuming = 5;  ///< of `runtime_state`
  Joints q, qd;
  double device_time = 0.0, host_time = 0.0;  ///< [s]
  int robot_mode = 0;                         ///< 7: running
  int safety = 0;                             ///< safety_status, or safety_mode on older controllers
  std::uint32_t safety_bits = 0;
  std::uint32_t runtime_state = 0;
  bool program_running = false;
  double speed = 0.0;  ///< of the arm as a fraction: slider times what the safety system leaves
  int run = 0, progress = 0, end = 0;
  double force = 0.0;  ///< of the last program [N]

  /// A person (or the pendant) holds the program: it is there and goes on when somebody plays it. Controllers
  /// may clear `program_running` meanwhile.
  [[nodiscard]] bool is_held() const;
  /// Held, or the speed slider at zero.
  [[nodiscard]] bool is_paused() const;
};

/// Outputs and inputs that the arm needs; `first_register` is 24 or 0.
[[nodiscard]] RtdeRecipe arm_recipe(const UrVersion& version);
/// Returns the recipe for the controller at `address`; throws DeviceError that names it for PolyScope X
/// (version 10).
[[nodiscard]] STONESTACK_EXPORT RtdeRecipeFor served_recipe(const std::string& address);
[[nodiscard]] STONESTACK_EXPORT UrStatus read_status(const RtdeSample& sample, int first_register);
/// Empty unless the safety system holds the arm: "protective stop (safety 3, bits 0x4)".
[[nodiscard]] std::string find_safety_stop(const UrStatus& status);
/// Finds a safety stop, or that the arm is not powered with its brakes off.
[[nodiscard]] std::string find_hindrance(const UrStatus& status);

}  // namespace stonestack::hardware
