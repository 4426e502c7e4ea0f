#include "emulators/robotiq/ft_serial.hpp"

#include <array>
#include <chrono>
#include <cmath>

#include "emulators/logged_thread.hpp"

namespace stonestack::emulators {
namespace {

constexpr double kTurn = 0.002;       // s between reads of the line
constexpr double kSerialSend = 0.05;  // s that a reader may lag behind
constexpr std::size_t kJam = 50;      // bytes 0xFF that stop the stream (manual)
constexpr std::array<std::uint8_t, 6> kNoise{0x20, 0x4E, 0x20, 0x00, 0xFF, 0x4E};
constexpr std::uint16_t kStreamOn = 0x0200;
constexpr int kForces = 180, kAcceleration = 190, kOutputSelect = 410, kFirmware = 500, kSerialNumber = 510,
              kYear = 514;
// Three letters and three numbers (Robotiq's driver); the serial number's low word stands before its high
// word.
constexpr std::string_view kFirmwareText("FTS\2\0\1", 6), kSerialText("FTS\0\0\1\0\0", 8);
constexpr std::uint16_t kYearBuilt = 2016;

std::uint16_t text_word(std::string_view text, int index) {
  const auto at = [&](int i) {
    const auto k = static_cast<std::size_t>(i);
    return k < text.size() ? static_cast<unsigned char>(text[k]) : 0U;
  };
  return static_cast<std::uint16_t>(at(2 * index) << 8U | at(2 * index + 1));
}

}  // namespace

FtSerialServer::FtSerialServer(FtSource& source, const FtSimulatorOptions& options)
    : source_(&source),
      line_(PseudoTerminal::open(options.link)),
      unit_(static_cast<std::uint8_t>(options.unit)),
      streaming_(options.streaming),
      thread_(make_logged_thread("simulated force sensor at " + line_.path(), [this] { run(); })) {}

FtSerialServer::~FtSerialServer() {
  stop_ = true;
  line_.shut();
  thread_.join();
}

void FtSerialServer::run() {
  for (long sent = 0; !stop_;) {
    listen(kTurn);
    if (source_->take_power_cycle()) streaming_ = false;
    const auto sample = source_->newer_than(sent, 0.0);
    if (!sample) continue;
    sent = sample->number;
    if (streaming_ && !source_->faults().silent) stream(sample->reading);
  }
}

void FtSerialServer::listen(double seconds) {
  std::array<std::uint8_t, 256> bytes;
  const IoResult got = line_.read_some(bytes, Deadline::in(seconds));
  const FtFaults faults = source_->faults();
  if (got.bytes == 0 || faults.silent || faults.deaf) return;
  for (std::size_t i = 0; i < got.bytes; ++i) {
    jammed_ = bytes[i] == 0xFF ? jammed_ + 1 : 0;
    if (jammed_ >= kJam) streaming_ = false;
    kept_.push_back(bytes[i]);
  }
  if (kept_.size() > 512) kept_.erase(kept_.begin(), kept_.end() - 256);
  if (streaming_) return kept_.clear();
  while (const auto frame = modbus::find_rtu_request(kept_)) {
    kept_.erase(kept_.begin(), kept_.begin() + static_cast<std::ptrdiff_t>(frame->end));
    if (frame->unit == unit_) answer(*frame);
  }
}

std::optional<std::uint16_t> FtSerialServer::register_value(int address) {
  if (address >= kForces && address < kForces + 6) {
    const auto frame = encode_ft_frame(source_->newest());
    const auto i = 2 + 2 * static_cast<std::size_t>(address - kForces);
    return static_cast<std::uint16_t>(frame[i] + 256U * frame[i + 1]);
  }
  if (address >= kAcceleration && address < kAcceleration + 3)
    return static_cast<std::uint16_t>(address == kAcceleration + 2 ? 1000 : 0);  // 1 g along z
  if (address == kOutputSelect) return streaming_ ? kStreamOn : std::uint16_t{0};
  const std::string other = source_->faults().firmware;
  if (address >= kFirmware && address < kFirmware + 6)
    return text_word(other.empty() ? kFirmwareText : std::string_view(other), address - kFirmware);
  if (address >= kSerialNumber && address < kSerialNumber + 4)
    return text_word(kSerialText, address - kSerialNumber);
  if (address == kYear) return kYearBuilt;
  return std::nullopt;
}

void FtSerialServer::answer(const modbus::RtuFrame& frame) {
  const auto parsed = modbus::parse_request(frame.pdu);
  if (!std::holds_alternative<modbus::Request>(parsed)) return;
  const auto& request = std::get<modbus::Request>(parsed);
  if (request.function == modbus::kReadWriteMany) return;  // the sensor does not have it
  std::vector<std::uint16_t> values;
  if (modbus::reads(request)) {
    for (int i = 0; i < request.count; ++i) {
      const auto value = register_value(request.address + i);
      if (!value)
        return send(modbus::rtu_frame(
            unit_, modbus::exception_pdu(request.function, modbus::Exception::kIllegalAddress)));
      values.push_back(*value);
    }
  } else if (request.address != kOutputSelect || request.count != 1) {
    return send(modbus::rtu_frame(
        unit_, modbus::exception_pdu(request.function, modbus::Exception::kIllegalAddress)));
  }
  send(modbus::rtu_frame(unit_, modbus::reply_pdu(request, values)));
  if (!request.values.empty()) streaming_ = request.values[0] == kStreamOn;
  jammed_ = 0;
}

void FtSerialServer::stream(const FtReading& reading) {
  const auto frame = encode_ft_frame(reading);
  modbus::Bytes bytes(frame.begin(), frame.end());
  if (source_->take(&FtFaults::bad_crc)) bytes.back() ^= 0x10U;
  if (source_->take(&FtFaults::lost_bytes)) bytes.resize(bytes.size() - 5);
  if (source_->take(&FtFaults::noise)) bytes.insert(bytes.begin(), kNoise.begin(), kNoise.end());
  if (!source_->faults().split) return send(bytes);
  send(std::span(bytes).first(bytes.size() / 2));
  std::this_thread::sleep_for(std::chrono::duration<double>(kTurn));
  send(std::span(bytes).subspan(bytes.size() / 2));
}

void FtSerialServer::send(std::span<const std::uint8_t> bytes) {
  if (!line_.write_all(bytes, Deadline::in(kSerialSend))) line_.discard_output();  // nobody reads
}

}  // namespace stonestack::emulators
