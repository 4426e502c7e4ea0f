#include "protocol/frame_stream.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "geometry/byte_order.hpp"
#include "protocol/z16.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::protocol {
namespace {

constexpr std::string_view kMagic = "SSD1";
constexpr double kLongestFocal = 1e6;  // pixels

std::array<std::uint32_t, 256> make_table() {
  std::array<std::uint32_t, 256> table{};
  for (std::uint32_t i = 0; i < 256; ++i) {
    table[i] = i;
    for (int bit = 0; bit < 8; ++bit) table[i] = (table[i] >> 1U) ^ ((table[i] & 1U) != 0 ? 0xEDB88320U : 0U);
  }
  return table;
}

bool is_plausible(const FrameHeader& header) {
  const CameraIntrinsics& c = header.camera;
  const auto focal = [](double f) { return std::isfinite(f) && f > 0 && f < kLongestFocal; };
  const bool lens = std::all_of(std::begin(c.k), std::end(c.k), [](double k) { return std::isfinite(k); });
  return focal(c.fx) && focal(c.fy) && std::isfinite(c.cx) && std::isfinite(c.cy) && lens &&
         std::isfinite(header.unit) && header.unit > 0 && header.unit < 1.0 &&
         std::isfinite(header.device_time) &&
         header.number <= static_cast<std::uint64_t>(std::numeric_limits<long>::max());
}

}  // namespace

std::uint32_t crc32(std::span<const std::uint8_t> bytes) {
  static const auto table = make_table();
  std::uint32_t crc = 0xFFFFFFFFU;
  for (const auto byte : bytes) crc = table[(crc ^ byte) & 0xFFU] ^ (crc >> 8U);
  return ~crc;
}

std::optional<FrameHeader> parse_frame_header(std::span<const std::uint8_t> bytes, std::string& problem) {
  const auto refuse = [&](std::string text) {
    problem = std::move(text);
    return std::nullopt;
  };
  if (bytes.size() < kFrameHeader) return refuse(concat("a header of ", bytes.size(), " bytes"));
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), kFrameHeader);
  const auto u32 = [&](std::size_t at) { return decoded<std::uint32_t>(text.substr(at, 4)); };
  const auto f64 = [&](std::size_t at) { return decoded<double>(text.substr(at, 8)); };
  if (text.substr(0, 4) != kMagic || u32(4) != kFrameHeader) return refuse("no frame of this protocol");
  const std::uint64_t width = u32(8), height = u32(12);
  if (width < 1 || height < 1 || width > 16384 || height > 16384 || width * height > kMaxFramePixels)
    return refuse(concat("a frame of ", width, " x ", height, " pixels"));
  if (u32(16) > 2) return refuse(concat("distortion ", u32(16)));
  FrameHeader header;
  header.camera.width = static_cast<int>(width);
  header.camera.height = static_cast<int>(height);
  header.camera.distortion = static_cast<CameraIntrinsics::Distortion>(u32(16));
  header.camera.fx = f64(24);
  header.camera.fy = f64(32);
  header.camera.cx = f64(40);
  header.camera.cy = f64(48);
  for (std::size_t i = 0; i < 5; ++i) header.camera.k[i] = f64(56 + 8 * i);
  header.unit = f64(96);
  header.device_time = f64(104);
  header.number = decoded<std::uint64_t>(text.substr(112, 8));
  header.pixel_bytes = u32(120);
  header.crc = u32(124);
  if (header.pixel_bytes != 2 * width * height)
    return refuse(concat(header.pixel_bytes, " bytes for ", width, " x ", height, " pixels"));
  if (!is_plausible(header)) return refuse("a header with values out of range");
  return header;
}

std::optional<DepthFrame> parse_frame(const FrameHeader& header, std::span<const std::uint8_t> pixels) {
  if (pixels.size() != header.pixel_bytes || crc32(pixels) != header.crc) return std::nullopt;
  DepthFrame frame;
  frame.image = decode_z16(pixels, 0, header.camera, header.unit);
  frame.number = static_cast<long>(header.number);
  frame.device_time = header.device_time;
  return frame;
}

std::vector<std::uint8_t> encode_frame(const DepthFrame& frame, double unit) {
  const CameraIntrinsics& camera = frame.image.camera;
  const auto pixels = encode_z16(frame.image, unit);
  std::string header(kMagic);
  const auto u32 = [&](std::uint32_t value) { append_little(header, value); };
  u32(kFrameHeader);
  u32(static_cast<std::uint32_t>(camera.width));
  u32(static_cast<std::uint32_t>(camera.height));
  u32(static_cast<std::uint32_t>(camera.distortion));
  u32(0);
  for (const double value : {camera.fx, camera.fy, camera.cx, camera.cy}) append_little(header, value);
  for (const double value : camera.k) append_little(header, value);
  append_little(header, unit);
  append_little(header, frame.device_time);
  append_little(header, static_cast<std::uint64_t>(frame.number));
  u32(static_cast<std::uint32_t>(pixels.size()));
  u32(crc32(pixels));
  std::vector<std::uint8_t> bytes(header.begin(), header.end());
  bytes.insert(bytes.end(), pixels.begin(), pixels.end());
  return bytes;
}

}  // namespace stonestack::protocol
