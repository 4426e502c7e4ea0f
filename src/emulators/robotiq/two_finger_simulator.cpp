#include "emulators/robotiq/two_finger_simulator.hpp"

#include <array>
#include <atomic>
#include <chrono>
#include <utility>

#include "emulators/logged_thread.hpp"
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
constexpr double kLineEnd = 0.01;     // s until a request without a line end is answered; design choice

/// The registers [first, first + count) of a block that begins at `base`.
template <std::size_t kSize>
std::optional<std::vector<std::uint16_t>> part(const std::array<std::uint16_t, kSize>& words, int base,
                                               int first, int count) {
  if (first < base || first + count > base + static_cast<int>(kSize)) return std::nullopt;
  return std::vector<std::uint16_t>(words.begin() + (first - base), words.begin() + (first - base + count));
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

  Parts(GripperPlant& plant, const GripperFile& file, const GripperSimulatorOptions& options)
      : registers(plant, file, options.unit), speed_up(options.speed_up) {}

  std::variant<std::vector<std::uint16_t>, modbus::Exception> handle(const modbus::Request& request) {
    const std::lock_guard lock(mutex);
    const int first = modbus::first_written(request), count = static_cast<int>(request.values.size());
    const bool has_place = part(registers.commands(), kTwoFingerCommands, first, count).has_value();
    if ((modbus::writes(request) && !has_place) || (modbus::reads(request) && !read(request)))
      return modbus::Exception::kIllegalAddress;
    if (modbus::writes(request)) registers.write(first - kTwoFingerCommands, request.values);
    return modbus::reads(request) ? *read(request) : std::vector<std::uint16_t>{};
  }

  [[nodiscard]] std::optional<std::vector<std::uint16_t>> read(const modbus::Request& request) const {
    if (auto words = part(registers.commands(), kTwoFingerCommands, request.address, request.count))
      return words;
    return part(registers.status(), kTwoFingerStatus, request.address, request.count);
  }

  void serve(TcpStream& stream) {
    std::string kept;
    for (bool bare = false;;) {
      if (const auto end = kept.find('\n'); end != std::string::npos) {
        const std::string line = kept.substr(0, end);
        kept.erase(0, end + 1);
        const bool late_end = std::exchange(bare, false) && (line.empty() || line == "\r");
        if (!late_end && !reply(stream, line, false)) return;
        continue;
      }
      if (kept.size() > kMaxGripperLine)
        throw DeviceError(stream.name(), concat("sent a line longer than ", kMaxGripperLine, " bytes"),
                          "check that the right program connects here");
      std::array<std::uint8_t, kMaxGripperLine> part;
      const bool may_be_all = is_request(kept);
      const IoResult got = stream.read_some(part, Deadline::in(may_be_all ? kLineEnd : kTextIdle));
      if (!got && !(may_be_all && got.status == IoStatus::kTimeOut)) return;
      kept.append(part.begin(), part.begin() + static_cast<std::ptrdiff_t>(got.bytes));
      if (got) continue;
      bare = true;
      if (!reply(stream, std::exchange(kept, {}), true)) return;
    }
  }

  static bool is_request(const std::string& text) {
    const auto parsed = parse_gripper_line(text);
    return parsed && !parsed->get.empty() && text.back() != '\r';
  }

  bool reply(TcpStream& stream, const std::string& sent, bool bare) {
    std::string answer = "?";
    if (!wire.take(&ModbusFaults::exceptions)) {
      const std::lock_guard lock(mutex);
      const std::string line = wire.take(&ModbusFaults::wrong_transaction) ? "GET SPE" : sent;
      answer = bare ? registers.bare_answer(line) : registers.answer(line);
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
  parts_ = std::make_unique<Parts>(plant, file, options);
  Parts& parts = *parts_;
  if (options.tcp)
    parts.tcp = std::make_unique<TcpService>(ListenOptions{options.address, options.port},
                                             [&parts](TcpStream& stream) { parts.serve(stream); });
  if (options.rtu)
    parts.rtu = std::make_unique<ModbusRtuServer>(
        options.link, options.unit,
        [&parts](const modbus::Request& request) { return parts.handle(request); }, parts.wire);
  parts.stepper = make_logged_thread("simulated gripper", [&parts] { parts.step(); });
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
