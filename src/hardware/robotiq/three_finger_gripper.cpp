#include "hardware/robotiq/three_finger_gripper.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <thread>

#include "core/byte_stream.hpp"
#include "hardware/constants.hpp"
#include "hardware/robotiq/gripper_words.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::hardware {
namespace {

using Stage = ThreeFingerStatus::Stage;
using Motion = ThreeFingerStatus::Motion;
using Object = ThreeFingerStatus::Axis::Object;

// Data sheet: registers 0..255 stand for these ranges, straight lines between.
constexpr double kSlowest = 0.022, kFastest = 0.110;  // m/s
constexpr double kWeakest = 15.0, kStrongest = 60.0;  // N
constexpr double kStroke = 0.155;                     // m, full
constexpr int kSimpleWords = 3;                       // registers that simple control needs

int to_count(double value, double low, double high) {
  return static_cast<int>(std::lround(255.0 * std::clamp((value - low) / (high - low), 0.0, 1.0)));
}

ModbusOptions resolve(const ThreeFingerOptions& options, const GripperLayout& layout) {
  ModbusOptions modbus = options.modbus;
  modbus.link = options.preset == "rtu" ? "rtu" : "tcp";
  modbus.unit = options.unit >= 0 ? options.unit : layout.unit;
  return modbus;
}

}  // namespace

FieldList fields(ThreeFingerOptions& o) {
  const FieldRange seconds{0.05, 120.0};
  FieldList own = {
      user(field("preset", o.preset, "register layout: tcp2018, tcp2014 or rtu")),
      field("unit", o.unit, {-1, 255}, "", "Modbus unit; -1: of the preset"),
      field("mode", o.mode, "of the fingers: basic, pinch, wide or scissor"),
      user(field("max_opening", o.max_opening, {0.01, 0.3}, "m",
                 "between the pads at open_count; calibrate with a gauge")),
      user(field("open_count", o.open_count, {0.0, 255.0}, "count",
                 "request that opens fully; calibrate with a gauge")),
      user(field("closed_count", o.closed_count, {0.0, 255.0}, "count",
                 "request at which the pads meet; calibrate with a gauge")),
      user(field("narrow_count", o.narrow_count, {0.0, 255.0}, "count",
                 "of the scissor, fingers B and C side by side; calibrate with a gauge")),
      field("activation_timeout", o.activation_timeout, seconds, "s", "it takes 5 to 10 s"),
      field("echo_timeout", o.echo_timeout, seconds, "s",
            "until the gripper must repeat a request; then it is sent once more"),
      field("move_margin", o.move_margin, seconds, "s", "beyond stroke / speed until a move has failed"),
      field("poll", o.poll, {0.001, 0.1}, "s", "between readings of the status"),
  };
  FieldList wire;
  for (auto& f : fields(o.modbus))
    if (f.name != "link" && f.name != "unit") wire.push_back(f);  // set by the preset
  return join({own, wire});
}

struct ThreeFingerGripper::Link {
  ThreeFingerOptions options;
  GripperLayout layout;
  ModbusClient client;
  GripperRequest last;  // what was written last
  bool commanded = false;
  std::optional<int> scissor;   // count that `spread` asked for; empty: as the mode has it
  bool scissor_arrived = true;  // at it

  explicit Link(const ThreeFingerOptions& o)
      : options(o), layout(gripper_layout(o.preset)), client("Robotiq gripper", resolve(o, layout)) {}

  [[noreturn]] void fail(const std::string& problem, const std::string& remedy) const {
    throw DeviceError(client.name(), problem, remedy);
  }
  [[nodiscard]] ThreeFingerStatus read();
  void write(const GripperRequest& request);
  ThreeFingerStatus wait(double seconds, const std::string& what,
                         const std::function<bool(const ThreeFingerStatus&)>& done);
  ThreeFingerStatus move(const GripperRequest& request);
  [[nodiscard]] bool echoes(const ThreeFingerStatus& status) const;
  void require_ready(const ThreeFingerStatus& status) const;
  [[nodiscard]] GripperState judge(const ThreeFingerStatus& status) const;
  [[nodiscard]] double opening(double count) const {
    const double share = (count - options.open_count) / (options.closed_count - options.open_count);
    return options.max_opening * std::clamp(1.0 - share, 0.0, 1.0);
  }
};

ThreeFingerStatus ThreeFingerGripper::Link::read() {
  return decode_gripper_status(layout.read_function == 3 ? client.read_holding(layout.status, kGripperWords)
                                                         : client.read_input(layout.status, kGripperWords));
}

void ThreeFingerGripper::Link::write(const GripperRequest& request) {
  auto words = encode(request);
  // Simple control writes only its own registers, as the manual's examples do.
  const bool was_individual = last.individual_fingers || last.individual_scissor;
  if (!request.individual_fingers && !request.individual_scissor && !was_individual)
    words.resize(kSimpleWords);
  client.write_many(layout.commands, words);
  last = request;
  commanded = true;
}

