#include "hardware/robotiq/two_finger_gripper.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

#include "core/byte_stream.hpp"
#include "hardware/constants.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::hardware {
namespace {

using TwoFingerStage = TwoFingerStatus::Stage;
using TwoFingerObject = TwoFingerStatus::Object;

// Instruction manuals, "Control": registers over Modbus RTU, bits of the first byte.
constexpr int kCommandRegister = 0x03E8, kStatusRegister = 0x07D0, kTwoFingerUnit = 9;
constexpr unsigned kActBit = 0x01, kGoBit = 0x08;

int share_of_byte(double value, double low, double high) {
  return static_cast<int>(std::lround(255.0 * std::clamp((value - low) / (high - low), 0.0, 1.0)));
}

unsigned byte_in_range(int value, const char* name) {
  require(value >= 0 && value <= 255, "a gripper's ", name, " lies in 0..255, not ", value);
  return static_cast<unsigned>(value);
}

// Instruction manual 2F-85 and 2F-140, gFLT; Hand-E likewise.
const char* two_finger_fault_name(int fault) {
  switch (fault) {
    case 0x5:
      return "the activation must finish first; wait for it";
    case 0x7:
      return "the activation bit is missing; activate the gripper with nothing in it";
    case 0x8:
      return "too hot; let it cool down";
    case 0x9:
      return "nobody spoke to it for a second; look at its cable";
    case 0xA:
      return "the supply voltage is too low; look at the 24 V, then activate again";
    case 0xB:
      return "an automatic release is running; catch what the gripper holds";
    case 0xC:
      return "an internal fault; switch it off and on, ask Robotiq if it stays";
    case 0xD:
      return "the activation failed; clear the fingers and activate again";
    case 0xE:
      return "the motor drew too much current; clear the fingers and activate again";
    case 0xF:
      return "an automatic release is complete; activate again with nothing in the gripper";
    default:
      return "not in the manual; write down the code, activate again, ask Robotiq";
  }
}

class RtuGripperLink final : public TwoFingerLink {
 public:
  explicit RtuGripperLink(const TwoFingerOptions& options) : client_("Robotiq gripper", line_of(options)) {}
  TwoFingerStatus read() override {
    return decode_two_finger_status(client_.read_holding(kStatusRegister, kTwoFingerWords));
  }
  void write(const TwoFingerRequest& request) override {
    client_.write_many(kCommandRegister, encode(request));
  }
  [[nodiscard]] const std::string& name() const override { return client_.name(); }

 private:
  static ModbusOptions line_of(const TwoFingerOptions& options) {
    ModbusOptions modbus = options.modbus;
    modbus.link = "rtu";
    if (modbus.unit < 0) modbus.unit = kTwoFingerUnit;
    return modbus;
  }
  ModbusClient client_;
};

std::unique_ptr<TwoFingerLink> open_link(const TwoFingerOptions& options) {
  require(options.link == "urcap" || options.link == "rtu",
          "a 2-finger gripper is reached over urcap or rtu, not '", options.link, "'");
  if (options.link == "urcap") return make_urcap_link(options);
  return std::make_unique<RtuGripperLink>(options);
}

}  // namespace

std::vector<std::uint16_t> encode(const TwoFingerRequest& request) {
  const unsigned action = (request.active ? kActBit : 0U) | (request.go ? kGoBit : 0U);
  const unsigned position = request.go ? byte_in_range(request.position, "position") : 0U;
  const unsigned speed = request.go ? byte_in_range(request.speed, "speed") : 0U;
  const unsigned force = request.go ? byte_in_range(request.force, "force") : 0U;
  return {static_cast<std::uint16_t>(action << 8U), static_cast<std::uint16_t>(position),
          static_cast<std::uint16_t>(speed << 8U | force)};
}

TwoFingerStatus decode_two_finger_status(const std::vector<std::uint16_t>& words) {
  require(words.size() == kTwoFingerWords, "a 2-finger gripper's status has 3 registers, got ", words.size());
  const unsigned first = words[0] >> 8U;
  TwoFingerStatus s;
  s.active = (first & kActBit) != 0;
  s.go = (first & kGoBit) != 0;
  s.stage = static_cast<TwoFingerStage>(first >> 4U & 3U);
  s.object = static_cast<TwoFingerObject>(first >> 6U);
  s.fault = static_cast<int>(words[1] >> 8U & 0xFU);
  s.request = static_cast<int>(words[1] & 0xFFU);
  s.position = static_cast<int>(words[2] >> 8U);
  return s;
}

bool is_major_two_finger_fault(int fault) {
  return fault >= 0xA;
}

std::string two_finger_fault_text(int fault) {
  if (fault == 0) return {};
  constexpr const char* kDigits = "0123456789ABCDEF";
  return concat("fault 0x0", kDigits[fault & 0xF], ": ", two_finger_fault_name(fault));
}

TwoFingerGripper::TwoFingerGripper(const TwoFingerOptions& options) : options_(options) {
  require(options.open_count < options.closed_count, "closed_count must exceed open_count, got ",
          options.closed_count, " and ", options.open_count);
  link_ = open_link(options);
  // After a restart the gripper may hold a stone: take over what it was asked last.
  const TwoFingerStatus status = link_->read();
  last_.active = status.active;
  last_.go = status.go;
  last_.position = status.request;
  commanded_ = status.go;
}

void TwoFingerGripper::fail(const std::string& problem, const std::string& remedy) const {
  throw DeviceError(link_->name(), problem, remedy);
}

