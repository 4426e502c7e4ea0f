#include "protocol/z16.hpp"

#include <cmath>

#include "geometry/camera_check.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::protocol {
namespace {
constexpr double kMaxCounts = 65535.0;
}

std::size_t z16_bytes(const CameraIntrinsics& camera, std::size_t bytes_per_line) {
  const auto width = static_cast<std::size_t>(camera.width), height = static_cast<std::size_t>(camera.height);
  const std::size_t line = bytes_per_line == 0 ? 2 * width : bytes_per_line;
  return line < 2 * width ? 0 : (height - 1) * line + 2 * width;
}

DepthImage decode_z16(std::span<const std::uint8_t> bytes, std::size_t bytes_per_line,
                      const CameraIntrinsics& camera, double unit) {
  require(std::isfinite(unit) && unit > 0, "the depth unit must be positive, got ", unit, " m");
  DepthImage image = make_empty_image(camera);
  const auto width = static_cast<std::size_t>(camera.width), height = static_cast<std::size_t>(camera.height);
  const std::size_t line = bytes_per_line == 0 ? 2 * width : bytes_per_line;
  const std::size_t needed = z16_bytes(camera, bytes_per_line);
  require(needed > 0, "lines of ", line, " bytes are too short for ", width, " pixels of Z16");
  require(bytes.size() >= needed, "a Z16 frame of ", width, " x ", height, " needs ", needed, " bytes, got ",
          bytes.size());
  for (std::size_t v = 0; v < height; ++v)
    for (std::size_t u = 0; u < width; ++u) {
      const std::size_t at = v * line + 2 * u;
      image.z[v * width + u] = static_cast<float>(unit * (bytes[at] + 256.0 * bytes[at + 1]));
    }
  return image;
}

std::vector<std::uint8_t> encode_z16(const DepthImage& image, double unit) {
  require(std::isfinite(unit) && unit > 0, "the depth unit must be positive, got ", unit, " m");
  std::vector<std::uint8_t> bytes;
  bytes.reserve(2 * image.z.size());
  for (const float z : image.z) {
    const double rounded = std::round(static_cast<double>(z) / unit);
    const auto count = static_cast<unsigned>(rounded >= 0.0 && rounded <= kMaxCounts ? rounded : 0.0);
    bytes.push_back(static_cast<std::uint8_t>(count & 0xFFU));
    bytes.push_back(static_cast<std::uint8_t>(count >> 8U));
  }
  return bytes;
}

}  // namespace stonestack::protocol