ThreeFingerStatus ThreeFingerGripper::Link::wait(double seconds, const std::string& what,
                                                 const std::function<bool(const ThreeFingerStatus&)>& done) {
  for (const Deadline deadline = Deadline::in(seconds);;) {
    throw_if_interrupted();
    const ThreeFingerStatus status = read();
    if (done(status)) return status;
    if (gripper_fault_kind(status.fault) == GripperFaultKind::kMajor)
      fail(what + " ended with " + gripper_fault_text(status.fault), "look at the fingers");
    if (deadline.over())
      fail(concat(what, " did not finish within ", seconds, " s",
                  status.fault != 0 ? " (" + gripper_fault_text(status.fault) + ")" : ""),
           "see what hinders the fingers, and that the gripper has 24 V");
    std::this_thread::sleep_for(std::chrono::duration<double>(options.poll));
  }
}

bool ThreeFingerGripper::Link::echoes(const ThreeFingerStatus& status) const {
  if (!status.go || status.stage != Stage::kReady) return false;
  for (std::size_t i = 0; i < 4; ++i) {
    const bool own = i == 0 || (i < 3 && last.individual_fingers) || (i == 3 && last.individual_scissor);
    if (own && status.axes[i].request != last.axes[i].position) return false;
  }
  return true;
}

void ThreeFingerGripper::Link::require_ready(const ThreeFingerStatus& status) const {
  if (gripper_fault_kind(status.fault) == GripperFaultKind::kMajor)
    fail(gripper_fault_text(status.fault), "look at the fingers before");
  if (!status.active || status.stage != Stage::kReady)
    fail("is not activated", "empty the gripper and activate it (the fingers open and close fully)");
}

ThreeFingerStatus ThreeFingerGripper::Link::move(const GripperRequest& request) {
  double slowest = 1.0;
  for (const auto& axis : request.axes) slowest = std::min(slowest, axis.speed / 255.0);
  const double stroke_time = kStroke / (kSlowest + slowest * (kFastest - kSlowest));
  write(request);
  // The status speaks of this request only once it repeats it; a request right after the one that sets the
  // go bit can get lost.
  const auto echoed = [this](const ThreeFingerStatus& status) { return echoes(status); };
  const auto echoed_or_late = [&, limit = Deadline::in(options.echo_timeout)](
                                  const ThreeFingerStatus& status) { return echoes(status) || limit.over(); };
  if (!echoes(wait(options.echo_timeout + 1.0, "a request", echoed_or_late))) {
    write(request);
    wait(options.echo_timeout, "repeating a request (the gripper does not echo it)", echoed);
  }
  return wait(stroke_time + options.move_margin, "a motion of the fingers",
              [this](const ThreeFingerStatus& s) { return echoes(s) && s.motion != Motion::kMoving; });
}

GripperState ThreeFingerGripper::Link::judge(const ThreeFingerStatus& status) const {
  GripperState state;
  state.host_time = host_seconds();
  // A stands opposite of B and C.
  const auto& axes = status.axes;
  state.opening = opening(0.5 * axes[0].position + 0.25 * (axes[1].position + axes[2].position));
  state.moving = status.stage == Stage::kActivating || status.stage == Stage::kModeChange ||
                 (status.go && status.motion == Motion::kMoving);
  state.fault = gripper_fault_text(status.fault);
  if (!status.active && state.fault.empty()) state.fault = "not activated; empty the gripper and activate it";
  if (!commanded || !echoes(status) || status.motion == Motion::kMoving) return state;
  const auto held = [&](std::size_t i) {
    const int request = last.individual_fingers ? last.axes[i].position : last.axes[0].position;
    return axes[i].object == Object::kContactClosing && axes[i].position <= request - kObjectMargin;
  };
  state.object = held(0) && (held(1) || held(2));
  return state;
}

ThreeFingerGripper::ThreeFingerGripper(const ThreeFingerOptions& options) {
  (void)parse_gripper_mode(options.mode);
  require(options.open_count < options.closed_count, "closed_count must exceed open_count, got ",
          options.closed_count, " and ", options.open_count);
  link_ = std::make_unique<Link>(options);
  // After a restart the gripper may hold a stone: take over what it was asked last.
  const ThreeFingerStatus status = link_->read();
  link_->last.active = status.active;
  link_->last.mode = status.mode;
  link_->last.go = status.go;
  for (std::size_t i = 0; i < 4; ++i) link_->last.axes[i].position = status.axes[i].request;
  link_->commanded = status.go;
}

ThreeFingerGripper::~ThreeFingerGripper() = default;
ThreeFingerGripper::ThreeFingerGripper(ThreeFingerGripper&&) noexcept = default;