void TwoFingerGripper::write(const TwoFingerRequest& request) {
  link_->write(request);
  last_ = request;
  commanded_ = true;
}

template <class Done>
TwoFingerStatus TwoFingerGripper::wait(double seconds, const std::string& what, const Done& done) {
  for (const Deadline deadline = Deadline::in(seconds);;) {
    throw_if_interrupted();
    const TwoFingerStatus status = link_->read();
    if (done(status)) return status;
    if (is_major_two_finger_fault(status.fault))
      fail(what + " ended with " + two_finger_fault_text(status.fault), "look at the fingers");
    if (deadline.over())
      fail(concat(what, " did not finish within ", seconds, " s",
                  status.fault != 0 ? " (" + two_finger_fault_text(status.fault) + ")" : ""),
           "see what hinders the fingers, and that the gripper has 24 V");
    std::this_thread::sleep_for(std::chrono::duration<double>(options_.poll));
  }
}

bool TwoFingerGripper::echoes(const TwoFingerStatus& status) const {
  return status.go && status.stage == TwoFingerStage::kReady && status.request == last_.position;
}

double TwoFingerGripper::opening_at(double count) const {
  const double share = (options_.closed_count - count) / (options_.closed_count - options_.open_count);
  return options_.max_opening * std::clamp(share, 0.0, 1.0);
}

int TwoFingerGripper::count_for(double opening) const {
  // The ends are asked for beyond what is reported there: the gripper goes as far as it can.
  if (opening <= 0.0) return 255;
  if (opening >= options_.max_opening) return 0;
  const double share = opening / options_.max_opening;
  return static_cast<int>(
      std::lround(options_.closed_count - share * (options_.closed_count - options_.open_count)));
}

GripperState TwoFingerGripper::judge(const TwoFingerStatus& status) const {
  GripperState state;
  state.host_time = host_seconds();
  state.opening = opening_at(status.position);
  state.moving =
      status.stage == TwoFingerStage::kActivating || (status.go && status.object == TwoFingerObject::kMoving);
  state.fault = two_finger_fault_text(status.fault);
  if (!status.active && state.fault.empty()) state.fault = "not activated; empty the gripper and activate it";
  if (!commanded_ || !echoes(status)) return state;
  const double furthest = std::min<double>(last_.position, options_.closed_count);
  state.object =
      status.object == TwoFingerObject::kContactClosing && status.position <= furthest - kObjectMargin;
  return state;
}

GripperState TwoFingerGripper::state() {
  return judge(link_->read());
}

bool TwoFingerGripper::is_active() {
  const TwoFingerStatus status = link_->read();
  return status.active && status.stage == TwoFingerStage::kReady && !is_major_two_finger_fault(status.fault);
}

void TwoFingerGripper::activate() {
  const Deadline deadline = Deadline::in(options_.activation_timeout);
  TwoFingerRequest request;
  request.active = false;
  write(request);
  wait(options_.echo_timeout, "a reset",
       [](const TwoFingerStatus& s) { return !s.active && s.stage == TwoFingerStage::kReset; });
  request.active = true;
  write(request);
  wait(deadline.left(), "the activation",
       [](const TwoFingerStatus& s) { return s.active && s.stage == TwoFingerStage::kReady; });
}

GripperState TwoFingerGripper::move(double opening, double speed, double force) {
  require(std::isfinite(opening) && opening >= 0 && opening <= options_.max_opening + 1e-9 &&
              std::isfinite(speed) && std::isfinite(force),
          "the gripper opens from 0 to ", options_.max_opening, " m, asked for ", opening, " m");
  const TwoFingerStatus before = link_->read();
  if (is_major_two_finger_fault(before.fault))
    fail(two_finger_fault_text(before.fault), "look at the fingers before");
  if (!before.active || before.stage != TwoFingerStage::kReady)
    fail("is not activated", "empty the gripper and activate it (the fingers open and close fully)");
  TwoFingerRequest request;
  request.go = true;
  request.position = count_for(opening);
  request.speed = share_of_byte(speed, options_.min_speed, options_.max_speed);
  request.force = share_of_byte(force, options_.min_force, options_.max_force);
  write(request);
  // The status speaks of this request only once it repeats it; a request can get lost.
  const auto echoed = [this](const TwoFingerStatus& status) { return echoes(status); };
  const auto echoed_or_late = [&, limit = Deadline::in(options_.echo_timeout)](
                                  const TwoFingerStatus& status) { return echoes(status) || limit.over(); };
  if (!echoes(wait(options_.echo_timeout + 1.0, "a request", echoed_or_late))) {
    write(request);
    wait(options_.echo_timeout, "repeating a request (the gripper does not echo it)", echoed);
  }
  const double set_speed =
      options_.min_speed + request.speed / 255.0 * (options_.max_speed - options_.min_speed);
  const TwoFingerStatus after =
      wait(options_.max_opening / set_speed + options_.move_margin, "a motion of the fingers",
           [this](const TwoFingerStatus& s) { return echoes(s) && s.object != TwoFingerObject::kMoving; });
  const double least = std::max<double>(request.position, options_.open_count);
  if (after.object == TwoFingerObject::kContactOpening && after.position > least + kObjectMargin)
    fail(concat("something stopped the fingers while they opened, at ", 1e3 * opening_at(after.position),
                " mm"),
         "clear the fingers by hand");
  return judge(after);
}

void TwoFingerGripper::spread(double spacing) {
  require(spacing == 0.0, "a gripper with one finger on each side has none to spread, asked for ", spacing,
          " m");
}

}  // namespace stonestack::hardware
