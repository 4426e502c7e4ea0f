#include "emulators/robotiq/gripper_simulator.hpp"

#include <atomic>
#include <chrono>

#include "emulators/logged_thread.hpp"
#include "emulators/robotiq/gripper_registers.hpp"
#include "emulators/robotiq/modbus_server.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::emulators {
namespace {

constexpr double kTick = 0.002;                         // s of the host
constexpr double kLongestTick = 0.1;                    // s: a host that was asleep does not jump
constexpr int kCommandsTcp = 0, kCommandsRtu = 0x03E8;  // where commands are written
constexpr int kStatusTcp = 0, kStatusRtu = 0x07D0;      // where status is read
constexpr int kCount = GripperRegisters::kCount;

std::optional<int> offset(int address, std::size_t count, int base) {
  const int first = address - base;
  if (first < 0 || first + static_cast<int>(count) > kCount) return std::nullopt;
  return first;
}

}  // namespace

FieldList fields(GripperFaults& o) {
  return {
      field("activation_hangs", o.activation_hangs, "true: the activation never completes"),
      field("fault", o.fault, {0, 15}, "", "gFLT that is reported; 13 to 15 end with a reset"),
      field("stuck_moving", o.stuck_moving, "true: the fingers report motion for ever"),
      field("echo_delay", o.echo_delay, {0.0, 60.0}, "s", "until a request is carried out and echoed"),
      field("ignored_writes", o.ignored_writes, {0, 1000}, "", "position requests that are lost"),
      field("false_object", o.false_object, "true: contact is reported at the requested position"),
      field("slip", o.slip, {0.0, 100.0}, "count/s", "of closed fingers that hold something"),
  };
}

FieldList fields(GripperSimulatorOptions& o) {
  return {
      field("tcp", o.tcp, "true: serves Modbus/TCP, of a 2-finger gripper the text of the URCap"),
      field("address", o.address, "any 127.x.y.z"),
      field("port", o.port, {0, 65535}, "", "over TCP; the standard's is 502, 0: a free one"),
      field("rtu", o.rtu, "true: serves Modbus/RTU on a pseudo terminal"),
      field("link", o.link, "name of the pseudo terminal"),
      field("unit", o.unit, {1, 247}, "", "on the serial line; Robotiq manual: 9"),
      field("speed_up", o.speed_up, {0.01, 1000.0}, "",
            "simulated seconds in a second, of activation and fingers"),
  };
}

struct GripperSimulator::Parts {
  std::mutex mutex;  // of the registers and what is behind them
  GripperRegisters registers;
  double speed_up;
  ModbusFaultBox wire;
  std::atomic<bool> stop = false;
  std::unique_ptr<ModbusTcpServer> tcp;
  std::unique_ptr<ModbusRtuServer> rtu;
  std::thread stepper;

  Parts(GripperPlant& plant, double faster) : registers(plant), speed_up(faster) {}

  std::variant<std::vector<std::uint16_t>, modbus::Exception> handle(const modbus::Request& request) {
    const std::lock_guard lock(mutex);
    const auto first = first_command(request);
    if ((modbus::writes(request) && !first) || (modbus::reads(request) && !read(request)))
      return modbus::Exception::kIllegalAddress;
    if (first) registers.write(*first, request.values);
    return modbus::reads(request) ? *read(request) : std::vector<std::uint16_t>{};
  }

  static std::optional<int> first_command(const modbus::Request& request) {
    if (!modbus::writes(request)) return std::nullopt;
    for (const int base : {kCommandsTcp, kCommandsRtu})
      if (const auto first = offset(modbus::first_written(request), request.values.size(), base))
        return first;
    return std::nullopt;
  }

  [[nodiscard]] std::optional<std::vector<std::uint16_t>> read(const modbus::Request& request) const {
    if (const auto first = offset(request.address, request.count, kCommandsRtu))
      return part(registers.commands(), *first, request.count);
    for (const int base : {kStatusTcp, kStatusRtu})
      if (const auto first = offset(request.address, request.count, base))
        return part(registers.status(), *first, request.count);
    return std::nullopt;
  }

  static std::vector<std::uint16_t> part(const GripperRegisters::Words& words, int first, int count) {
    return {words.begin() + first, words.begin() + first + count};
  }

  void step() {
    for (Stopwatch watch; !stop; std::this_thread::sleep_for(std::chrono::duration<double>(kTick))) {
      const double seconds = std::min(kLongestTick, watch.seconds());
      watch = Stopwatch();
      const std::lock_guard lock(mutex);
      registers.advance(seconds * speed_up);
    }
  }
};

GripperSimulator::GripperSimulator(GripperPlant& plant, const GripperSimulatorOptions& options) {
  require(options.tcp || options.rtu, "a simulated gripper needs a link: tcp or rtu");
  parts_ = std::make_unique<Parts>(plant, options.speed_up);
  Parts& parts = *parts_;
  const ModbusHandler handler = [&parts](const modbus::Request& request) { return parts.handle(request); };
  if (options.tcp)
    parts.tcp =
        std::make_unique<ModbusTcpServer>(ListenOptions{options.address, options.port}, handler, parts.wire);
  if (options.rtu)
    parts.rtu = std::make_unique<ModbusRtuServer>(options.link, options.unit, handler, parts.wire);
  parts.stepper = make_logged_thread("simulated gripper", [&parts] { parts.step(); });
}

GripperSimulator::~GripperSimulator() {
  parts_->tcp.reset();
  parts_->rtu.reset();
  parts_->stop = true;
  parts_->stepper.join();
}

Endpoint GripperSimulator::endpoint() const {
  require(parts_->tcp != nullptr, "this simulated gripper does not serve TCP");
  return parts_->tcp->endpoint();
}

std::string GripperSimulator::serial_path() const {
  require(parts_->rtu != nullptr, "this simulated gripper does not serve a serial line");
  return parts_->rtu->path();
}

void GripperSimulator::set_faults(const GripperFaults& faults) {
  const std::lock_guard lock(parts_->mutex);
  parts_->registers.set_faults(faults);
}

void GripperSimulator::set_faults(const ModbusFaults& faults) {
  parts_->wire.set(faults);
}

}  // namespace stonestack::emulators
