#include "protocol/modbus_frame.hpp"

#include <algorithm>
#include <array>

#include "stonestack/core/error.hpp"

namespace stonestack::protocol::modbus {
namespace {

void append(Bytes& bytes, std::uint16_t value) {
  bytes.push_back(static_cast<std::uint8_t>(value >> 8U));
  bytes.push_back(static_cast<std::uint8_t>(value & 0xFFU));
}

std::uint16_t word(View bytes, std::size_t at) {
  return static_cast<std::uint16_t>(bytes[at] * 256U + bytes[at + 1]);
}

bool is_read(std::uint8_t function) {
  return function == kReadHolding || function == kReadInput;
}

// Where the values of a write of several registers begin, behind their number of bytes; 0: no such function.
std::size_t values_begin(std::uint8_t function) {
  if (function == kWriteMany) return 6;
  return function == kReadWriteMany ? 10 : 0;
}

// Length of a PDU that starts a request; 0 while that is unknown.
std::size_t request_length(View pdu) {
  if (pdu.empty()) return 0;
  const std::size_t begin = values_begin(pdu[0]);
  if (begin == 0) return is_read(pdu[0]) || pdu[0] == kWriteOne ? 5 : 0;
  return pdu.size() < begin ? 0 : begin + pdu[begin - 1];
}

std::optional<Exception> refuse_range(int address, int count, int max) {
  if (count < 1 || count > max) return Exception::kIllegalValue;
  if (address + count > 0x10000) return Exception::kIllegalAddress;
  return std::nullopt;
}

std::optional<RtuFrame> frame_at(View bytes, std::size_t at, std::size_t pdu_length) {
  const std::size_t length = pdu_length + 3;
  if (pdu_length == 0 || at + length > bytes.size()) return std::nullopt;
  const View frame = bytes.subspan(at, length);
  const std::uint16_t sent = static_cast<std::uint16_t>(frame[length - 2] + 256U * frame[length - 1]);
  if (crc16(frame.first(length - 2)) != sent) return std::nullopt;
  const View pdu = frame.subspan(1, pdu_length);
  return RtuFrame{frame[0], Bytes(pdu.begin(), pdu.end()), at + length};
}

}  // namespace

std::string exception_text(std::uint8_t code) {
  const char* name = "not in the standard";
  switch (static_cast<Exception>(code)) {
    case Exception::kIllegalFunction:
      name = "illegal function";
      break;
    case Exception::kIllegalAddress:
      name = "illegal data address";
      break;
    case Exception::kIllegalValue:
      name = "illegal data value";
      break;
    case Exception::kDeviceFailure:
      name = "device failure";
      break;
    case Exception::kAcknowledge:
      name = "acknowledged, still at work";
      break;
    case Exception::kBusy:
      name = "busy";
      break;
    case Exception::kGatewayPath:
      name = "gateway path unavailable";
      break;
    case Exception::kGatewayTarget:
      name = "gateway target does not respond";
      break;
  }
  return concat(static_cast<int>(code), " (", name, ")");
}

bool reads(const Request& request) {
  return is_read(request.function) || request.function == kReadWriteMany;
}

bool writes(const Request& request) {
  return !is_read(request.function);
}

std::uint16_t first_written(const Request& request) {
  return request.function == kReadWriteMany ? request.write_address : request.address;
}

Bytes request_pdu(const Request& request) {
  Bytes pdu{request.function};
  append(pdu, request.address);
  if (request.function == kWriteOne) {
    append(pdu, request.values.at(0));
    return pdu;
  }
  append(pdu, request.count);
  if (values_begin(request.function) == 0) return pdu;
  if (request.function == kReadWriteMany) {
    append(pdu, request.write_address);
    append(pdu, static_cast<std::uint16_t>(request.values.size()));
  }
  pdu.push_back(static_cast<std::uint8_t>(2 * request.values.size()));
  for (const auto value : request.values) append(pdu, value);
  return pdu;
}

std::variant<Request, Exception> parse_request(View pdu) {
  if (pdu.empty() || request_length(pdu) == 0)
    return !pdu.empty() && values_begin(pdu[0]) > 0 ? Exception::kIllegalValue : Exception::kIllegalFunction;
  if (pdu.size() != request_length(pdu)) return Exception::kIllegalValue;
  Request request{pdu[0], word(pdu, 1), 1, {}};
  if (request.function == kWriteOne) {
    request.values = {word(pdu, 3)};
    return request;
  }
  request.count = word(pdu, 3);
  const std::size_t begin = values_begin(request.function);
  const int max = request.function == kWriteMany ? kMaxWritten : kMaxRead;
  if (const auto wrong = refuse_range(request.address, request.count, max)) return *wrong;
  if (begin == 0) return request;
  int written = request.count;
  if (request.function == kReadWriteMany) {
    request.write_address = word(pdu, 5);
    written = word(pdu, 7);
    if (const auto wrong = refuse_range(request.write_address, written, kMaxWrittenBesideRead)) return *wrong;
  }
  if (pdu[begin - 1] != 2 * written) return Exception::kIllegalValue;
  for (std::size_t at = begin; at < pdu.size(); at += 2) request.values.push_back(word(pdu, at));
  return request;
}

Bytes reply_pdu(const Request& request, std::span<const std::uint16_t> registers) {
  Bytes pdu{request.function};
  if (reads(request)) {
    pdu.push_back(static_cast<std::uint8_t>(2 * registers.size()));
    for (const auto value : registers) append(pdu, value);
    return pdu;
  }
  append(pdu, request.address);
  append(pdu, request.function == kWriteOne ? request.values.at(0) : request.count);
  return pdu;
}

Bytes exception_pdu(std::uint8_t function, Exception code) {
  return {static_cast<std::uint8_t>(function | kExceptionBit), static_cast<std::uint8_t>(code)};
}

Reply parse_reply(const Request& request, View pdu) {
  Reply reply;
  if (pdu.size() == 2 && pdu[0] == (request.function | kExceptionBit)) {
    reply.kind = Reply::Kind::kException;
    reply.exception = pdu[1];
    return reply;
  }
  if (reads(request)) {
    const std::size_t count = 2U * request.count;
    if (pdu.size() != count + 2 || pdu[0] != request.function || pdu[1] != count) return reply;
    for (std::size_t i = 0; i < request.count; ++i) reply.registers.push_back(word(pdu, 2 + 2 * i));
  } else {
    const Bytes echo = reply_pdu(request, {});
    if (!std::equal(pdu.begin(), pdu.end(), echo.begin(), echo.end())) return reply;
  }
  reply.kind = Reply::Kind::kDone;
  return reply;
}

std::optional<TcpHeader> parse_tcp_header(View header) {
  if (header.size() < kTcpHeader) return std::nullopt;
  const std::uint16_t length = word(header, 4);
  if (word(header, 2) != 0 || length < 2 || length > kLongestPdu + 1) return std::nullopt;
  return TcpHeader{word(header, 0), length, header[6]};
}

Bytes tcp_frame(std::uint16_t transaction, std::uint8_t unit, View pdu) {
  Bytes frame;
  append(frame, transaction);
  append(frame, 0);
  append(frame, static_cast<std::uint16_t>(pdu.size() + 1));
  frame.push_back(unit);
  frame.insert(frame.end(), pdu.begin(), pdu.end());
  return frame;
}

std::uint16_t crc16(View bytes) {
  unsigned crc = 0xFFFFU;
  for (const auto byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1U) ^ ((crc & 1U) != 0 ? 0xA001U : 0U);
  }
  return static_cast<std::uint16_t>(crc);
}

