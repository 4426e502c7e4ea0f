#pragma once
#include <cstdint>
#include <span>
#include <vector>

#include "stonestack/geometry/depth_image.hpp"

namespace stonestack::protocol {

/// Z16: 16 bits little-endian a pixel, row by row, `bytes_per_line` from row to row (0: no padding); 0 is no
/// depth. `unit` in metres a count. Throws InvalidArgument when `bytes` are too few for the camera's size,
/// the lines too short or the unit not positive.
[[nodiscard]] DepthImage decode_z16(std::span<const std::uint8_t> bytes, std::size_t bytes_per_line,
                                    const CameraIntrinsics& camera, double unit);
/// The bytes that a frame must have, of whose last line the padding may be missing; 0: the lines are too
/// short.
[[nodiscard]] std::size_t z16_bytes(const CameraIntrinsics& camera, std::size_t bytes_per_line);
/// The reverse, without padding. What does not fit becomes 0.
[[nodiscard]] std::vector<std::uint8_t> encode_z16(const DepthImage& image, double unit);

}  // namespace stonestack::protocol
