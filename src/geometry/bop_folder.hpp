#pragma once
#include <optional>
#include <string>
#include <vector>

#include "geometry/depth_sequence.hpp"

namespace stonestack::geometry {

/// Folder of depth images in BOP's layout that grows image by image. It can be read after each of them,
/// however the program ends: a picture is there before scene_camera.json names it, and each file is replaced
/// as a whole. Beside BOP's keys an image has `time`, and `distortion` and `k` where its lens has one.
class BopFolder {
 public:
  /// Writes nothing yet; what `path` holds stays.
  explicit BopFolder(std::string path) : path_(std::move(path)) {}
  /// Writes depth/NNNNNN.png and names it in scene_camera.json. Its unit is the camera's, where the depths
  /// show it; else the finest that reaches the farthest depth.
  /// @param time of the image [s]
  /// @return what `read_depth_sequence` reads of it
  /// @throws FileError, InvalidArgument for an image that is none
  const DepthRecord& add(const DepthImage& image, double time, const std::optional<Pose>& T_W_C);
  /// Images so far.
  [[nodiscard]] const std::vector<DepthRecord>& records() const { return records_; }

 private:
  std::string path_;
  std::vector<DepthRecord> records_;
};

/// Path of the depth image `number` in a folder of BOP's layout.
[[nodiscard]] std::string bop_depth_path(const std::string& folder, int number);
/// Name of a lens distortion in files: none, brown_conrady or inverse_brown_conrady.
[[nodiscard]] std::string distortion_name(CameraIntrinsics::Distortion distortion);

}  // namespace stonestack::geometry
