#include "emulators/robotiq/gripper_registers.hpp"

#include <algorithm>
#include <cmath>

namespace stonestack::emulators {
namespace {

// rACT.., gACT..: Robotiq manual
constexpr unsigned kAct = 0x01, kMode = 0x06, kGoTo = 0x08, kRelease = 0x10;
constexpr unsigned kIndividualFingers = 0x04, kIndividualScissor = 0x08;
constexpr std::array<double, 4> kScissorOfMode{137.0, 220.0, 25.0,
                                               0.0};  // counts; basic: manual, others design choices
constexpr double kPinchLimit =
    113.0;                         // counts: fingers in pinch mode meet before they are closed; design choice
constexpr double kStroke = 155.0;  // mm over 255 counts
constexpr double kSlowest = 22.0, kMmPerCount = 88.0 / 255.0;      // mm/s, mm/s per count of rSPx
constexpr double kWeakest = 15.0, kNewtonPerCount = 45.0 / 255.0;  // N, N per count of rFRx
constexpr double kActivationSpeed = 200.0, kScissorSpeed = 150.0;  // counts/s; design choice
constexpr double kReleaseSpeed = 40.0;                             // counts/s; design choice
constexpr double kMinStage = 0.1;                                  // s, of an activation stage; design choice
constexpr double kMinModeChange = 0.3;                             // s; design choice

}  // namespace

void GripperRegisters::write(int first, std::span<const std::uint16_t> values) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    const auto at = 2 * (static_cast<std::size_t>(first) + i);
    written_.at(at) = static_cast<std::uint8_t>(values[i] >> 8U);
    written_.at(at + 1) = static_cast<std::uint8_t>(values[i] & 0xFFU);
  }
  const bool position = (written_[0] & kGoTo) != 0 && written_ != accepted_;
  if (position && faults_.ignored_writes > 0) {
    --faults_.ignored_writes;
    written_ = accepted_;
    return;
  }
  since_write_ = 0.0;
  if (faults_.echo_delay <= 0.0) accept();
}

void GripperRegisters::accept() {
  const bool was_active = (accepted_[0] & kAct) != 0, active = (written_[0] & kAct) != 0;
  accepted_ = written_;
  slipped_ = 0.0;
  await_motion();
  if (!active) {
    phase_ = Phase::kReset;
    if (faults_.fault >= 13) faults_.fault = 0;
  } else if (!was_active && phase_ == Phase::kReset) {
    start_activation();
  } else if ((accepted_[0] & kRelease) != 0 && phase_ != Phase::kReleased) {
    phase_ = Phase::kReleasing;
  } else if (phase_ == Phase::kReady && (accepted_[1] & kIndividualScissor) == 0 &&
             mode_ != static_cast<int>((accepted_[0] & kMode) >> 1U)) {
    phase_ = Phase::kModeChange;
    in_stage_ = 0.0;
  }
}

// The plant has not had the request yet: its report is still that of what it did before.
void GripperRegisters::await_motion() {
  if ((accepted_[0] & kGoTo) == 0) return;
  for (auto& axis : axes_) axis.status = AxisReport::Status::kMoving;
}

void GripperRegisters::start_activation() {
  phase_ = Phase::kActivating;
  stage_ = 0;
  in_stage_ = 0.0;
  mode_ = 0;
}

bool GripperRegisters::moving() const {
  return std::any_of(axes_.begin(), axes_.end(),
                     [](const AxisReport& axis) { return axis.status == AxisReport::Status::kMoving; });
}

void GripperRegisters::advance_activation() {
  if (moving() || in_stage_ < kMinStage || faults_.activation_hangs) return;
  in_stage_ = 0.0;
  if (++stage_ < 3) return;
  phase_ = Phase::kReady;
  const int asked = static_cast<int>((accepted_[0] & kMode) >> 1U);
  if (asked != mode_) phase_ = Phase::kModeChange;
  await_motion();
}

void GripperRegisters::advance_mode() {
  if (moving() || in_stage_ < kMinModeChange) return;
  mode_ = static_cast<int>((accepted_[0] & kMode) >> 1U);
  phase_ = Phase::kReady;
  await_motion();
}

void GripperRegisters::advance(double seconds) {
  since_write_ += seconds;
  if (written_ != accepted_ && since_write_ >= faults_.echo_delay) accept();
  command_plant();
  axes_ = plant_->advance(seconds);
  in_stage_ += seconds;
  if (phase_ == Phase::kActivating) advance_activation();
  if (phase_ == Phase::kModeChange) advance_mode();
  if (phase_ == Phase::kReleasing && !moving()) phase_ = Phase::kReleased;
  if (phase_ == Phase::kReady && (accepted_[0] & kGoTo) != 0) slipped_ += faults_.slip * seconds;
}

