#include "protocol/ft_frames.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace stonestack::protocol {
namespace {

using Bytes = std::vector<std::uint8_t>;

// 1.00 N, -2.00 N, 300.00 N, 0.010 Nm, -0.020 Nm, 30.000 Nm; the CRC comes from slow_crc below, which is
// checked against a frame of the manual.
const Bytes kFrame{0x20, 0x4E, 0x64, 0x00, 0x38, 0xFF, 0x30, 0x75, 0x0A, 0x00, 0xEC, 0xFF, 0x30, 0x75};
const FtReading kReading{1.0, -2.0, 300.0, 0.01, -0.02, 30.0};

// Bit by bit, apart from the library's own.
std::uint16_t slow_crc(const Bytes& bytes) {
  unsigned crc = 0xFFFF;
  for (const unsigned byte : bytes)
    for (unsigned bit = 0; bit < 8; ++bit) {
      const unsigned feedback = (crc ^ (byte >> bit)) & 1U;
      crc = crc >> 1U ^ (feedback != 0 ? 0xA001U : 0U);
    }
  return static_cast<std::uint16_t>(crc);
}

Bytes whole_frame() {
  Bytes frame = kFrame;
  const auto crc = slow_crc(kFrame);
  frame.push_back(static_cast<std::uint8_t>(crc & 0xFFU));
  frame.push_back(static_cast<std::uint8_t>(crc >> 8U));
  return frame;
}

Bytes text(const char* words) {
  const std::string_view view(words);
  return {view.begin(), view.end()};
}

std::vector<FtReading> readings(FtParser& parser) {
  std::vector<FtReading> all;
  while (const auto reading = parser.next()) all.push_back(*reading);
  return all;
}

TEST(FtFrames, AFrameSpelledByHand) {
  EXPECT_EQ(slow_crc({0x09, 0x03, 0x00, 0xB4, 0x00, 0x06}), 0xA684) << "the manual's own example";
  FtParser parser(FtParser::Format::kSerial);
  parser.feed(whole_frame());
  EXPECT_EQ(readings(parser), std::vector<FtReading>{kReading});
  EXPECT_EQ(parser.bad_bytes(), 0);
  const auto encoded = encode_ft_frame(kReading);
  EXPECT_EQ(Bytes(encoded.begin(), encoded.end()), whole_frame());
}

TEST(FtFrames, CutAtEveryByteTheSecondHalfCompletesIt) {
  for (std::size_t cut = 0; cut <= kFtFrame; ++cut) {
    FtParser parser(FtParser::Format::kSerial);
    const Bytes frame = whole_frame();
    parser.feed(std::span(frame).first(cut));
    const std::size_t early = readings(parser).size();
    parser.feed(std::span(frame).subspan(cut));
    EXPECT_EQ(early + readings(parser).size(), 1U) << cut;
  }
}

TEST(FtFrames, ResyncsBehindALostTailAndBehindNoise) {
  FtParser parser(FtParser::Format::kSerial);
  Bytes bytes = whole_frame();
  bytes.resize(11);  // the next frame follows at once
  for (const auto byte : whole_frame()) bytes.push_back(byte);
  for (const int byte : {0x20, 0x4E, 0x20, 0x00}) bytes.push_back(static_cast<std::uint8_t>(byte));
  for (const auto byte : whole_frame()) bytes.push_back(byte);
  parser.feed(bytes);
  EXPECT_EQ(readings(parser).size(), 2U);
  EXPECT_EQ(parser.bad_bytes(), 15);
}

TEST(FtFrames, AnyFlippedBitIsFound) {
  for (std::size_t bit = 0; bit < 8 * kFtFrame; ++bit) {
    Bytes frame = whole_frame();
    frame[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
    FtParser parser(FtParser::Format::kSerial);
    parser.feed(frame);
    EXPECT_TRUE(readings(parser).empty()) << bit;
  }
}

TEST(FtFrames, NoiseWithoutEndIsNotKept) {
  FtParser parser(FtParser::Format::kSerial);
  const Bytes noise(1000, 0x20);
  for (int i = 0; i < 1000; ++i) parser.feed(noise);
  EXPECT_GT(parser.bad_bytes(), 900000);
  parser.feed(whole_frame());
  EXPECT_EQ(readings(parser).size(), 1U);
}

TEST(FtFrames, TheCapsMessagesComeConcatenatedAndSplit) {
  FtParser parser(FtParser::Format::kCap);
  parser.feed(text("7 , 8)(1.0 , -2.0 , 300.0 , 0.01 , -0.02 , 30.0)(1.0 , -2.0 , 300.0 , 0.0"));
  EXPECT_EQ(readings(parser), std::vector<FtReading>{kReading});
  parser.feed(text("1 , -0.02 , 30.0)"));
  EXPECT_EQ(readings(parser), std::vector<FtReading>{kReading});
  EXPECT_EQ(parser.bad_bytes(), 6);
}

TEST(FtFrames, TheCapsNonsenseIsRefused) {
  for (const char* words :
       {"(1,2,3,4,5)", "(1,2,3,4,5,6,7)", "(nan,2,3,4,5,6)", "(1,2,3,4,5,inf)", "(1,2,3,4,5,1e30)", "()",
        "(,,,,,)", "(1 2 3 4 5 6)", "(a,b,c,d,e,f)", ")(", "((((", "(1,2,3,4,5,0x6)"}) {
    FtParser parser(FtParser::Format::kCap);
    parser.feed(text(words));
    EXPECT_TRUE(readings(parser).empty()) << words;
    parser.feed(text("(1,-2,300,0.01,-0.02,30)"));
    EXPECT_EQ(readings(parser).size(), 1U) << words;
  }
}

TEST(FtFrames, ALostEndDoesNotSwallowTheNextMessage) {
  FtParser parser(FtParser::Format::kCap);
  parser.feed(text("(1 , 2 , 3(1 , -2 , 300 , 0.01 , -0.02 , 30)"));
  EXPECT_EQ(readings(parser), std::vector<FtReading>{kReading});
}

TEST(FtFrames, TheEncoderClampsWhatDoesNotFit) {
  FtParser parser(FtParser::Format::kSerial);
  parser.feed(encode_ft_frame({1e9, -1e9, 0, 1e9, std::nan(""), 0}));
  const auto all = readings(parser);
  ASSERT_EQ(all.size(), 1U);
  EXPECT_DOUBLE_EQ(all[0][0], 327.67);
  EXPECT_DOUBLE_EQ(all[0][1], -327.68);
  EXPECT_DOUBLE_EQ(all[0][3], 32.767);
  EXPECT_DOUBLE_EQ(all[0][4], 0.0);
}

}  // namespace
}  // namespace stonestack::protocol
