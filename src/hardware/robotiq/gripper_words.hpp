#pragma once
#include <vector>

#include "hardware/robotiq/three_finger_gripper.hpp"

/// The gripper's registers as words and as values.
namespace stonestack::hardware {

inline constexpr int kGripperWords = 8;

struct GripperRequest {
  bool active = true;
  GripperMode mode = GripperMode::kBasic;
  bool go = false;
  bool individual_fingers = false;
  bool individual_scissor = false;
  std::array<FingerRequest, 4> axes{};
};
[[nodiscard]] std::vector<std::uint16_t> encode(const GripperRequest& request);
/// Throws InvalidArgument unless there are 8 words.
[[nodiscard]] ThreeFingerStatus decode_gripper_status(const std::vector<std::uint16_t>& words);
[[nodiscard]] GripperMode parse_gripper_mode(const std::string& name);

}  // namespace stonestack::hardware
