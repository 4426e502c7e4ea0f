#include <array>

#include "core/socket.hpp"
#include "hardware/constants.hpp"
#include "hardware/robotiq/modbus_transport.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::hardware {
namespace {

using namespace modbus;

class TcpTransport final : public ModbusTransport {
 public:
  explicit TcpTransport(const ModbusOptions& options) : options_(options) { connect(); }

  ModbusAttempt exchange(const Request& request) override {
    if (!stream_) connect();
    const Deadline deadline = Deadline::in(options_.reply_timeout).or_interrupt();
    const Bytes frame =
        tcp_frame(++transaction_, static_cast<std::uint8_t>(options_.unit), request_pdu(request));
    if (const IoResult sent = stream_->write_all(frame, deadline); !sent) return lost(sent.status);
    for (int late = 0;; ++late) {
      if (late > 0 && deadline.over()) return flooded(late);
      std::array<std::uint8_t, kTcpHeader> header_bytes;
      if (const IoResult got = stream_->read_exact(header_bytes, deadline); !got) {
        silent_ = got.status == IoStatus::kTimeOut && got.bytes == 0;
        return lost(got.status);
      }
      const auto header = parse_tcp_header(header_bytes);
      if (!header) return unframed(header_bytes);
      Bytes pdu(header->length - 1U);
      if (const IoResult got = stream_->read_exact(pdu, deadline); !got) return lost(got.status);
      if (header->transaction != transaction_) continue;  // late answer to an attempt that was given up
      return judge(request, *header, pdu);
    }
  }

  // After mere silence the framing is intact and a late answer is known by its transaction id; after two
  // silences the connection may be half open.
  void recover() override {
    if (!silent_ || ++silences_ > 1) stream_.reset();
    silent_ = false;
  }

 private:
  void connect() {
    stream_ = std::make_unique<TcpStream>(
        TcpStream::connect({options_.address, options_.port}, Deadline::in(kConnectTimeout).or_interrupt()));
  }

  [[nodiscard]] ModbusAttempt lost(IoStatus status) const {
    if (status == IoStatus::kClosed)
      return {std::nullopt, "the connection was closed",
              "see whether another master holds the gripper, or it was restarted"};
    return {std::nullopt, concat("no reply within ", options_.reply_timeout, " s"),
            "check unit id, wiring, and that the gripper's network module is the Modbus one"};
  }

  [[nodiscard]] ModbusAttempt flooded(int count) const {
    return {std::nullopt,
            concat("no reply within ", options_.reply_timeout, " s, but ", count, " to other requests"),
            "check that this port belongs to the gripper"};
  }

  [[nodiscard]] static ModbusAttempt unframed(View bytes) {
    return {std::nullopt, "what came is no Modbus/TCP frame: " + hex_text(bytes),
            "check that this port belongs to the gripper"};
  }

  [[nodiscard]] ModbusAttempt judge(const Request& request, const TcpHeader& header, View pdu) {
    if (header.unit != options_.unit)
      return {std::nullopt, concat("unit ", static_cast<int>(header.unit), " answered, not ", options_.unit),
              "set the unit id of the device"};
    Reply reply = parse_reply(request, pdu);
    if (reply.kind == Reply::Kind::kMalformed)
      return {std::nullopt, "the reply does not fit the request: " + hex_text(pdu),
              "check that this is the right device"};
    silences_ = 0;
    return {std::move(reply), {}, {}};
  }

  ModbusOptions options_;
  std::unique_ptr<TcpStream> stream_;
  std::uint16_t transaction_ = 0;
  bool silent_ = false;
  int silences_ = 0;
};

}  // namespace

std::unique_ptr<ModbusTransport> make_modbus_tcp(const ModbusOptions& options) {
  return std::make_unique<TcpTransport>(options);
}

}  // namespace stonestack::hardware
