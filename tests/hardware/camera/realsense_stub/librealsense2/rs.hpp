#pragma once
// The part of librealsense 2's C++ interface that the backend uses, declared as its documentation and headers
// (2.50) have it, over a camera that a test scripts. Debian 12 has no package of the library itself.
#include <cstdint>
#include <deque>
#include <stdexcept>
#include <string>
#include <vector>

enum rs2_stream { RS2_STREAM_ANY, RS2_STREAM_DEPTH };
enum rs2_format { RS2_FORMAT_ANY, RS2_FORMAT_Z16 };
enum rs2_distortion {
  RS2_DISTORTION_NONE,
  RS2_DISTORTION_MODIFIED_BROWN_CONRADY,
  RS2_DISTORTION_INVERSE_BROWN_CONRADY,
  RS2_DISTORTION_FTHETA,
  RS2_DISTORTION_BROWN_CONRADY,
  RS2_DISTORTION_KANNALA_BRANDT4
};
struct rs2_intrinsics {
  int width, height;
  float ppx, ppy, fx, fy;
  rs2_distortion model;
  float coeffs[5];
};

namespace rs2 {

/// State and frames of the scripted camera.
struct StubFrame {
  std::vector<std::uint16_t> counts;
  int width = 0, height = 0, stride = 0;
  unsigned long long number = 0;
  double milliseconds = 0.0;
};
struct Stub {
  std::string serial = "912112";
  rs2_intrinsics intrinsics{2, 2, 0.5F, 0.5F, 400.0F, 401.0F, RS2_DISTORTION_NONE, {}};
  float depth_scale = 0.001F;
  std::deque<StubFrame> waiting, to_come;
  bool unplugged = false, started = false;
};
inline Stub& stub() {
  static Stub camera;
  return camera;
}

class error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

class depth_frame {
 public:
  depth_frame() = default;
  explicit depth_frame(StubFrame frame) : frame_(std::move(frame)) {}
  operator bool() const { return frame_.width > 0; }
  const void* get_data() const { return frame_.counts.data(); }
  int get_width() const { return frame_.width; }
  int get_height() const { return frame_.height; }
  int get_stride_in_bytes() const { return frame_.stride; }
  unsigned long long get_frame_number() const { return frame_.number; }
  double get_timestamp() const { return frame_.milliseconds; }

 private:
  StubFrame frame_;
};

class frameset {
 public:
  depth_frame get_depth_frame() const { return depth; }
  depth_frame depth;
};

class video_stream_profile {
 public:
  rs2_intrinsics get_intrinsics() const { return stub().intrinsics; }
};
class stream_profile {
 public:
  template <class T>
  T as() const {
    return {};
  }
};
class depth_sensor {
 public:
  float get_depth_scale() const { return stub().depth_scale; }
};
class device {
 public:
  template <class T>
  T first() const {
    return {};
  }
};
class pipeline_profile {
 public:
  stream_profile get_stream(rs2_stream, int = -1) const { return {}; }
  device get_device() const { return {}; }
};

class config {
 public:
  void enable_device(const std::string& serial) { serial_ = serial; }
  void enable_stream(rs2_stream, int width, int height, rs2_format, int) {
    width_ = width;
    height_ = height;
  }
  std::string serial_;
  int width_ = 0, height_ = 0;
};

class pipeline {
 public:
  pipeline_profile start(const config& wanted) {
    const Stub& camera = stub();
    if (camera.unplugged || (!wanted.serial_.empty() && wanted.serial_ != camera.serial))
      throw error("No device connected");
    if (wanted.width_ != camera.intrinsics.width || wanted.height_ != camera.intrinsics.height)
      throw error("Couldn't resolve requests");
    stub().started = true;
    return {};
  }
  void stop() { stub().started = false; }
  bool poll_for_frames(frameset* frames) const { return take(stub().waiting, frames); }
  bool try_wait_for_frames(frameset* frames, unsigned int = 5000) const {
    return take(stub().to_come, frames);
  }

 private:
  static bool take(std::deque<StubFrame>& from, frameset* frames) {
    if (stub().unplugged) throw error("Device disconnected");
    if (from.empty()) return false;
    frames->depth = depth_frame(from.front());
    from.pop_front();
    return true;
  }
};

}  // namespace rs2
