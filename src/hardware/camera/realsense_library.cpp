// The one file that needs librealsense 2 (-DSTONESTACK_REALSENSE=ON).
#include <algorithm>
#include <chrono>
#include <librealsense2/rs.hpp>
#include <thread>

#include "core/byte_stream.hpp"
#include "hardware/camera/realsense_device.hpp"
#include "protocol/z16.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::hardware {
namespace {

constexpr unsigned kTurn = 50;  // ms between checks of the deadline and of Ctrl-C

CameraIntrinsics to_camera(const rs2_intrinsics& from, const std::string& name) {
  CameraIntrinsics camera;
  camera.width = from.width;
  camera.height = from.height;
  camera.fx = static_cast<double>(from.fx);
  camera.fy = static_cast<double>(from.fy);
  camera.cx = static_cast<double>(from.ppx);
  camera.cy = static_cast<double>(from.ppy);
  std::copy(std::begin(from.coeffs), std::end(from.coeffs), std::begin(camera.k));
  using Distortion = CameraIntrinsics::Distortion;
  const bool straight =
      std::all_of(std::begin(from.coeffs), std::end(from.coeffs), [](float k) { return k == 0.0F; });
  if (straight || from.model == RS2_DISTORTION_NONE) {
    camera.distortion = Distortion::kNone;
  } else if (from.model == RS2_DISTORTION_BROWN_CONRADY) {
    camera.distortion = Distortion::kBrownConrady;
  } else if (from.model == RS2_DISTORTION_INVERSE_BROWN_CONRADY) {
    camera.distortion = Distortion::kInverseBrownConrady;
  } else {
    throw DeviceError(name, concat("has a lens model that is not known here, number ", from.model),
                      "use camera.driver: v4l2 with a calibration of your own");
  }
  return camera;
}

class Realsense final : public DepthCamera {
 public:
  explicit Realsense(const RealsenseCameraOptions& options)
      : options_(options),
        name_("RealSense camera " + (options.serial.empty() ? std::string("(any)") : options.serial)),
        check_(name_, options.check) {
    try {
      start();
    } catch (const rs2::error& error) {
      fail(std::string("does not start: ") + error.what(),
           "plug it in, into a USB 3 port; see `rs-enumerate-devices` for its serial number and formats");
    }
  }
  ~Realsense() override {
    try {
      pipeline_.stop();
    } catch (const rs2::error&) {  // it was unplugged
    }
  }
  Realsense(const Realsense&) = delete;
  Realsense& operator=(const Realsense&) = delete;

  [[nodiscard]] DepthFrame capture() override {
    try {
      // What waits already was exposed before the call, and so may have been the next one to come.
      rs2::frameset frames;
      while (pipeline_.poll_for_frames(&frames)) continue;
      wait_for(frames);
      wait_for(frames);
      return check_.pass(to_frame(frames.get_depth_frame()));
    } catch (const rs2::error& error) {
      fail(std::string("was lost: ") + error.what(), "plug the camera in again");
    }
  }

 private:
  [[noreturn]] void fail(const std::string& problem, const std::string& remedy) const {
    throw DeviceError(name_, problem, remedy);
  }

  void start() {
    rs2::config config;
    if (!options_.serial.empty()) config.enable_device(options_.serial);
    config.enable_stream(RS2_STREAM_DEPTH, options_.width, options_.height, RS2_FORMAT_Z16, options_.rate);
    const rs2::pipeline_profile profile = pipeline_.start(config);
    camera_ = to_camera(profile.get_stream(RS2_STREAM_DEPTH).as<rs2::video_stream_profile>().get_intrinsics(),
                        name_);
    unit_ = static_cast<double>(profile.get_device().first<rs2::depth_sensor>().get_depth_scale());
  }

  void wait_for(rs2::frameset& frames) const {
    for (const Deadline deadline = Deadline::in(options_.frame_timeout);;) {
      throw_if_interrupted();
      if (pipeline_.try_wait_for_frames(&frames, kTurn)) return;
      if (deadline.over())
        fail(concat("no frame within ", options_.frame_timeout, " s"),
             "plug the camera in again, into a USB 3 port");
    }
  }

  [[nodiscard]] DepthFrame to_frame(const rs2::depth_frame& depth) const {
    if (!depth) fail("sent no depth", "plug the camera in again");
    if (depth.get_width() != camera_.width || depth.get_height() != camera_.height)
      fail(concat("sent ", depth.get_width(), " x ", depth.get_height(), " pixels, not ", camera_.width,
                  " x ", camera_.height),
           "plug the camera in again");
    const auto line = static_cast<std::size_t>(depth.get_stride_in_bytes());
    DepthFrame frame;
    frame.image = decode_z16(
        {static_cast<const std::uint8_t*>(depth.get_data()), line * static_cast<std::size_t>(camera_.height)},
        line, camera_, unit_);
    frame.number = static_cast<long>(depth.get_frame_number());
    frame.device_time = 1e-3 * depth.get_timestamp();
    return frame;
  }

  RealsenseCameraOptions options_;
  std::string name_;
  FrameCheck check_;
  rs2::pipeline pipeline_;
  CameraIntrinsics camera_;
  double unit_ = 0.0;
};

}  // namespace

std::unique_ptr<DepthCamera> open_realsense(const RealsenseCameraOptions& options) {
  return std::make_unique<Realsense>(options);
}

}  // namespace stonestack::hardware
