#include "stonestack/emulators/robotiq/ft_simulator.hpp"

#include <array>

#include "emulators/robotiq/ft_serial.hpp"
#include "emulators/tcp_service.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::emulators {
namespace {

constexpr double kTurn = 0.1;     // s between looks at a client that left
constexpr double kSend = 1.0;     // s that a reader may lag behind before it is sent away
constexpr double kIdle = 3600.0;  // s that a client of the command socket may stay silent
constexpr std::string_view kZero = "SET ZRO";
constexpr std::size_t kLongest = 256;  // bytes without a command among them

}  // namespace

FieldList fields(FtFaults& o) {
  const FieldRange count{-1, 1e9};
  return {
      field("silent", o.silent, "fault 25"),
      field("deaf", o.deaf, "fault 25"),
      field("forgets", o.forgets, "fault 23: power cycle"),
      field("bad_crc", o.bad_crc, count, "", "fault 26"),
      field("lost_bytes", o.lost_bytes, count, "", "fault 26: merged frames"),
      field("noise", o.noise, count, "", "fault 26"),
      field("split", o.split, "the cap's peers read split messages"),
      field("stuck", o.stuck, "fault matrix: stuck value"),
      field("zeros", o.zeros, "fault matrix: zero"),
      field("saturated", o.saturated, "fault matrix: saturated"),
      field("spike", o.spike, {-1000.0, 1000.0}, "N", "fault matrix: spike"),
      field("drift", o.drift, {-100.0, 100.0}, "N/s", "fault 23"),
      field("rate", o.rate, {0.0, 1000.0}, "1/s", "fault matrix: 10 Hz only"),
      field("firmware", o.firmware, "fault 25: another device on this line"),
  };
}

FieldList fields(FtSimulatorOptions& o) {
  return {
      field("serial", o.serial, "ours"),
      field("link", o.link, "a name for the pseudo terminal"),
      field("unit", o.unit, {1, 247}, "", "Robotiq manual: 9"),
      field("streaming", o.streaming, "ours"),
      field("cap", o.cap, "ours"),
      field("address", o.address, "any 127.x.y.z"),
      field("port", o.port, {0, 65535}, "", "Robotiq's UR cap"),
      field("command_port", o.command_port, {0, 65535}, "", "Robotiq's UR cap"),
      field("rate", o.rate, {1.0, 1000.0}, "1/s", "Robotiq manual"),
      field("speed_up", o.speed_up, {0.01, 1000.0}, "", "ours"),
  };
}

struct FtSimulator::Parts {
  FtSource source;
  std::mutex mutex;  // of the cap's zero
  FtReading zero{};
  std::unique_ptr<FtSerialServer> serial;
  std::unique_ptr<TcpService> cap, commands;

  Parts(WrenchPlant& plant, const FtSimulatorOptions& options)
      : source(plant, options.rate, options.speed_up) {}

  void stream(TcpStream& stream) {
    for (long sent = 0; !stream.is_shut();) {
      const auto sample = source.newer_than(sent, kTurn);
      if (!sample || source.faults().silent) continue;
      sent = sample->number;
      if (!send(stream, text(sample->reading))) return;
    }
  }

  std::string text(FtReading reading) {
    {
      const std::lock_guard lock(mutex);
      for (std::size_t i = 0; i < reading.size(); ++i) reading[i] -= zero[i];
    }
    std::string message = encode_ft_text(reading);
    if (source.take(&FtFaults::lost_bytes)) message.resize(message.size() - 5);
    if (source.take(&FtFaults::noise)) message.insert(0, "12 , ) nan");
    return message;
  }

  bool send(TcpStream& stream, const std::string& message) {
    const Deadline deadline = Deadline::in(kSend);
    if (!source.faults().split) return static_cast<bool>(stream.write_all(message, deadline));
    const auto half = message.size() / 2;
    if (!stream.write_all(std::string_view(message).substr(0, half), deadline)) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    return static_cast<bool>(stream.write_all(std::string_view(message).substr(half), deadline));
  }

  void obey(TcpStream& stream) {
    for (std::string kept;;) {
      std::array<std::uint8_t, 64> bytes;
      const IoResult got = stream.read_some(bytes, Deadline::in(kIdle));
      if (!got) return;
      kept.append(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(got.bytes));
      for (auto at = kept.find(kZero); at != std::string::npos; at = kept.find(kZero)) {
        kept.erase(0, at + kZero.size());
        {
          const FtReading now = source.newest();
          const std::lock_guard lock(mutex);
          zero = now;
        }
        if (!stream.write_all("Done", Deadline::in(kSend))) return;
      }
      if (kept.size() > kLongest) return;
    }
  }
};

FtSimulator::FtSimulator(WrenchPlant& plant, const FtSimulatorOptions& options) {
  require(options.serial || options.cap, "a simulated force sensor needs a link: serial or cap");
  parts_ = std::make_unique<Parts>(plant, options);
  Parts& parts = *parts_;
  if (options.serial) parts.serial = std::make_unique<FtSerialServer>(parts.source, options);
  if (!options.cap) return;
  parts.cap = std::make_unique<TcpService>(ListenOptions{options.address, options.port},
                                           [&parts](TcpStream& stream) { parts.stream(stream); });
  parts.commands = std::make_unique<TcpService>(ListenOptions{options.address, options.command_port},
                                                [&parts](TcpStream& stream) { parts.obey(stream); });
}

FtSimulator::~FtSimulator() = default;

std::string FtSimulator::serial_path() const {
  require(parts_->serial != nullptr, "this simulated force sensor has no serial line");
  return parts_->serial->path();
}

Endpoint FtSimulator::stream_endpoint() const {
  require(parts_->cap != nullptr, "this simulated force sensor has no UR cap");
  return parts_->cap->endpoint();
}

Endpoint FtSimulator::command_endpoint() const {
  require(parts_->commands != nullptr, "this simulated force sensor has no UR cap");
  return parts_->commands->endpoint();
}

void FtSimulator::set_faults(const FtFaults& faults) {
  parts_->source.set_faults(faults);
}

}  // namespace stonestack::emulators
