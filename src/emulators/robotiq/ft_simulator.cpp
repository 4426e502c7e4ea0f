#include "emulators/robotiq/ft_simulator.hpp"

#include <array>

#include "emulators/robotiq/ft_serial.hpp"
#include "emulators/tcp_service.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::emulators {
namespace {

constexpr double kFtTurn = 0.1;     // s between checks for a client that left
constexpr double kFtSend = 1.0;     // s that a reader may lag behind before it is sent away
constexpr double kFtIdle = 3600.0;  // s that a client of the command socket may stay silent
constexpr std::string_view kZero = "SET ZRO";
constexpr std::size_t kLongest = 256;  // bytes without a command among them

}  // namespace

FieldList fields(FtFaults& o) {
  const FieldRange count{-1, 1e9};
  return {
      field("silent", o.silent, "true: neither streams nor answers"),
      field("deaf", o.deaf, "true: streams on, whatever is sent"),
      field("forgets", o.forgets, "true: a power cycle ends the stream, once"),
      field("bad_crc", o.bad_crc, count, "", "frames with a flipped bit (serial)"),
      field("lost_bytes", o.lost_bytes, count, "", "frames without their last bytes"),
      field("noise", o.noise, count, "", "bursts of bytes that are no frame"),
      field("split", o.split, "true: frames come in two pieces"),
      field("stuck", o.stuck, "true: one reading is repeated"),
      field("zeros", o.zeros, "true: all readings are zero"),
      field("saturated", o.saturated, "true: readings are the largest that a frame carries"),
      field("spike", o.spike, {-1000.0, 1000.0}, "N", "added to Fz of the next frame"),
      field("drift", o.drift, {-100.0, 100.0}, "N/s", "of Fz"),
      field("rate", o.rate, {0.0, 1000.0}, "1/s", "of readings in place of the right one; 0: right"),
      field("firmware", o.firmware, "another device's answer on this line; empty: the right one"),
  };
}

FieldList fields(FtSimulatorOptions& o) {
  return {
      field("serial", o.serial, "true: the sensor's own line, on a pseudo terminal"),
      field("link", o.link, "name of the pseudo terminal"),
      field("unit", o.unit, {1, 247}, "", "Modbus unit; Robotiq manual: 9"),
      field("streaming", o.streaming, "true: the line streams from the start"),
      field("cap", o.cap, "true: the UR cap's servers"),
      field("address", o.address, "any 127.x.y.z"),
      field("port", o.port, {0, 65535}, "", "of the UR cap; 0: a free one"),
      field("command_port", o.command_port, {0, 65535}, "", "of the UR cap, for SET ZRO; 0: a free one"),
      field("rate", o.rate, {1.0, 1000.0}, "1/s", "of readings; Robotiq manual: 100"),
      field("speed_up", o.speed_up, {0.01, 1000.0}, "", "simulated seconds in a second"),
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
      const auto sample = source.newer_than(sent, kFtTurn);
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
    const Deadline deadline = Deadline::in(kFtSend);
    if (!source.faults().split) return static_cast<bool>(stream.write_all(message, deadline));
    const auto half = message.size() / 2;
    if (!stream.write_all(std::string_view(message).substr(0, half), deadline)) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    return static_cast<bool>(stream.write_all(std::string_view(message).substr(half), deadline));
  }

  void obey(TcpStream& stream) {
    for (std::string kept;;) {
      std::array<std::uint8_t, 64> bytes;
      const IoResult got = stream.read_some(bytes, Deadline::in(kFtIdle));
      if (!got) return;
      kept.append(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(got.bytes));
      for (auto at = kept.find(kZero); at != std::string::npos; at = kept.find(kZero)) {
        kept.erase(0, at + kZero.size());
        {
          const FtReading now = source.newest();
          const std::lock_guard lock(mutex);
          zero = now;
        }
        if (!stream.write_all("Done", Deadline::in(kFtSend))) return;
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
