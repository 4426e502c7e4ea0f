#include "emulators/robotiq/two_finger_registers.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>
#include <utility>

#include "protocol/gripper_text.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::emulators {
namespace {

// rACT, rGTO, rATR, rARD and their bytes: instruction manuals
constexpr unsigned kTwoFingerAct = 0x01, kTwoFingerGo = 0x08, kTwoFingerRelease = 0x10, kReleaseOpens = 0x20;
constexpr std::size_t kPositionByte = 3, kSpeedByte = 4, kForceByte = 5;
constexpr double kTwoFingerActivation = 200.0;        // counts/s; design choice
constexpr double kTwoFingerReleaseSpeed = 40.0;       // counts/s; design choice
constexpr double kMinStep = 0.1;                      // s, of an activation step; design choice
constexpr int kDriverActivates = 3, kDriverRuns = 4;  // DST: Robotiq's script
// Mode, largest current, LED, and the search for grippers: Robotiq's script sets them until it reads "ack".
constexpr std::array<std::string_view, 7> kKeptVariables{"MOD", "MSC", "LBP",      "LRD",
                                                         "LBL", "LGN", "SCN_BLOCK"};

bool is_kept(std::string_view variable) {
  return std::find(kKeptVariables.begin(), kKeptVariables.end(), variable) != kKeptVariables.end();
}

}  // namespace

TwoFingerRegisters::TwoFingerRegisters(GripperPlant& plant, const GripperFile& file, int id)
    : plant_(&plant), file_(file), id_(id) {
  finger_.position = file.open_count;
}

void TwoFingerRegisters::write(int first, std::span<const std::uint16_t> values) {
  Bytes bytes = written_;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto at = 2 * (static_cast<std::size_t>(first) + i);
    bytes.at(at) = static_cast<std::uint8_t>(values[i] >> 8U);
    bytes.at(at + 1) = static_cast<std::uint8_t>(values[i] & 0xFFU);
  }
  written(bytes);
}

void TwoFingerRegisters::written(const Bytes& bytes) {
  written_ = bytes;
  const bool position = (written_[0] & kTwoFingerGo) != 0 && written_ != accepted_;
  if (position && faults_.ignored_writes > 0) {
    --faults_.ignored_writes;
    written_ = accepted_;
    return;
  }
  since_write_ = 0.0;
  if (faults_.echo_delay <= 0.0) accept();
}

void TwoFingerRegisters::accept() {
  const bool was_active = (accepted_[0] & kTwoFingerAct) != 0, active = (written_[0] & kTwoFingerAct) != 0;
  accepted_ = written_;
  slipped_ = 0.0;
  await_motion();
  if (!active) {
    phase_ = Phase::kReset;
    if (faults_.fault >= 10) faults_.fault = 0;
  } else if (!was_active && phase_ == Phase::kReset) {
    phase_ = Phase::kActivating;
    step_ = 0;
    in_step_ = 0.0;
  } else if ((accepted_[0] & kTwoFingerRelease) != 0 && phase_ != Phase::kReleased) {
    phase_ = Phase::kReleasing;
  }
}

void TwoFingerRegisters::advance(double seconds) {
  since_write_ += seconds;
  if (written_ != accepted_ && since_write_ >= faults_.echo_delay) accept();
  command_plant();
  finger_ = plant_->advance(seconds)[0];
  in_step_ += seconds;
  const bool moving = finger_.status == AxisReport::Status::kMoving;
  if (phase_ == Phase::kActivating && !moving && in_step_ >= kMinStep && !faults_.activation_hangs) {
    in_step_ = 0.0;
    if (++step_ == 3) {
      phase_ = Phase::kReady;
      await_motion();
    }
  }
  if (phase_ == Phase::kReleasing && !moving) phase_ = Phase::kReleased;
  if (phase_ == Phase::kReady && (accepted_[0] & kTwoFingerGo) != 0) slipped_ += faults_.slip * seconds;
}

// The plant has not had the request yet: its report is still that of what it did before.
void TwoFingerRegisters::await_motion() {
  if ((accepted_[0] & kTwoFingerGo) != 0) finger_.status = AxisReport::Status::kMoving;
}

void TwoFingerRegisters::command_plant() {
  const double per_metre = (file_.closed_count - file_.open_count) / file_.max_opening;
  AxisCommand finger;
  if (faults_.fault >= 10 || phase_ == Phase::kReset || phase_ == Phase::kReleased) {
    finger = {};
  } else if (phase_ == Phase::kActivating) {
    finger = {true, step_ == 1 ? 255.0 : 0.0, kTwoFingerActivation, file_.min_force};
  } else if (phase_ == Phase::kReleasing) {
    finger = {true, (accepted_[0] & kReleaseOpens) != 0 ? 0.0 : 255.0, kTwoFingerReleaseSpeed,
              file_.min_force};
  } else {
    const auto between = [&](std::size_t byte, double low, double high) {
      return low + accepted_[byte] / 255.0 * (high - low);
    };
    finger = {(accepted_[0] & kTwoFingerGo) != 0, static_cast<double>(accepted_[kPositionByte]),
              per_metre * between(kSpeedByte, file_.min_speed, file_.max_speed),
              between(kForceByte, file_.min_force, file_.max_force)};
  }
  // A real gripper replaces a request beyond its software limits, and reports that it is there.
  finger.target = std::clamp(finger.target, file_.open_count, file_.closed_count);
  std::array<AxisCommand, kGripperAxes> axes{finger, finger, finger, AxisCommand{}};
  plant_->command(axes);
}

