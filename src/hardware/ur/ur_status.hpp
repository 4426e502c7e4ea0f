#pragma once
#include "hardware/ur/rtde_client.hpp"
#include "hardware/ur/script_writer.hpp"

/// State of arm and program in one RTDE sample.
namespace stonestack::hardware {

struct UrStatus {
  static constexpr std::uint32_t kPausing = 3, kPaused = 4, kResuming = 5;  ///< of `runtime_state`
  Joints q, qd;
  double device_time = 0.0, host_time = 0.0;  ///< [s]
  int robot_mode = 0;                         ///< 7: running
  int safety = 0;                             ///< safety_status, or safety_mode on older controllers
  std::uint32_t safety_bits = 0;
  std::uint32_t runtime_state = 0;
  bool program_running = false;  ///< or resuming
  double speed = 0.0;            ///< of the arm as a fraction: slider times what the safety system leaves
  int run = 0, progress = 0, end = 0;
  double force = 0.0;  ///< of the latest program; 0 until it has read one [N]

  /// A person (or the pendant) holds the program: it is there and goes on when somebody plays it. Controllers
  /// may clear their bit of a running program meanwhile, and until it has been resumed.
  [[nodiscard]] bool is_held() const;
  /// Held, or the speed slider at zero.
  [[nodiscard]] bool is_paused() const;
};

/// Outputs and inputs that the arm needs; `first_register` is 24 or 0.
[[nodiscard]] RtdeRecipe arm_recipe(const UrVersion& version);
/// Returns the recipe for the controller at `address`; throws DeviceError that names it for PolyScope X
/// (version 10).
[[nodiscard]] RtdeRecipeFor served_recipe(const std::string& address);
[[nodiscard]] UrStatus read_status(const RtdeSample& sample, int first_register);
/// Empty unless the safety system holds the arm: "protective stop (safety 3, bits 0x4)".
[[nodiscard]] std::string find_safety_stop(const UrStatus& status);
/// Finds a safety stop, or that the arm is not powered with its brakes off.
[[nodiscard]] std::string find_hindrance(const UrStatus& status);

}  // namespace stonestack::hardware
