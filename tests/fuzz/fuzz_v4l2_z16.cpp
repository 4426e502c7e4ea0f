// Raw Z16 of any size, padding and camera: refused or decoded, never read beyond the bytes. The list of a TUM
// recording goes the same way, and so does that of a V4L2 recording.
#include <cmath>
#include <cstdlib>

#include "hardware/camera/v4l2_recording.hpp"
#include "protocol/z16.hpp"
#include "rooms.hpp"
#include "stonestack/core/error.hpp"

namespace {

using namespace stonestack;
using namespace stonestack::report;

void check(bool held) {
  if (!held) std::abort();
}

void try_list(const std::string& text) {
  try {
    double last = -INFINITY;
    for (const auto& frame : parse_tum_list(text, "/recording", "depth.txt")) {
      check(std::isfinite(frame.time) && frame.time > last);
      check(frame.path.rfind("/recording/", 0) == 0 && frame.path.find("/../") == std::string::npos);
      last = frame.time;
    }
  } catch (const FileError&) {
  }
}

void try_v4l2_list(const std::string& text) {
  CameraIntrinsics camera;
  camera.width = camera.height = 2;
  try {
    constexpr std::size_t kRaw = 100;
    for (const auto& frame : parse_v4l2_list(text, "/recording", camera, kRaw))
      check(std::isfinite(frame.time) && frame.offset + z16_bytes(camera, frame.bytes_per_line) <= kRaw);
  } catch (const FileError&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  try_list(text);
  try_v4l2_list(text);
  if (size < 4) return 0;
  CameraIntrinsics camera;
  camera.width = data[0];
  camera.height = data[1];
  const std::span<const std::uint8_t> pixels(data + 4, size - 4);
  const std::size_t line = data[2] + 256U * (data[3] & 3U);
  try {
    const DepthImage image = decode_z16(pixels, line, camera, 0.000125);
    check(image.z.size() == static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height));
    for (const float z : image.z) check(z >= 0 && z < 8.2F);
    const auto again = encode_z16(image, 0.000125);
    check(again[0] == pixels[0] && again[1] == pixels[1]);
  } catch (const InvalidArgument&) {
  }
  return 0;
}
