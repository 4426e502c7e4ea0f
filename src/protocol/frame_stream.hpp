#pragma once
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "stonestack/geometry/depth_image.hpp"

/// Depth frames over TCP. A client sends a line, "capture\n" for one frame exposed after it or "stream\n" for
/// frames without end; the server answers with frames. A frame is a header of 128 bytes and Z16 pixels, all
/// little-endian:
///
///   0   "SSD1"              4   u32 header size 128
///   8   u32 width           12  u32 height
///   16  u32 distortion (0 none, 1 Brown-Conrady, 2 inverse Brown-Conrady)
///   20  u32 0
///   24  f64 fx fy cx cy     56  f64 k1 k2 p1 p2 k3
///   96  f64 metres a count  104 f64 device time, s
///   112 u64 frame number    120 u32 pixel bytes = 2 x width x height
///   124 u32 CRC-32 (IEEE 802.3) of the pixel bytes
namespace stonestack::protocol {

inline constexpr std::size_t kFrameHeader = 128;
inline constexpr std::size_t kMaxFramePixels = 4096U * 4096U;

struct FrameHeader {
  CameraIntrinsics camera;
  double unit = 0.0;  ///< metres per count
  double device_time = 0.0;
  std::uint64_t number = 0;
  std::uint32_t pixel_bytes = 0;
  std::uint32_t crc = 0;
};
/// The header, or what is wrong with it in `problem`. Any bytes.
[[nodiscard]] std::optional<FrameHeader> parse_frame_header(std::span<const std::uint8_t> bytes,
                                                            std::string& problem);
/// The frame, or empty when the pixels are not those of the header.
[[nodiscard]] std::optional<DepthFrame> parse_frame(const FrameHeader& header,
                                                    std::span<const std::uint8_t> pixels);
[[nodiscard]] std::vector<std::uint8_t> encode_frame(const DepthFrame& frame, double unit);
[[nodiscard]] std::uint32_t crc32(std::span<const std::uint8_t> bytes);

}  // namespace stonestack::protocol
