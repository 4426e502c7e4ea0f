#include "hardware/camera/camera_settings.hpp"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "geometry/bop_folder.hpp"
#include "geometry/camera_check.hpp"
#include "hardware/constants.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::hardware {

FieldList fields(CameraSettings& o) {
  const FieldRange pixels{1, 16384}, length{0.0, 1e5}, centre{-1e5, 1e5}, lens{-100.0, 100.0};
  return user(FieldList{
      field("depth_scale", o.depth_scale, {0.0, 1e6}, "1/m",
            "counts a metre: TUM 5000, Open3D and D4xx 1000, SR300 8000"),
      field("width", o.width, pixels, "", "of the image in pixels"),
      field("height", o.height, pixels, "", "of the image in pixels"),
      field("fx", o.fx, length, "pixel", "focal length"),
      field("fy", o.fy, length, "pixel", "focal length"),
      field("cx", o.cx, centre, "pixel", "optical centre"),
      field("cy", o.cy, centre, "pixel", "optical centre"),
      field("distortion", o.distortion, "of the lens: none, brown_conrady or inverse_brown_conrady"),
      field("k1", o.k1, lens, "", "radial distortion"),
      field("k2", o.k2, lens, "", "radial distortion"),
      field("p1", o.p1, lens, "", "tangential distortion"),
      field("p2", o.p2, lens, "", "tangential distortion"),
      field("k3", o.k3, lens, "", "radial distortion"),
  });
}

FieldList fields(FrameCheckOptions& o) {
  return {field("refuse_equal_image", o.refuse_equal_image,
                "true: an image equal to the last is an error; false for a simulated camera without noise")};
}

CameraIntrinsics to_intrinsics(const CameraSettings& s) {
  require(s.fx > 0 && s.fy > 0, "the camera's focal lengths are not given (fx ", s.fx, ", fy ", s.fy,
          "); V4L2 and PNG do not carry them, take them from the calibration");
  CameraIntrinsics camera;
  camera.width = s.width;
  camera.height = s.height;
  camera.fx = s.fx;
  camera.fy = s.fy;
  camera.cx = s.cx;
  camera.cy = s.cy;
  using Distortion = CameraIntrinsics::Distortion;
  require(
      s.distortion == "none" || s.distortion == "brown_conrady" || s.distortion == "inverse_brown_conrady",
      "distortion is none, brown_conrady or inverse_brown_conrady, not '", s.distortion, "'");
  if (s.distortion == "brown_conrady") camera.distortion = Distortion::kBrownConrady;
  if (s.distortion == "inverse_brown_conrady") camera.distortion = Distortion::kInverseBrownConrady;
  const double k[5] = {s.k1, s.k2, s.p1, s.p2, s.k3};
  std::copy(std::begin(k), std::end(k), std::begin(camera.k));
  require_usable(camera);
  return camera;
}

void set_intrinsics(CameraSettings& s, const CameraIntrinsics& camera) {
  s.width = camera.width;
  s.height = camera.height;
  s.fx = camera.fx;
  s.fy = camera.fy;
  s.cx = camera.cx;
  s.cy = camera.cy;
  s.distortion = distortion_name(camera.distortion);
  s.k1 = camera.k[0], s.k2 = camera.k[1], s.p1 = camera.k[2], s.p2 = camera.k[3], s.k3 = camera.k[4];
}

double depth_unit(const CameraSettings& settings) {
  require(
      std::isfinite(settings.depth_scale) && settings.depth_scale > 0,
      "depth_scale is not given and never guessed; counts a metre: 5000 for TUM recordings, 1000 for Open3D "
      "and D4xx, 8000 for an SR300");
  return 1.0 / settings.depth_scale;
}

DepthFrame FrameCheck::pass(DepthFrame frame) {
  const auto fail = [this](const std::string& problem, const std::string& remedy) {
    throw DeviceError(device_, problem, remedy);
  };
  if (!std::isfinite(frame.device_time)) fail("frame without a finite time", "start the camera again");
  const std::string_view bytes(reinterpret_cast<const char*>(frame.image.z.data()),
                               frame.image.z.size() * sizeof(float));
  const std::size_t image = std::hash<std::string_view>()(bytes);
  const bool is_repeated = frame.number == number_ && frame.device_time == time_ && image == image_;
  const bool begins_anew =
      restarted_ && frame.number <= number_ && frame.device_time <= time_ && !is_repeated;
  if (!begins_anew && !first_ && (frame.number <= number_ || frame.device_time <= time_))
    fail(concat("frame ", frame.number, " at ", frame.device_time, " s after frame ", number_, " at ", time_,
                " s: the stream is stale"),
         "start the camera again");
  std::vector<float> depths;
  for (const float z : frame.image.z)
    if (z > 0 && std::isfinite(z)) depths.push_back(z);
  const auto pixels = static_cast<double>(std::max<std::size_t>(1, frame.image.z.size()));
  const double share = static_cast<double>(depths.size()) / pixels;
  if (depths.empty() || share < kMinValid)
    fail(concat("only ", 100.0 * share, " % of the pixels have a depth (least ", 100.0 * kMinValid, " %)"),
         "see what covers the camera or dazzles it");
  const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  const double median = static_cast<double>(*middle);
  if (median < kNearestMedian || median > kFarthestMedian)
    fail(concat("median depth ", median, " m is outside ", kNearestMedian, " to ", kFarthestMedian, " m"),
         "check depth_scale");
  if (options_.refuse_equal_image && !first_ && image == image_)
    fail(concat("frame ", frame.number, " equals the one before, pixel by pixel: the image is frozen"),
         "start the camera again");
  first_ = restarted_ = false;
  number_ = frame.number;
  time_ = frame.device_time;
  image_ = image;
  frame.host_time = host_seconds();
  return frame;
}

}  // namespace stonestack::hardware
