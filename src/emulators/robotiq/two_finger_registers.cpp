#include "emulators/robotiq/two_finger_registers.hpp"

#include <algorithm>
#include <cmath>

#include "protocol/gripper_text.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::emulators {
namespace {

// rACT, rGTO, rATR, rARD and their bytes: instruction manuals
constexpr unsigned kTwoFingerAct = 0x01, kTwoFingerGo = 0x08, kTwoFingerRelease = 0x10, kReleaseOpens = 0x20;
constexpr std::size_t kPositionByte = 3, kSpeedByte = 4, kForceByte = 5;
constexpr double kTwoFingerActivation = 200.0;   // counts/s; design choice
constexpr double kTwoFingerReleaseSpeed = 40.0;  // counts/s; design choice
constexpr double kMinStep = 0.1;                 // s, of an activation step; design choice

}  // namespace

TwoFingerRegisters::TwoFingerRegisters(GripperPlant& plant, const GripperFile& file)
    : plant_(&plant), file_(file) {
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
  if ((accepted_[0] & kTwoFingerGo) != 0) finger_.status = AxisReport::Status::kMoving;
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
    if (++step_ == 3) phase_ = Phase::kReady;
  }
  if (phase_ == Phase::kReleasing && !moving) phase_ = Phase::kReleased;
  if (phase_ == Phase::kReady && (accepted_[0] & kTwoFingerGo) != 0) slipped_ += faults_.slip * seconds;
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

TwoFingerRegisters::Words TwoFingerRegisters::status() const {
  const bool active = (accepted_[0] & kTwoFingerAct) != 0, go = (accepted_[0] & kTwoFingerGo) != 0;
  const int object = go && phase_ == Phase::kReady ? object_status() : 0;
  const int first = (active ? 1 : 0) | (go ? 8 : 0) | stage() << 4 | object << 6;
  const int current = static_cast<int>(std::clamp(std::lround(finger_.current * 100.0), 0L, 255L));
  return {static_cast<std::uint16_t>(first << 8),
          static_cast<std::uint16_t>(fault_code() << 8 | accepted_[kPositionByte]),
          static_cast<std::uint16_t>(position() << 8 | current)};
}

TwoFingerRegisters::Words TwoFingerRegisters::commands() const {
  Words words{};
  for (std::size_t i = 0; i < words.size(); ++i)
    words[i] = static_cast<std::uint16_t>(written_[2 * i] * 256U + written_[2 * i + 1]);
  return words;
}

std::string TwoFingerRegisters::answer(const std::string& line) {
  const auto parsed = parse_gripper_line(line);
  if (!parsed) return "?";
  if (!parsed->get.empty()) {
    const Words words = status();
    const auto value = [&](int number) { return concat(parsed->get, " ", number); };
    const int first = words[0] >> 8U;
    if (parsed->get == "ACT") return value(first & 1);
    if (parsed->get == "GTO") return value(first >> 3 & 1);
    if (parsed->get == "STA") return value(first >> 4 & 3);
    if (parsed->get == "OBJ") return value(first >> 6 & 3);
    if (parsed->get == "FLT") return value(words[1] >> 8U);
    if (parsed->get == "PRE") return value(words[1] & 0xFFU);
    if (parsed->get == "POS") return value(words[2] >> 8U);
    if (parsed->get == "SPE") return value(accepted_[kSpeedByte]);
    if (parsed->get == "FOR") return value(accepted_[kForceByte]);
    return "?";
  }
  Bytes bytes = written_;
  const auto set_bit = [&](unsigned bit, int on) {
    bytes[0] = static_cast<std::uint8_t>(on != 0 ? bytes[0] | bit : bytes[0] & ~bit);
  };
  for (const auto& [name, number] : parsed->set) {
    if (name == "ACT") {
      set_bit(kTwoFingerAct, number);
    } else if (name == "GTO") {
      set_bit(kTwoFingerGo, number);
    } else if (name == "ATR") {
      set_bit(kTwoFingerRelease, number);
    } else if (name == "ARD") {
      set_bit(kReleaseOpens, number);
    } else if (name == "POS" || name == "SPE" || name == "FOR") {
      bytes[name == "POS"   ? kPositionByte
            : name == "SPE" ? kSpeedByte
                            : kForceByte] = static_cast<std::uint8_t>(number);
    } else {
      return "?";
    }
  }
  written(bytes);
  return "ack";
}

}  // namespace stonestack::emulators
