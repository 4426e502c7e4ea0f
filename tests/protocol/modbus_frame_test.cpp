#include "protocol/modbus_frame.hpp"

#include <gtest/gtest.h>

namespace stonestack::protocol::modbus {
namespace {

// Frames of Robotiq's manual; every byte written out by hand.
const Bytes kCloseRtu{0x09, 0x10, 0x03, 0xE8, 0x00, 0x03, 0x06, 0x09,
                      0x00, 0x00, 0xFF, 0xFF, 0xFF, 0x42, 0x29};
const Bytes kCloseReplyRtu{0x09, 0x10, 0x03, 0xE8, 0x00, 0x03, 0x01, 0x30};
const Bytes kOpenRtu{0x09, 0x10, 0x03, 0xE8, 0x00, 0x03, 0x06, 0x09,
                     0x00, 0x00, 0x00, 0xFF, 0xFF, 0x72, 0x19};
const Bytes kNotActivatedRtu{0x09, 0x03, 0x02, 0x11, 0x00, 0x55, 0xD5};
const Bytes kActivatedRtu{0x09, 0x03, 0x02, 0x31, 0x00, 0x4C, 0x15};
const Bytes kReadForcesRtu{0x09, 0x03, 0x00, 0xB4, 0x00, 0x06, 0x84, 0xA6};
const Bytes kActivateTcp{0x33, 0x9A, 0x00, 0x00, 0x00, 0x0D, 0x02, 0x10, 0x00, 0x00,
                         0x00, 0x03, 0x06, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00};
const Bytes kActivateReplyTcp{0x33, 0x9A, 0x00, 0x00, 0x00, 0x06, 0x02, 0x10, 0x00, 0x00, 0x00, 0x03};

const Bytes kReadWriteRtu{0x09, 0x17, 0x07, 0xD0, 0x00, 0x02, 0x03, 0xE9, 0x00,
                          0x02, 0x04, 0x00, 0xE6, 0x3C, 0xC8, 0x2D, 0x0C};
const Bytes kReadWriteReplyRtu{0x09, 0x17, 0x04, 0x01, 0x00, 0x09, 0xE6, 0xF6, 0xC1};

const Request kReadWrite{kReadWriteMany, 0x07D0, 2, {0x00E6, 0x3CC8}, 0x03E9};
const Request kClose{kWriteMany, 0x03E8, 3, {0x0900, 0x00FF, 0xFFFF}};
const Request kOneStatus{kReadHolding, 0x07D0, 1, {}};

TEST(ModbusFrame, RequestsMatchTheManual) {
  EXPECT_EQ(rtu_frame(9, request_pdu(kClose)), kCloseRtu);
  EXPECT_EQ(rtu_frame(9, request_pdu({kWriteMany, 0x03E8, 3, {0x0900, 0x0000, 0xFFFF}})), kOpenRtu);
  EXPECT_EQ(rtu_frame(9, request_pdu({kReadHolding, 180, 6, {}})), kReadForcesRtu);
  EXPECT_EQ(tcp_frame(0x339A, 2, request_pdu({kWriteMany, 0, 3, {0x0100, 0, 0}})), kActivateTcp);
}

TEST(ModbusFrame, RepliesOfTheManualAreUnderstood) {
  const auto closed = find_rtu_reply(kCloseReplyRtu, 9, kClose);
  ASSERT_TRUE(closed);
  EXPECT_EQ(parse_reply(kClose, closed->pdu).kind, Reply::Kind::kDone);
  const auto off = find_rtu_reply(kNotActivatedRtu, 9, kOneStatus);
  ASSERT_TRUE(off);
  EXPECT_EQ(parse_reply(kOneStatus, off->pdu).registers, std::vector<std::uint16_t>{0x1100});
  const auto on = find_rtu_reply(kActivatedRtu, 9, kOneStatus);
  ASSERT_TRUE(on);
  EXPECT_EQ(parse_reply(kOneStatus, on->pdu).registers, std::vector<std::uint16_t>{0x3100});
  const auto header = parse_tcp_header(kActivateReplyTcp);
  ASSERT_TRUE(header);
  EXPECT_EQ(header->transaction, 0x339A);
  EXPECT_EQ(header->unit, 2);
  EXPECT_EQ(header->length, 6);
  const Request activate{kWriteMany, 0, 3, {0x0100, 0, 0}};
  EXPECT_EQ(parse_reply(activate, View(kActivateReplyTcp).subspan(kTcpHeader)).kind, Reply::Kind::kDone);
}

TEST(ModbusFrame, ServersAnswerTheManualsRequestsAsSpecified) {
  const auto frame = find_rtu_request(kCloseRtu);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->unit, 9);
  EXPECT_EQ(frame->end, kCloseRtu.size());
  const auto parsed = parse_request(frame->pdu);
  ASSERT_TRUE(std::holds_alternative<Request>(parsed));
  const auto& request = std::get<Request>(parsed);
  EXPECT_EQ(request.address, 0x03E8);
  EXPECT_EQ(request.values, kClose.values);
  EXPECT_EQ(rtu_frame(9, reply_pdu(request, {})), kCloseReplyRtu);
  EXPECT_EQ(rtu_frame(9, reply_pdu(kOneStatus, std::vector<std::uint16_t>{0x3100})), kActivatedRtu);
}

TEST(ModbusFrame, AReadAndAWriteInOneRequestMatchTheManual) {
  EXPECT_EQ(rtu_frame(9, request_pdu(kReadWrite)), kReadWriteRtu);
  const auto frame = find_rtu_request(kReadWriteRtu);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->end, kReadWriteRtu.size());
  const auto parsed = parse_request(frame->pdu);
  ASSERT_TRUE(std::holds_alternative<Request>(parsed));
  const auto& request = std::get<Request>(parsed);
  EXPECT_EQ(request.address, 0x07D0);
  EXPECT_EQ(request.count, 2);
  EXPECT_EQ(first_written(request), 0x03E9);
  EXPECT_EQ(request.values, kReadWrite.values);
  EXPECT_TRUE(reads(request) && writes(request));
  EXPECT_EQ(rtu_frame(9, reply_pdu(request, std::vector<std::uint16_t>{0x0100, 0x09E6})), kReadWriteReplyRtu);
  const auto reply = find_rtu_reply(kReadWriteReplyRtu, 9, kReadWrite);
  ASSERT_TRUE(reply);
  EXPECT_EQ(parse_reply(kReadWrite, reply->pdu).registers, (std::vector<std::uint16_t>{0x0100, 0x09E6}));
}

