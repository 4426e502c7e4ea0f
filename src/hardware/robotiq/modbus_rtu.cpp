#include <array>

#include "core/serial.hpp"
#include "hardware/constants.hpp"
#include "hardware/robotiq/modbus_transport.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::hardware {
namespace {

using namespace modbus;

constexpr std::size_t kMaxKept = 1024;  // bytes without a frame among them
constexpr int kMaxQuiet = 10;           // times `quiet` that a chattering line is waited for

class RtuTransport final : public ModbusTransport {
 public:
  explicit RtuTransport(const ModbusOptions& options) : options_(options) { open(); }

  ModbusAttempt exchange(const Request& request) override {
    if (!line_) open();
    const Deadline deadline = Deadline::in(options_.reply_timeout).or_interrupt();
    const auto unit = static_cast<std::uint8_t>(options_.unit);
    line_->discard_input();
    if (const IoResult sent = line_->write_all(rtu_frame(unit, request_pdu(request)), deadline); !sent)
      return lost(sent.status, {});
    Bytes got;
    for (;;) {
      std::array<std::uint8_t, 256> part;
      const IoResult read = line_->read_some(part, deadline);
      if (!read) return lost(read.status, got);
      got.insert(got.end(), part.begin(), part.begin() + static_cast<std::ptrdiff_t>(read.bytes));
      if (const auto frame = find_rtu_reply(got, unit, request))
        return {parse_reply(request, frame->pdu), {}, {}};
      if (got.size() > kMaxKept || deadline.over()) return lost(IoStatus::kTimeOut, got);
    }
  }

  void recover() override {
    if (!line_) return;
    std::array<std::uint8_t, 256> noise;
    for (int i = 0; i < kMaxQuiet; ++i) {
      const IoResult read = line_->read_some(noise, Deadline::in(options_.quiet));
      if (read.status == IoStatus::kClosed) line_.reset();
      if (!read) return;
    }
  }

 private:
  void open() { line_ = std::make_unique<SerialPort>(SerialPort::open(options_.device, kGripperBaud)); }

  [[nodiscard]] ModbusAttempt lost(IoStatus status, View got) {
    if (status == IoStatus::kClosed) {
      line_.reset();
      return {std::nullopt, "the serial line hung up", "plug the adapter in again"};
    }
    if (got.empty())
      return {std::nullopt, concat("no reply within ", options_.reply_timeout, " s"),
              "check power, unit id and the wires A and B"};
    return {std::nullopt, "no frame with a right CRC in " + hex_text(got),
            concat("check the rate (", kGripperBaud, " baud) and the wiring")};
  }

  ModbusOptions options_;
  std::unique_ptr<SerialPort> line_;
};

}  // namespace

std::unique_ptr<ModbusTransport> make_modbus_rtu(const ModbusOptions& options) {
  return std::make_unique<RtuTransport>(options);
}

}  // namespace stonestack::hardware
