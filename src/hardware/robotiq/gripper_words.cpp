#include "hardware/robotiq/gripper_words.hpp"

#include <algorithm>

#include "stonestack/core/error.hpp"

namespace stonestack::hardware {
namespace {

unsigned byte_of(int value, const char* name) {
  require(value >= 0 && value <= 255, "a finger's ", name, " lies in 0..255, not ", value);
  return static_cast<unsigned>(value);
}

const char* fault_name(int fault) {
  switch (fault) {
    case 0x5:
      return "the activation must finish first; wait for it";
    case 0x6:
      return "the change of mode must finish first; wait for it";
    case 0x7:
      return "the activation bit is missing; activate the gripper with an empty gripper";
    case 0x9:
      return "the communication chip is not ready; wait, then look at the cable";
    case 0xA:
      return "the fingers hinder each other in scissor motion; open the gripper or clear it within 20 s";
    case 0xB:
      return "an automatic release is running; catch what the gripper holds";
    case 0xD:
      return "the activation failed; clear the fingers and activate again";
    case 0xE:
      return "the fingers hindered each other in scissor motion for 20 s; clear them and activate again";
    case 0xF:
      return "an automatic release is complete; activate again with an empty gripper";
    default:
      return "not in the manual; write down the code, activate again, ask Robotiq";
  }
}

}  // namespace

GripperLayout gripper_layout(const std::string& preset) {
  if (preset == "tcp2018") return {2, 0x0000, 0x0000, 4};
  if (preset == "tcp2014") return {2, 0x03E8, 0x07D0, 4};
  if (preset == "rtu") return {9, 0x03E8, 0x07D0, 3};
  throw InvalidArgument("the preset of a gripper is tcp2018, tcp2014 or rtu, not '" + preset + "'");
}

GripperMode parse_gripper_mode(const std::string& name) {
  if (name == "basic") return GripperMode::kBasic;
  if (name == "pinch") return GripperMode::kPinch;
  if (name == "wide") return GripperMode::kWide;
  if (name == "scissor") return GripperMode::kScissor;
  throw InvalidArgument("the mode of a gripper is basic, pinch, wide or scissor, not '" + name + "'");
}

GripperFaultKind gripper_fault_kind(int fault) {
  if (fault == 0) return GripperFaultKind::kNone;
  if (fault < 0x8) return GripperFaultKind::kPriority;
  return fault < 0xC ? GripperFaultKind::kMinor : GripperFaultKind::kMajor;
}

std::string gripper_fault_text(int fault) {
  if (fault == 0) return {};
  constexpr const char* kDigits = "0123456789ABCDEF";
  return concat("fault 0x0", kDigits[fault & 0xF], ": ", fault_name(fault));
}

std::vector<std::uint16_t> encode(const GripperRequest& request) {
  std::array<unsigned, 16> b{};
  b[0] = (request.active ? 1U : 0U) | static_cast<unsigned>(request.mode) << 1U | (request.go ? 8U : 0U);
  b[1] = (request.individual_fingers ? 4U : 0U) | (request.individual_scissor ? 8U : 0U);
  for (std::size_t i = 0; i < 4; ++i) {
    b[3 + 3 * i] = byte_of(request.axes[i].position, "position");
    b[4 + 3 * i] = byte_of(request.axes[i].speed, "speed");
    b[5 + 3 * i] = byte_of(request.axes[i].force, "force");
  }
  if (!request.go) std::fill(b.begin() + 2, b.end(), 0U);
  std::vector<std::uint16_t> words;
  for (std::size_t i = 0; i < 8; ++i)
    words.push_back(static_cast<std::uint16_t>(b[2 * i] << 8U | b[2 * i + 1]));
  return words;
}

ThreeFingerStatus decode_gripper_status(const std::vector<std::uint16_t>& words) {
  require(words.size() == kGripperWords, "a gripper's status has 8 registers, got ", words.size());
  std::array<unsigned, 16> b{};
  for (std::size_t i = 0; i < 8; ++i) {
    b[2 * i] = words[i] >> 8U;
    b[2 * i + 1] = words[i] & 0xFFU;
  }
  ThreeFingerStatus s;
  s.active = (b[0] & 1U) != 0;
  s.mode = static_cast<GripperMode>(b[0] >> 1U & 3U);
  s.go = (b[0] & 8U) != 0;
  s.stage = static_cast<ThreeFingerStatus::Stage>(b[0] >> 4U & 3U);
  s.motion = static_cast<ThreeFingerStatus::Motion>(b[0] >> 6U);
  s.fault = static_cast<int>(b[2] & 0xFU);
  for (std::size_t i = 0; i < 4; ++i) {
    s.axes[i].object = static_cast<ThreeFingerStatus::Axis::Object>(b[1] >> (2 * i) & 3U);
    s.axes[i].request = static_cast<int>(b[3 + 3 * i]);
    s.axes[i].position = static_cast<int>(b[4 + 3 * i]);
    s.axes[i].current = 0.01 * b[5 + 3 * i];
  }
  return s;
}

}  // namespace stonestack::hardware
