#pragma once
#include <memory>
#include <string>

#include "hardware/camera/camera_settings.hpp"

namespace stonestack::hardware {

struct RecordedCameraOptions {
  std::string path;             ///< a folder, or one PCD or PLY cloud, or a file of raw Z16 frames
  std::string format = "auto";  ///< auto, bop, tum, open3d, clouds, z16 or v4l2
  CameraSettings camera;        ///< settings that the recording lacks
  double rate = 30.0;           ///< frames/s, of recordings without times
  bool loop = false;            ///< start again after the last frame; times and numbers go on
  FrameCheckOptions check;
};
[[nodiscard]] FieldList fields(RecordedCameraOptions& options);

/// Plays a recording, one frame a capture:
///   bop     folder with depth/NNNNNN.png and scene_camera.json, as `stonestack record` writes it
///   tum     folder with depth.txt ("time file" a line) and 16-bit PNGs
///   open3d  folder with depth/*.png and camera_intrinsic.json (width, height, intrinsic_matrix by columns)
///   clouds  folder of PCD and PLY files in the camera's frame and metres, or one such file
///   z16     raw frames of 16 bits little-endian, one behind the other
///   v4l2    what V4l2Camera has recorded, driver's padding and damaged frames included
/// A file camera.yaml in the folder may hold the fields of CameraSettings; the options fill what neither it
/// nor the recording states. A missing depth scale is an error, except for clouds.
class RecordedCamera final : public DepthCamera {
 public:
  /// Reads lists and calibration.
  /// @throws FileError (missing, empty, times that do not rise, files outside the folder), InvalidArgument
  /// (scale or focal lengths not given).
  explicit RecordedCamera(const RecordedCameraOptions& options);
  ~RecordedCamera() override;
  /// The next frame.
  /// @throws FileError for a broken one, DeviceError at the end of the recording.
  [[nodiscard]] DepthFrame capture() override;
  [[nodiscard]] std::size_t frames() const;
  [[nodiscard]] const CameraIntrinsics& intrinsics() const;

 private:
  struct Recording;
  std::unique_ptr<Recording> recording_;
};

}  // namespace stonestack::hardware