TEST(ModbusFrame, AReadAndAWriteInOneRequestHaveLimits) {
  const auto exception = [](int read, int written, int bytes, int address = 0) {
    Bytes pdu{0x17,
              0,
              0,
              0,
              static_cast<std::uint8_t>(read),
              static_cast<std::uint8_t>(address >> 8),
              static_cast<std::uint8_t>(address & 0xFF),
              0,
              static_cast<std::uint8_t>(written),
              static_cast<std::uint8_t>(bytes)};
    pdu.resize(pdu.size() + static_cast<std::size_t>(bytes));
    const auto parsed = parse_request(pdu);
    return std::holds_alternative<Exception>(parsed) ? static_cast<int>(std::get<Exception>(parsed)) : 0;
  };
  EXPECT_EQ(exception(125, 121, 242), 0);
  EXPECT_EQ(exception(126, 1, 2), 3);
  EXPECT_EQ(exception(0, 1, 2), 3);
  EXPECT_EQ(exception(1, 122, 244), 3);
  EXPECT_EQ(exception(1, 0, 0), 3);
  EXPECT_EQ(exception(1, 2, 2), 3) << "byte count";
  EXPECT_EQ(exception(1, 1, 3), 3) << "byte count";
  EXPECT_EQ(exception(1, 2, 4, 0xFFFF), 2) << "over the end";
  const auto cut = parse_request(Bytes{0x17, 0, 0, 0, 1, 0});
  ASSERT_TRUE(std::holds_alternative<Exception>(cut));
  EXPECT_EQ(std::get<Exception>(cut), Exception::kIllegalValue);
}

