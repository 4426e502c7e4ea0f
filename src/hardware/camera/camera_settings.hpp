#pragma once
#include <string>

#include "stonestack/core/options.hpp"
#include "stonestack/geometry/depth_image.hpp"
#include "stonestack/hardware/devices.hpp"

namespace stonestack::hardware {

/// Meaning of a depth image's numbers, which neither V4L2 nor a PNG contains. The scale is never guessed:
/// 5000 in place of 1000 is an error by five that looks like a picture.
struct CameraSettings {
  double depth_scale =
      0.0;  ///< depth counts per metre: TUM 5000, Open3D and D4xx 1000, SR300 8000; 0: not given
  int width = 640;
  int height = 480;
  double fx = 0.0;  ///< pixels; 0: not given
  double fy = 0.0;
  double cx = 0.0;
  double cy = 0.0;
  std::string distortion = "none";  ///< none, brown_conrady or inverse_brown_conrady
  double k1 = 0.0, k2 = 0.0, p1 = 0.0, p2 = 0.0, k3 = 0.0;
};
[[nodiscard]] FieldList fields(CameraSettings& settings);
/// Throws InvalidArgument when focal lengths, size or the name of the distortion are missing or wrong.
[[nodiscard]] CameraIntrinsics to_intrinsics(const CameraSettings& settings);
/// Sets size, focal lengths, principal point and distortion: the inverse of `to_intrinsics`.
void set_intrinsics(CameraSettings& settings, const CameraIntrinsics& camera);
/// Metres a count.
/// @throws InvalidArgument with the usual values, when the scale was not given.
[[nodiscard]] double depth_unit(const CameraSettings& settings);

/// Conditions that a frame must meet.
struct FrameCheckOptions {
  bool refuse_equal_image = true;  ///< a camera with noise never sends the same image twice
};
[[nodiscard]] FieldList fields(FrameCheckOptions& options);

/// Compares each frame with the one before. Throws DeviceError for a number or time that does not rise, an
/// image equal to the last, too few depths, and depths out of range.
class FrameCheck {
 public:
  FrameCheck(std::string device, const FrameCheckOptions& options)
      : device_(std::move(device)), options_(options) {}
  /// The frame itself, if it is good.
  [[nodiscard]] DepthFrame pass(DepthFrame frame);
  /// On a new connection: the next frame may begin anew with number and time, once, as those of a device that
  /// was started again do. Its image must still be another one.
  void restarted() { restarted_ = true; }

 private:
  std::string device_;
  FrameCheckOptions options_;
  bool first_ = true, restarted_ = false;
  long number_ = 0;
  double time_ = 0.0;
  std::size_t image_ = 0;  // hash
};

}  // namespace stonestack::hardware
