// Depth images: refused with a FileError, or as large as they say and the same when written and read again.
#include <cmath>

#include "fuzz/checks.hpp"
#include "rooms.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/geometry/depth_sequence.hpp"

namespace {

using namespace stonestack;
using namespace stonestack::report;

constexpr double kUnit = 0.000125;    // m a count
constexpr int kMaxPixels = 1 << 16;   // an input cannot fill more
constexpr float kFurthest = 8.1919F;  // m: 65535 counts

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const fuzz::Scratch scratch;
  const std::string path = scratch.write("depth.png", fuzz::text_of(data, size));
  try {
    const Eigen::Vector2i sides = png_size(path);
    if (sides.x() > kMaxPixels / sides.y()) return 0;
    CameraIntrinsics camera;
    camera.width = sides.x();
    camera.height = sides.y();
    const DepthImage image = read_depth_png(path, camera, kUnit);
    fuzz::check(image.z.size() == static_cast<std::size_t>(sides.x()) * static_cast<std::size_t>(sides.y()));
    for (const float z : image.z) fuzz::check(z >= 0 && z < kFurthest);
    write_depth_png(scratch.path("again.png"), image, kUnit);
    fuzz::check(read_depth_png(scratch.path("again.png"), camera, kUnit).z == image.z);
  } catch (const FileError&) {
  }
  return 0;
}
