#include "emulators/robotiq/two_finger_simulator.hpp"

#include <atomic>
#include <chrono>

#include "emulators/robotiq/modbus_server.hpp"
#include "emulators/robotiq/two_finger_registers.hpp"
#include "protocol/gripper_text.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::emulators {
namespace {

constexpr double kTwoFingerTick = 0.002;       // s of the host
constexpr double kLongestTwoFingerTick = 0.1;  // s: a host that was asleep does not jump
constexpr int kTwoFingerCommands = 0x03E8, kTwoFingerStatus = 0x07D0;
constexpr double kTextIdle = 3600.0;  // s that a client may stay silent
constexpr double kTextSend = 2.0;     // s that a client may take to read an answer

std::optional<int> first_register(const modbus::Request& request, int base) {
  const int first = request.address - base;
  if (first < 0 || first + request.count > TwoFingerRegisters::kCount) return std::nullopt;
  return first;
}

}  // namespace

struct TwoFingerSimulator::Parts {
  std::mutex mutex;  // of the registers and what is behind them
  TwoFingerRegisters registers;
  double speed_up;
  ModbusFaultBox wire;
  std::atomic<bool> stop = false;
  std::unique_ptr<TcpService> tcp;
  std::unique_ptr<ModbusRtuServer> rtu;
  std::thread stepper;

  Parts(GripperPlant& plant, const GripperFile& file, double faster)
      : registers(plant, file), speed_up(faster) {}

  std::variant<std::vector<std::uint16_t>, modbus::Exception> handle(const modbus::Request& request) {
    const std::lock_guard lock(mutex);
    const bool write = request.function == modbus::kWriteOne || request.function == modbus::kWriteMany;
    if (const auto first = first_register(request, kTwoFingerCommands)) {
      if (!write) return part(registers.commands(), *first, request.count);
      registers.write(*first, request.values);
      return std::vector<std::uint16_t>{};
    }
    if (const auto first = first_register(request, kTwoFingerStatus); first && !write)
      return part(registers.status(), *first, request.count);
    return modbus::Exception::kIllegalAddress;
  }

  static std::vector<std::uint16_t> part(const TwoFingerRegisters::Words& words, int first, int count) {
    return {words.begin() + first, words.begin() + first + count};
  }

  void serve(TcpStream& stream) {
    for (;;) {
      const LineResult line = stream.read_line(kMaxGripperLine, Deadline::in(kTextIdle));
      if (!line || !reply(stream, line.line)) return;
    }
  }

  bool reply(TcpStream& stream, const std::string& line) {
    std::string answer = "?";
    if (!wire.take(&ModbusFaults::exceptions)) {
      const std::lock_guard lock(mutex);
      answer = registers.answer(wire.take(&ModbusFaults::wrong_transaction) ? "GET SPE" : line);
    }
    if (wire.take(&ModbusFaults::no_reply)) return true;
    if (wire.take(&ModbusFaults::hang_up)) return false;
    if (wire.take(&ModbusFaults::delayed))
      std::this_thread::sleep_for(std::chrono::duration<double>(wire.now().delay));
    if (wire.take(&ModbusFaults::truncated)) answer.resize(answer.size() / 2);
    if (wire.take(&ModbusFaults::garbage)) answer = std::string("\xDE\xAD\xBE\xEF\x00POS", 8);
    const Deadline deadline = Deadline::in(kTextSend);
    if (!wire.now().fragments) return static_cast<bool>(stream.write_all(answer, deadline));
    for (const char c : answer) {
      if (!stream.write_all(std::string_view(&c, 1), deadline)) return false;
      std::this_thread::sleep_for(std::chrono::microseconds(500));
    }
    return true;
  }

  void step() {
    for (Stopwatch watch; !stop; std::this_thread::sleep_for(std::chrono::duration<double>(kTwoFingerTick))) {
      const double seconds = std::min(kLongestTwoFingerTick, watch.seconds());
      watch = Stopwatch();
      const std::lock_guard lock(mutex);
      registers.advance(seconds * speed_up);
    }
  }
};

TwoFingerSimulator::TwoFingerSimulator(GripperPlant& plant, const GripperFile& file,
                                       const GripperSimulatorOptions& options) {
  require(options.tcp || options.rtu, "a simulated gripper needs a link: tcp or rtu");
  parts_ = std::make_unique<Parts>(plant, file, options.speed_up);
  Parts& parts = *parts_;
  if (options.tcp)
    parts.tcp = std::make_unique<TcpService>(ListenOptions{options.address, options.port},
                                             [&parts](TcpStream& stream) { parts.serve(stream); });
  if (options.rtu)
    parts.rtu = std::make_unique<ModbusRtuServer>(
        options.link, options.unit,
        [&parts](const modbus::Request& request) { return parts.handle(request); }, parts.wire);
  parts.stepper = std::thread([&parts] { parts.step(); });
}

TwoFingerSimulator::~TwoFingerSimulator() {
  parts_->tcp.reset();
  parts_->rtu.reset();
  parts_->stop = true;
  parts_->stepper.join();
}

Endpoint TwoFingerSimulator::endpoint() const {
  require(parts_->tcp != nullptr, "this simulated gripper does not serve TCP");
  return parts_->tcp->endpoint();
}

std::string TwoFingerSimulator::serial_path() const {
  require(parts_->rtu != nullptr, "this simulated gripper does not serve a serial line");
  return parts_->rtu->path();
}

void TwoFingerSimulator::set_faults(const GripperFaults& faults) {
  const std::lock_guard lock(parts_->mutex);
  parts_->registers.set_faults(faults);
}

void TwoFingerSimulator::set_faults(const ModbusFaults& faults) {
  parts_->wire.set(faults);
}

void TwoFingerSimulator::drop_clients() {
  if (parts_->tcp) parts_->tcp->drop_clients();
}

}  // namespace stonestack::emulators