Bytes rtu_frame(std::uint8_t unit, View pdu) {
  Bytes frame;
  frame.reserve(pdu.size() + 3);
  frame.push_back(unit);
  for (const auto byte : pdu) frame.push_back(byte);
  const std::uint16_t crc = crc16(frame);
  frame.push_back(static_cast<std::uint8_t>(crc & 0xFFU));
  frame.push_back(static_cast<std::uint8_t>(crc >> 8U));
  return frame;
}

std::optional<RtuFrame> find_rtu_reply(View bytes, std::uint8_t unit, const Request& request) {
  const std::size_t done = reads(request) ? 2U + 2U * request.count : 5U;
  for (std::size_t at = 0; at + 5 <= bytes.size(); ++at) {
    if (bytes[at] != unit || (bytes[at + 1] & ~kExceptionBit) != request.function) continue;
    const auto frame = frame_at(bytes, at, (bytes[at + 1] & kExceptionBit) != 0 ? 2U : done);
    if (frame && parse_reply(request, frame->pdu).kind != Reply::Kind::kMalformed) return frame;
  }
  return std::nullopt;
}

std::optional<RtuFrame> find_rtu_request(View bytes) {
  for (std::size_t at = 0; at + 5 <= bytes.size(); ++at)
    if (const auto frame = frame_at(bytes, at, request_length(bytes.subspan(at + 1)))) return frame;
  return std::nullopt;
}

std::optional<RtuFrame> whole_rtu_frame(View bytes) {
  return bytes.size() < 4 ? std::nullopt : frame_at(bytes, 0, bytes.size() - 3);
}

std::string hex_text(View bytes, std::size_t max) {
  constexpr std::array<char, 17> kDigits{"0123456789ABCDEF"};
  std::string text = bytes.size() > max ? ".. " : "";
  for (const auto byte : bytes.last(std::min(max, bytes.size()))) {
    text += kDigits[byte >> 4U];
    text += kDigits[byte & 15U];
    text += ' ';
  }
  if (!text.empty()) text.pop_back();
  return text;
}

}  // namespace stonestack::protocol::modbus
