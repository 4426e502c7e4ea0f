#include "hardware/ur/ur_status.hpp"

#include <array>
#include <iomanip>
#include <sstream>

namespace stonestack::hardware {
namespace {

constexpr std::uint32_t kFirstWithoutScripts = 10;
constexpr int kRunningMode = 7;
constexpr int kNormal = 1, kReduced = 2;
constexpr std::uint32_t kProgramRunning = 1U << 1;
constexpr double kStandingSlider = 1e-3;
constexpr int kStatusRegisters = 3, kResultRegisters = 7, kForceRegister = 6, kForceInputs = 3;

struct SafetyBit {
  unsigned bit;
  const char* name;
};
constexpr std::array<SafetyBit, 9> kSafetyBits = {{{6, "emergency stop of the robot"},
                                                   {5, "emergency stop of the system"},
                                                   {7, "emergency stop"},
                                                   {8, "safety violation"},
                                                   {9, "safety fault"},
                                                   {2, "protective stop"},
                                                   {4, "safeguard stop"},
                                                   {3, "recovery mode"},
                                                   {11, "three-position switch stop"}}};
constexpr std::array<const char*, 14> kSafetyNames = {"no safety status",
                                                      "normal",
                                                      "reduced",
                                                      "protective stop",
                                                      "recovery mode",
                                                      "safeguard stop",
                                                      "emergency stop of the system",
                                                      "emergency stop of the robot",
                                                      "safety violation",
                                                      "safety fault",
                                                      "joint ids are being validated",
                                                      "safety status undefined",
                                                      "safeguard stop in automatic mode",
                                                      "three-position switch stop"};
constexpr std::array<const char*, 10> kRobotModes = {"without controller",
                                                     "disconnected",
                                                     "to be confirmed after a safety change",
                                                     "booting",
                                                     "powered off",
                                                     "powered on but idle",
                                                     "idle",
                                                     "backdriven",
                                                     "running",
                                                     "updating firmware"};

Joints joints(const RtdeSample& sample, const char* name) {
  return Eigen::Map<const Joints>(sample.get<std::array<double, 6>>(name).data());
}

}  // namespace

bool UrStatus::is_held() const {
  return runtime_state == kPausing || runtime_state == kPaused;
}

bool UrStatus::is_paused() const {
  return is_held() || speed < kStandingSlider;
}

RtdeRecipe arm_recipe(const UrVersion& version) {
  const int first = first_register(version);
  RtdeRecipe recipe;
  recipe.required = {"actual_q",      "actual_qd",         "robot_mode",
                     "safety_mode",   "robot_status_bits", "safety_status_bits",
                     "runtime_state", "speed_scaling",     "target_speed_fraction"};
  for (int i = 0; i < kStatusRegisters; ++i)
    recipe.required.push_back(concat("output_int_register_", first + i));
  for (int i = 0; i < kResultRegisters; ++i)
    recipe.required.push_back(concat("output_double_register_", first + i));
  recipe.optional = {"safety_status", "tcp_offset", "payload", "payload_cog"};
  std::vector<std::string> inputs = {concat("input_int_register_", first),
                                     concat("input_int_register_", first + 1)};
  for (int i = 0; i < kForceInputs; ++i) inputs.push_back(concat("input_double_register_", first + i));
  recipe.inputs = {inputs};
  return recipe;
}

RtdeRecipeFor served_recipe(const std::string& address) {
  return [address](const UrVersion& version) {
    if (version.major < kFirstWithoutScripts) return arm_recipe(version);
    throw DeviceError("UR controller at " + address, "PolyScope X " + to_string(version) + " is not served",
                      "use a controller with PolyScope 3 or 5");
  };
}

UrStatus read_status(const RtdeSample& sample, int first_register) {
  const auto integer = [&](int i) {
    return sample.get<std::int32_t>(concat("output_int_register_", first_register + i));
  };
  UrStatus status;
  status.q = joints(sample, "actual_q");
  status.qd = joints(sample, "actual_qd");
  status.device_time = sample.device_time();
  status.host_time = sample.host_time();
  status.robot_mode = sample.get<std::int32_t>("robot_mode");
  status.safety = sample.get<std::int32_t>(sample.has("safety_status") ? "safety_status" : "safety_mode");
  status.safety_bits = sample.get<std::uint32_t>("safety_status_bits");
  status.runtime_state = sample.get<std::uint32_t>("runtime_state");
  status.program_running = (sample.get<std::uint32_t>("robot_status_bits") & kProgramRunning) != 0 ||
                           status.runtime_state == UrStatus::kResuming;
  status.speed = sample.get<double>("speed_scaling") * sample.get<double>("target_speed_fraction");
  status.run = integer(0);
  status.progress = integer(1);
  status.end = integer(2);
  status.force = sample.get<double>(concat("output_double_register_", first_register + kForceRegister));
  return status;
}

std::string find_safety_stop(const UrStatus& status) {
  const auto describe = [&](const std::string& name) {
    std::ostringstream out;
    out << name << " (safety " << status.safety << ", bits 0x" << std::hex << status.safety_bits << ")";
    return out.str();
  };
  for (const SafetyBit& bit : kSafetyBits)
    if ((status.safety_bits >> bit.bit & 1U) != 0) return describe(bit.name);
  if (status.safety == kNormal || status.safety == kReduced) return {};
  const bool known = status.safety >= 0 && status.safety < static_cast<int>(kSafetyNames.size());
  return describe(known ? kSafetyNames[static_cast<std::size_t>(status.safety)]
                        : "safety status not known here");
}

std::string find_hindrance(const UrStatus& status) {
  if (auto stop = find_safety_stop(status); !stop.empty()) return stop;
  if (status.robot_mode == kRunningMode) return {};
  const int i = status.robot_mode + 1;  // modes begin at -1
  const bool known = i >= 0 && i < static_cast<int>(kRobotModes.size());
  return concat("the robot is ",
                known ? kRobotModes[static_cast<std::size_t>(i)] : "in a mode not known here", " (mode ",
                status.robot_mode, "); power it on and release the brakes");
}

}  // namespace stonestack::hardware