TEST(ModbusFrame, AnyFlippedBitIsFoundByTheCrc) {
  for (std::size_t bit = 0; bit < 8 * kActivatedRtu.size(); ++bit) {
    Bytes frame = kActivatedRtu;
    frame[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
    EXPECT_FALSE(find_rtu_reply(frame, 9, kOneStatus)) << "bit " << bit;
  }
}

TEST(ModbusFrame, AReplyIsFoundBehindNoiseAndNotInAPartOfIt) {
  Bytes bytes{0xFF, 0xFF, 0x09, 0x03, 0x02, 0x11};
  bytes.insert(bytes.end(), kActivatedRtu.begin(), kActivatedRtu.end());
  const auto frame = find_rtu_reply(bytes, 9, kOneStatus);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->pdu, (Bytes{0x03, 0x02, 0x31, 0x00}));
  for (std::size_t cut = 0; cut < kActivatedRtu.size(); ++cut)
    EXPECT_FALSE(find_rtu_reply(View(kActivatedRtu).first(cut), 9, kOneStatus)) << cut;
  EXPECT_FALSE(find_rtu_reply(kActivatedRtu, 2, kOneStatus)) << "another unit's reply";
  EXPECT_FALSE(find_rtu_reply(kActivatedRtu, 9, {kReadInput, 0x07D0, 1, {}})) << "another function's reply";
}

TEST(ModbusFrame, ExceptionsCarryTheirCode) {
  const Reply reply = parse_reply(kOneStatus, Bytes{0x83, 0x02});
  EXPECT_EQ(reply.kind, Reply::Kind::kException);
  EXPECT_EQ(exception_text(reply.exception), "2 (illegal data address)");
  EXPECT_EQ(exception_text(99), "99 (not in the standard)");
  const auto frame =
      find_rtu_reply(rtu_frame(9, exception_pdu(kReadHolding, Exception::kBusy)), 9, kOneStatus);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->pdu, (Bytes{0x83, 0x06}));
}

TEST(ModbusFrame, MalformedRepliesAreRefused) {
  for (const Bytes& pdu : {Bytes{}, Bytes{0x03}, Bytes{0x03, 0x02, 0x31}, Bytes{0x03, 0x04, 0x31, 0x00},
                           Bytes{0x04, 0x02, 0x31, 0x00}, Bytes{0x03, 0x02, 0x31, 0x00, 0x00}, Bytes{0x83}})
    EXPECT_EQ(parse_reply(kOneStatus, pdu).kind, Reply::Kind::kMalformed) << hex_text(pdu);
  EXPECT_EQ(parse_reply(kClose, Bytes{0x10, 0x03, 0xE8, 0x00, 0x02}).kind, Reply::Kind::kMalformed);
}

TEST(ModbusFrame, MalformedRequestsGetTheStandardsExceptions) {
  const auto exception = [](const Bytes& pdu) {
    const auto parsed = parse_request(pdu);
    return std::holds_alternative<Exception>(parsed) ? static_cast<int>(std::get<Exception>(parsed)) : 0;
  };
  EXPECT_EQ(exception({}), 1);
  EXPECT_EQ(exception({0x2B, 0x0E, 0x01, 0x00}), 1);
  EXPECT_EQ(exception({0x03, 0x00, 0x00, 0x00, 0x00}), 3) << "count 0";
  EXPECT_EQ(exception({0x03, 0x00, 0x00, 0x00, 0x7E}), 3) << "count 126";
  EXPECT_EQ(exception({0x03, 0x00, 0x00}), 3) << "cut";
  EXPECT_EQ(exception({0x03, 0xFF, 0xFF, 0x00, 0x02}), 2) << "over the end";
  EXPECT_EQ(exception({0x10, 0x00, 0x00, 0x00, 0x02, 0x02, 0x00, 0x00}), 3) << "byte count";
  EXPECT_EQ(exception({0x10, 0x00}), 3) << "cut";
  EXPECT_EQ(exception({0x03, 0x00, 0x00, 0x00, 0x7D}), 0) << "125 are allowed";
}

TEST(ModbusFrame, HeadersThatLoseTheFramingAreRefused) {
  EXPECT_FALSE(parse_tcp_header(Bytes{0, 1, 0, 1, 0, 6, 2})) << "protocol 1";
  EXPECT_FALSE(parse_tcp_header(Bytes{0, 1, 0, 0, 0, 1, 2})) << "length 1";
  EXPECT_FALSE(parse_tcp_header(Bytes{0, 1, 0, 0, 0, 255, 2})) << "length 255";
  EXPECT_FALSE(parse_tcp_header(Bytes{0, 1, 0, 0, 0xFF, 0xFF, 2})) << "length 65535";
  EXPECT_FALSE(parse_tcp_header(Bytes{0, 1, 0, 0, 0, 6})) << "cut";
  EXPECT_TRUE(parse_tcp_header(Bytes{0, 1, 0, 0, 0, 254, 2}));
}

}  // namespace
}  // namespace stonestack::protocol::modbus