std::array<AxisCommand, kGripperAxes> GripperRegisters::requested() const {
  std::array<AxisCommand, kGripperAxes> axes;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const bool own =
        i == 3 ? (accepted_[1] & kIndividualScissor) != 0 : (accepted_[1] & kIndividualFingers) != 0;
    const std::size_t at = 3 + 3 * (own ? i : 0);
    const double speed = kSlowest + kMmPerCount * accepted_[at + 1];
    axes[i] = {(accepted_[0] & kGoTo) != 0, static_cast<double>(accepted_[at]), speed * 255.0 / kStroke,
               kWeakest + kNewtonPerCount * accepted_[at + 2]};
    if (i == 3 && !own) axes[i].target = kScissorOfMode[static_cast<std::size_t>(mode_)];
    if (i < 3 && mode_ == 1) axes[i].target = std::min(axes[i].target, kPinchLimit);
  }
  return axes;
}

void GripperRegisters::command_plant() {
  std::array<AxisCommand, kGripperAxes> axes{};
  if (faults_.fault >= 13 || phase_ == Phase::kReset || phase_ == Phase::kReleased) {
    plant_->command(axes);
    return;
  }
  if (phase_ == Phase::kReady) {
    axes = requested();
  } else if (phase_ == Phase::kActivating) {
    for (auto& axis : axes) axis = {true, stage_ == 1 ? 255.0 : 0.0, kActivationSpeed, kWeakest};
    axes[3].target = kScissorOfMode[0];
  } else if (phase_ == Phase::kModeChange) {
    axes[3] = {true, kScissorOfMode[(accepted_[0] & kMode) >> 1U], kScissorSpeed, kWeakest};
  } else {
    for (auto& axis : axes) axis = {true, 0.0, kReleaseSpeed, kWeakest};
    axes[3].go = false;
  }
  plant_->command(axes);
}

int GripperRegisters::fault_code() const {
  if (faults_.fault != 0) return faults_.fault;
  const bool go = (accepted_[0] & kGoTo) != 0;
  switch (phase_) {
    case Phase::kReset:
      return go ? 7 : 0;
    case Phase::kActivating:
      return go ? 5 : 0;
    case Phase::kModeChange:
      return go ? 6 : 0;
    case Phase::kReleasing:
      return 11;
    case Phase::kReleased:
      return 15;
    case Phase::kReady:
      break;
  }
  return 0;
}

int GripperRegisters::axis_status(std::size_t axis) const {
  if (faults_.stuck_moving && axis < 3) return 0;
  if (faults_.false_object && axis < 3 && axes_[axis].status == AxisReport::Status::kAtRequest) return 2;
  return static_cast<int>(axes_[axis].status);
}

int GripperRegisters::motion_status() const {
  int stopped = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    const int status = axis_status(i);
    if (status == 0) return 0;
    if (status != 3) ++stopped;
  }
  return stopped == 0 ? 3 : stopped == 3 ? 2 : 1;
}

GripperRegisters::Words GripperRegisters::status() const {
  const bool active = (accepted_[0] & kAct) != 0, go = (accepted_[0] & kGoTo) != 0;
  int imc = 3;
  if (phase_ == Phase::kReset || phase_ == Phase::kReleasing || phase_ == Phase::kReleased) imc = 0;
  if (phase_ == Phase::kActivating) imc = 1;
  if (phase_ == Phase::kModeChange) imc = 2;
  const bool valid = go && phase_ == Phase::kReady;
  Bytes b{};
  b[0] = static_cast<std::uint8_t>((active ? 1 : 0) | mode_ << 1 | (go ? 8 : 0) | imc << 4 |
                                   (valid ? motion_status() << 6 : 0));
  for (std::size_t i = 0; i < axes_.size(); ++i) {
    if (valid) b[1] = static_cast<std::uint8_t>(b[1] | axis_status(i) << (2 * i));
    const bool slips = i < 3 && axes_[i].status == AxisReport::Status::kContactClosing;
    b[3 + 3 * i] = accepted_[3 + 3 * i];
    b[4 + 3 * i] = static_cast<std::uint8_t>(
        std::clamp(std::lround(axes_[i].position + (slips ? slipped_ : 0.0)), 0L, 255L));
    b[5 + 3 * i] = static_cast<std::uint8_t>(std::clamp(std::lround(axes_[i].current * 100.0), 0L, 255L));
  }
  b[2] = static_cast<std::uint8_t>(fault_code());
  Words words{};
  for (std::size_t i = 0; i < words.size(); ++i)
    words[i] = static_cast<std::uint16_t>(b[2 * i] * 256U + b[2 * i + 1]);
  return words;
}

GripperRegisters::Words GripperRegisters::commands() const {
  Words words{};
  for (std::size_t i = 0; i < words.size(); ++i)
    words[i] = static_cast<std::uint16_t>(written_[2 * i] * 256U + written_[2 * i + 1]);
  return words;
}

}  // namespace stonestack::emulators