int TwoFingerRegisters::fault_code() const {
  if (faults_.fault != 0) return faults_.fault;
  const bool go = (accepted_[0] & kTwoFingerGo) != 0;
  switch (phase_) {
    case Phase::kReset:
      return go ? 7 : 0;
    case Phase::kActivating:
      return go ? 5 : 0;
    case Phase::kReleasing:
      return 11;
    case Phase::kReleased:
      return 15;
    case Phase::kReady:
      break;
  }
  return 0;
}

int TwoFingerRegisters::object_status() const {
  if (faults_.stuck_moving) return 0;
  if (faults_.false_object && finger_.status == AxisReport::Status::kAtRequest) return 2;
  return static_cast<int>(finger_.status);
}

int TwoFingerRegisters::stage() const {
  if (phase_ == Phase::kReady) return 3;
  return phase_ == Phase::kActivating ? 1 : 0;
}

int TwoFingerRegisters::position() const {
  const bool slips = finger_.status == AxisReport::Status::kContactClosing;
  return static_cast<int>(std::clamp(std::lround(finger_.position + (slips ? slipped_ : 0.0)), 0L, 255L));
}

TwoFingerRegisters::Status TwoFingerRegisters::status() const {
  const bool active = (accepted_[0] & kTwoFingerAct) != 0, go = (accepted_[0] & kTwoFingerGo) != 0;
  const int object = go && phase_ == Phase::kReady ? object_status() : 0;
  const int first = (active ? 1 : 0) | (go ? 8 : 0) | stage() << 4 | object << 6;
  const int current = static_cast<int>(std::clamp(std::lround(finger_.current * 100.0), 0L, 255L));
  return {static_cast<std::uint16_t>(first << 8),
          static_cast<std::uint16_t>(fault_code() << 8 | accepted_[kPositionByte]),
          static_cast<std::uint16_t>(position() << 8 | current)};
}

TwoFingerRegisters::Commands TwoFingerRegisters::commands() const {
  Commands words{};
  for (std::size_t i = 0; i < words.size(); ++i)
    words[i] = static_cast<std::uint16_t>(written_[2 * i] * 256U + written_[2 * i + 1]);
  return words;
}

// Empty for a variable that does not exist.
std::string TwoFingerRegisters::value_of(const std::string& variable) const {
  const Status words = status();
  const int first = words[0] >> 8U;
  const auto bit = [&](unsigned mask) { return (accepted_[0] & mask) != 0 ? 1 : 0; };
  const std::pair<std::string_view, int> numbers[] = {
      {"ACT", first & 1},
      {"GTO", first >> 3 & 1},
      {"STA", first >> 4 & 3},
      {"OBJ", first >> 6 & 3},
      {"FLT", words[1] >> 8U},
      {"PRE", words[1] & 0xFFU},
      {"POS", words[2] >> 8U},
      {"COU", words[2] & 0xFFU},
      {"ATR", bit(kTwoFingerRelease)},
      {"ARD", bit(kReleaseOpens)},
      {"SPE", accepted_[kSpeedByte]},
      {"FOR", accepted_[kForceByte]},
      {"DST", phase_ == Phase::kReady ? kDriverRuns : kDriverActivates},
      {"NCY", 0},  // cycles: not reachable
      {"PCO", 0},  // no problem of the connection
  };
  for (const auto& [name, value] : numbers)
    if (name == variable) return std::to_string(value);
  if (variable == "SID") return concat("[", id_, "]");
  if (variable == "SNU" || variable == "FWV" || variable == "VER") return "simulated";
  const auto kept = kept_.find(variable);
  if (kept != kept_.end()) return std::to_string(kept->second);
  return is_kept(variable) ? "0" : "";
}

// False for a variable that does not exist, and for the id of a gripper that is not there.
bool TwoFingerRegisters::set(Bytes& bytes, const std::string& variable, int value) {
  const auto set_bit = [&](unsigned bit) {
    bytes[0] = static_cast<std::uint8_t>(value != 0 ? bytes[0] | bit : bytes[0] & ~bit);
    return true;
  };
  const auto set_byte = [&](std::size_t at) {
    bytes[at] = static_cast<std::uint8_t>(value);
    return true;
  };
  if (variable == "ACT") return set_bit(kTwoFingerAct);
  if (variable == "GTO") return set_bit(kTwoFingerGo);
  if (variable == "ATR") return set_bit(kTwoFingerRelease);
  if (variable == "ARD") return set_bit(kReleaseOpens);
  if (variable == "POS") return set_byte(kPositionByte);
  if (variable == "SPE") return set_byte(kSpeedByte);
  if (variable == "FOR") return set_byte(kForceByte);
  if (variable == "SID") return value == id_;
  if (!is_kept(variable)) return false;
  kept_[variable] = value;
  return true;
}

std::string TwoFingerRegisters::answer(const std::string& line) {
  const auto parsed = parse_gripper_line(line);
  if (!parsed) return "?";
  if (!parsed->get.empty()) {
    const std::string value = value_of(parsed->get);
    return value.empty() ? "?" : concat(parsed->get, " ", value);
  }
  Bytes bytes = written_;
  for (const auto& [name, number] : parsed->set)
    if (!set(bytes, name, number)) return "?";
  written(bytes);
  return "ack";
}

std::string TwoFingerRegisters::bare_answer(const std::string& line) {
  const auto parsed = parse_gripper_line(line);
  const std::string value = parsed ? value_of(parsed->get) : "";
  const std::size_t digits = !parsed ? 0 : parsed->get == "FLT" ? 2 : parsed->get == "PRE" ? 3 : 1;
  if (value.empty()) return "?";
  return std::string(digits - std::min(digits, value.size()), '0') + value;
}

}  // namespace stonestack::emulators
