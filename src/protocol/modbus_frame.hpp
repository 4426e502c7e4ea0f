#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "stonestack/core/rooms.hpp"

/// The bytes of Modbus, for both ends of the wire (Modbus Application Protocol 1.1b3, Modbus over serial line
/// 1.02). A PDU is function code and data; TCP puts a header of 7 bytes before it, RTU a unit id before and a
/// CRC after it. Parsers accept any bytes.
namespace stonestack::protocol::modbus {

using Bytes = std::vector<std::uint8_t>;
using View = std::span<const std::uint8_t>;

inline constexpr std::uint8_t kReadHolding = 3, kReadInput = 4, kWriteOne = 6, kWriteMany = 16,
                              kReadWriteMany = 23;
inline constexpr std::uint8_t kExceptionBit = 0x80;
inline constexpr int kMaxRead = 125, kMaxWritten = 123,
                     kMaxWrittenBesideRead = 121;  ///< registers in one request
inline constexpr std::size_t kTcpHeader = 7, kLongestPdu = 253;

enum class Exception : std::uint8_t {
  kIllegalFunction = 1,
  kIllegalAddress = 2,
  kIllegalValue = 3,
  kDeviceFailure = 4,
  kAcknowledge = 5,
  kBusy = 6,
  kGatewayPath = 10,
  kGatewayTarget = 11,
};
/// "2 (illegal data address)"; also for codes that the standard does not have.
[[nodiscard]] std::string exception_text(std::uint8_t code);

/// One of the five requests. `values` is empty for reads; `count` is 1 for kWriteOne. Of kReadWriteMany
/// `address` and `count` are what is read.
struct Request {
  std::uint8_t function = kReadHolding;
  std::uint16_t address = 0;
  std::uint16_t count = 1;
  std::vector<std::uint16_t> values;
  std::uint16_t write_address = 0;  ///< of kReadWriteMany, which writes before it reads
};
[[nodiscard]] bool reads(const Request& request);
[[nodiscard]] bool writes(const Request& request);
/// The first register that a request writes.
[[nodiscard]] std::uint16_t first_written(const Request& request);
[[nodiscard]] Bytes request_pdu(const Request& request);
/// Parses a PDU on the server: the request, or the exception that it answers.
[[nodiscard]] std::variant<Request, Exception> parse_request(View pdu);
/// The answer; `registers` are what was read, unused for writes.
[[nodiscard]] Bytes reply_pdu(const Request& request, std::span<const std::uint16_t> registers);
[[nodiscard]] Bytes exception_pdu(std::uint8_t function, Exception code);

/// Parsed reply PDU to a client's request.
struct Reply {
  enum class Kind { kDone, kException, kMalformed };
  Kind kind = Kind::kMalformed;
  std::vector<std::uint16_t> registers;  ///< kDone of a read
  std::uint8_t exception = 0;
};
[[nodiscard]] Reply parse_reply(const Request& request, View pdu);

/// The header of a TCP frame; `length` counts the unit id and the PDU.
struct TcpHeader {
  std::uint16_t transaction = 0;
  std::uint16_t length = 0;
  std::uint8_t unit = 0;
};
/// Empty for another protocol than 0 or a length outside 2..254: the framing is lost then.
[[nodiscard]] std::optional<TcpHeader> parse_tcp_header(View header);
[[nodiscard]] Bytes tcp_frame(std::uint16_t transaction, std::uint8_t unit, View pdu);

/// CRC-16 of the serial line (polynomial 0xA001, start 0xFFFF); sent low byte first.
[[nodiscard]] std::uint16_t crc16(View bytes);
[[nodiscard]] Bytes rtu_frame(std::uint8_t unit, View pdu);
/// A frame with a right CRC, found in `bytes`.
struct RtuFrame {
  std::uint8_t unit = 0;
  Bytes pdu;
  std::size_t end = 0;  ///< index behind the frame
};
/// The first reply to `request` by `unit` anywhere in `bytes`, so that noise before it does no harm.
[[nodiscard]] std::optional<RtuFrame> find_rtu_reply(View bytes, std::uint8_t unit, const Request& request);
/// The first request to anybody anywhere in `bytes`.
[[nodiscard]] std::optional<RtuFrame> find_rtu_request(View bytes);
/// The first frame with a right CRC at the very start, of any function: for requests that a server does not
/// know.
[[nodiscard]] std::optional<RtuFrame> whole_rtu_frame(View bytes);

/// "09 03 02 31 00": bytes for a message, at most the last `max`.
[[nodiscard]] std::string hex_text(View bytes, std::size_t max = 24);

}  // namespace stonestack::protocol::modbus
