#include "protocol/z16.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "protocol/frame_stream.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::protocol {
namespace {

using Bytes = std::vector<std::uint8_t>;

CameraIntrinsics tiny(int width, int height) {
  CameraIntrinsics camera;
  camera.width = width;
  camera.height = height;
  return camera;
}

TEST(Z16, BytesSpelledByHand) {
  // Row 0: none, 1, 256; row 1: 5600 (0.7 m of an SR300), 65535, 0x1234.
  const Bytes raw{0x00, 0x00, 0x01, 0x00, 0x00, 0x01, 0xE0, 0x15, 0xFF, 0xFF, 0x34, 0x12};
  const DepthImage image = decode_z16(raw, 0, tiny(3, 2), 0.000125);
  EXPECT_EQ(image.at(0, 0), 0.0F);
  EXPECT_FLOAT_EQ(image.at(1, 0), 0.000125F);
  EXPECT_FLOAT_EQ(image.at(2, 0), 0.032F);
  EXPECT_FLOAT_EQ(image.at(0, 1), 0.7F);
  EXPECT_FLOAT_EQ(image.at(1, 1), 8.191875F);
  EXPECT_FLOAT_EQ(image.at(2, 1), 0.5825F);
  EXPECT_EQ(encode_z16(image, 0.000125), raw);
}

TEST(Z16, LinesMayBePadded) {
  const Bytes raw{0x01, 0x00, 0xAA, 0xAA, 0x02, 0x00};  // the last line may lack its padding
  const DepthImage image = decode_z16(raw, 4, tiny(1, 2), 1.0);
  EXPECT_EQ(image.at(0, 0), 1.0F);
  EXPECT_EQ(image.at(0, 1), 2.0F);
}

TEST(Z16, RefusesWhatDoesNotFit) {
  const Bytes raw(11);
  EXPECT_THROW((void)decode_z16(raw, 0, tiny(3, 2), 0.001), InvalidArgument) << "a byte is missing";
  EXPECT_THROW((void)decode_z16(raw, 4, tiny(3, 1), 0.001), InvalidArgument) << "lines too short";
  EXPECT_THROW((void)decode_z16(raw, 0, tiny(0, 2), 0.001), InvalidArgument);
  EXPECT_THROW((void)decode_z16(raw, 0, tiny(1, 1), 0.0), InvalidArgument);
  EXPECT_THROW((void)decode_z16(raw, 0, tiny(1, 1), -1.0), InvalidArgument);
}

TEST(Z16, ValuesBeyondTheCountsBecomeNoDepth) {
  const DepthImage image{tiny(4, 1), {-1.0F, 70.0F, std::numeric_limits<float>::quiet_NaN(), 1.0F}};
  EXPECT_EQ(encode_z16(image, 0.001), (Bytes{0, 0, 0, 0, 0, 0, 0xE8, 0x03}));
}

TEST(FrameStream, TheChecksumIsTheStandardOne) {
  const Bytes digits{'1', '2', '3', '4', '5', '6', '7', '8', '9'};
  EXPECT_EQ(crc32(digits), 0xCBF43926U);  // check value of CRC-32/ISO-HDLC
}

TEST(FrameStream, AHeaderSpelledByHand) {
  Bytes h(128, 0);
  const auto put = [&](std::size_t at, std::initializer_list<int> bytes) {
    for (const int byte : bytes) h[at++] = static_cast<std::uint8_t>(byte);
  };
  put(0, {'S', 'S', 'D', '1', 128, 0, 0, 0, 2, 0, 0, 0, 1});
  put(24, {0, 0, 0, 0, 0, 0, 0x59, 0x40});   // fx 100
  put(32, {0, 0, 0, 0, 0, 0, 0x59, 0x40});   // fy 100
  put(40, {0, 0, 0, 0, 0, 0, 0xE0, 0x3F});   // cx 0.5
  put(96, {0, 0, 0, 0, 0, 0, 0x50, 0x3F});   // 2^-10 m a count
  put(104, {0, 0, 0, 0, 0, 0, 0xF8, 0x3F});  // 1.5 s
  put(112, {7});
  put(120, {4});
  put(124, {0xFB, 0xDA, 0xCE, 0xAB});  // CRC-32 of 01 00 02 00 by Python's zlib
  std::string problem;
  const auto header = parse_frame_header(h, problem);
  ASSERT_TRUE(header) << problem;
  EXPECT_EQ(header->number, 7U);
  EXPECT_EQ(header->camera.fx, 100.0);
  EXPECT_EQ(header->device_time, 1.5);
  const auto frame = parse_frame(*header, Bytes{1, 0, 2, 0});
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->image.z, (std::vector<float>{1.0F / 1024, 2.0F / 1024}));
  h[8] = 3;
  EXPECT_FALSE(parse_frame_header(h, problem));
  EXPECT_EQ(problem, "4 bytes for 3 x 1 pixels");
}

TEST(FrameStream, GoesThereAndBackAndNoticesAnyFlippedBit) {
  DepthFrame frame{{tiny(4, 3), std::vector<float>(12, 0.5F)}, 42, 3.25};
  const Bytes bytes = encode_frame(frame, 0.001);
  std::string problem;
  for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
    Bytes bad = bytes;
    bad[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
    const auto header = parse_frame_header(bad, problem);
    if (bit / 8 >= kFrameHeader) {
      ASSERT_TRUE(header);
      EXPECT_FALSE(parse_frame(*header, std::span(bad).subspan(kFrameHeader))) << bit;
    }
  }
  const auto header = parse_frame_header(bytes, problem);
  ASSERT_TRUE(header);
  const auto again = parse_frame(*header, std::span(bytes).subspan(kFrameHeader));
  ASSERT_TRUE(again);
  EXPECT_EQ(again->image.z, frame.image.z);
  EXPECT_EQ(again->number, 42);
  for (std::size_t cut = 0; cut < kFrameHeader; ++cut)
    EXPECT_FALSE(parse_frame_header(std::span(bytes).first(cut), problem));
}

}  // namespace
}  // namespace stonestack::protocol