const std::string& ThreeFingerGripper::name() const {
  return link_->client.name();
}

ThreeFingerStatus ThreeFingerGripper::status() {
  return link_->read();
}

bool ThreeFingerGripper::is_active() {
  const ThreeFingerStatus status = link_->read();
  return status.active && status.stage == Stage::kReady &&
         gripper_fault_kind(status.fault) != GripperFaultKind::kMajor;
}

GripperState ThreeFingerGripper::state() {
  return link_->judge(link_->read());
}

void ThreeFingerGripper::activate() {
  Link& link = *link_;
  const Deadline deadline = Deadline::in(link.options.activation_timeout);
  GripperRequest request;
  request.active = false;
  link.write(request);
  link.wait(link.options.echo_timeout, "a reset",
            [](const ThreeFingerStatus& s) { return !s.active && s.stage == Stage::kReset; });
  request.active = true;
  link.write(request);
  link.wait(deadline.left(), "the activation",
            [](const ThreeFingerStatus& s) { return s.active && s.stage == Stage::kReady; });
  set_mode(parse_gripper_mode(link.options.mode));
}

void ThreeFingerGripper::set_mode(GripperMode mode) {
  Link& link = *link_;
  const ThreeFingerStatus status = link.read();
  link.require_ready(status);
  if (status.mode == mode) return;
  GripperRequest request;
  request.mode = mode;
  link.write(request);
  link.wait(kModeTimeout, "the change of mode",
            [&](const ThreeFingerStatus& s) { return s.stage == Stage::kReady && s.mode == mode; });
}

GripperState ThreeFingerGripper::move(double opening, double speed, double force) {
  Link& link = *link_;
  const ThreeFingerOptions& o = link.options;
  require(std::isfinite(opening) && opening >= 0 && opening <= o.max_opening + 1e-9 && std::isfinite(speed) &&
              std::isfinite(force),
          "the gripper opens from 0 to ", o.max_opening, " m, asked for ", opening, " m");
  const ThreeFingerStatus status = link.read();
  link.require_ready(status);
  const double count = o.closed_count - (o.closed_count - o.open_count) * opening / o.max_opening;
  GripperRequest request;
  request.mode = status.mode;
  request.go = true;
  request.axes.fill({static_cast<int>(std::lround(count)), to_count(speed, kSlowest, kFastest),
                     to_count(force, kWeakest, kStrongest)});
  if (link.scissor) {
    request.individual_scissor = true;
    request.axes[3] = {*link.scissor, 255, 0};
  }
  return link.judge(link.move(request));
}

void ThreeFingerGripper::spread(double spacing) {
  Link& link = *link_;
  const ThreeFingerOptions& o = link.options;
  require(std::isfinite(spacing) && spacing >= std::min(kNarrowSpacing, kWideSpacing) - 1e-9 &&
              spacing <= std::max(kNarrowSpacing, kWideSpacing) + 1e-9,
          "fingers B and C go from ", kNarrowSpacing, " to ", kWideSpacing, " m apart, asked for ", spacing,
          " m");
  const ThreeFingerStatus status = link.read();
  link.require_ready(status);
  const double share = (spacing - kWideSpacing) / (kNarrowSpacing - kWideSpacing);
  const int count = static_cast<int>(std::lround(kWideCount + share * (o.narrow_count - kWideCount)));
  const int now = link.scissor.value_or(static_cast<int>(std::lround(kWideCount)));
  if (count == now && link.scissor_arrived) return;
  GripperRequest request;
  request.mode = status.mode;
  request.go = true;
  request.individual_scissor = true;
  for (std::size_t i = 0; i < 3; ++i) request.axes[i] = {status.axes[i].request, 255, 0};
  request.axes[3] = {count, 255, 0};
  link.scissor = count;
  link.scissor_arrived = false;
  link.move(request);
  // The gripper's status speaks of the three fingers; the scissor has its own.
  link.wait(kModeTimeout, "drawing fingers B and C together or apart",
            [](const ThreeFingerStatus& s) { return s.axes[3].object != Object::kMoving; });
  link.scissor_arrived = true;
}

ThreeFingerStatus ThreeFingerGripper::move_fingers(const std::array<FingerRequest, 3>& fingers,
                                                   const std::optional<FingerRequest>& scissor) {
  const ThreeFingerStatus status = link_->read();
  link_->require_ready(status);
  GripperRequest request;
  request.mode = status.mode;
  request.go = true;
  request.individual_fingers = true;
  request.individual_scissor = scissor.has_value();
  std::copy(fingers.begin(), fingers.end(), request.axes.begin());
  if (scissor) request.axes[3] = *scissor;
  return link_->move(request);
}

}  // namespace stonestack::hardware
