// What stands beside recorded depth images, in BOP's, Open3D's and TUM's layout: refused with a FileError, or
// cameras and poses that make sense, and images within the folder.
#include <cmath>

#include "fuzz/checks.hpp"
#include "geometry/depth_sequence.hpp"
#include "rooms.hpp"
#include "stonestack/core/error.hpp"

namespace {

using namespace stonestack;
using namespace stonestack::report;

/// The three layouts, each with two images of 4 x 3 pixels.
struct Recordings {
  fuzz::Scratch scratch;
  Recordings() {
    DepthImage image;
    image.camera.width = 4;
    image.camera.height = 3;
    image.z.assign(12, 0.5F);
    for (const char* name : {"bop/depth/000000.png", "bop/depth/000001.png", "open3d/depth/0.png",
                             "open3d/depth/1.png", "tum/depth/0.png", "tum/depth/1.png"})
      write_depth_png(scratch.path(name), image, 0.001);
  }
};

void try_layout(const fuzz::Scratch& scratch, const std::string& folder, const DepthSequenceInput& input) {
  try {
    const DepthSequence sequence = read_depth_sequence(scratch.path(folder), input);
    fuzz::check(sequence.layout == folder && !sequence.records.empty());
    for (const auto& record : sequence.records) {
      fuzz::check(record.path.rfind(scratch.path(folder) + "/", 0) == 0);
      fuzz::check(record.unit > 0 && std::isfinite(record.unit) && std::isfinite(record.time));
      fuzz::check(record.camera.fx > 0 && record.camera.fy > 0 && record.camera.width == 4);
      fuzz::check(!record.T_W_C || is_valid(*record.T_W_C));
      (void)read_depth(record);
    }
  } catch (const FileError&) {
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Recordings recordings;
  const fuzz::Scratch& scratch = recordings.scratch;
  const std::string text = fuzz::text_of(data, size);
  scratch.write("bop/scene_camera.json", text);
  scratch.write("open3d/camera_intrinsic.json", text);
  scratch.write("tum/depth.txt", text);
  scratch.write("tum/groundtruth.txt", text);
  DepthSequenceInput given;
  given.unit = 0.001;
  given.camera = CameraIntrinsics{};
  given.camera->cx = given.camera->cy = 1.5;
  try_layout(scratch, "bop", {});
  try_layout(scratch, "open3d", {});
  try_layout(scratch, "tum", given);
  return 0;
}
