#pragma once
#include <sys/types.h>

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/byte_stream.hpp"
#include "hardware/camera/v4l2_camera.hpp"
#include "hardware/camera/v4l2_recording.hpp"

namespace stonestack::hardware {

/// The kernel as the camera uses it, so that a test can stand in for it: this machine has no video device.
class V4l2Calls {
 public:
  virtual ~V4l2Calls() = default;
  /// 0, or -1 with errno set, as ioctl(2).
  virtual int control(unsigned long request, void* argument) = 0;
  /// A buffer of the driver, or nullptr with errno set.
  virtual void* map(std::size_t length, off_t offset) = 0;
  virtual void unmap(void* address, std::size_t length) = 0;
  /// True when a frame can be fetched before the deadline.
  virtual bool wait(Deadline deadline) = 0;
  /// Seconds of the clock of the time stamps.
  virtual double now() = 0;
};
/// Opens the node. Throws DeviceError.
[[nodiscard]] std::unique_ptr<V4l2Calls> open_v4l2(const std::string& device);

/// The camera on any kernel; V4l2Camera is this on the real one.
class V4l2Stream {
 public:
  V4l2Stream(std::unique_ptr<V4l2Calls> calls, const V4l2CameraOptions& options);
  ~V4l2Stream();
  V4l2Stream(const V4l2Stream&) = delete;
  V4l2Stream& operator=(const V4l2Stream&) = delete;
  [[nodiscard]] DepthFrame capture();

 private:
  struct Buffer {
    void* start = nullptr;
    std::size_t length = 0;
  };
  void open();
  void release() noexcept;
  void set_format();
  void map_buffers();
  void queue(unsigned index);
  void check_time(double time) const;
  [[noreturn]] void fail(const std::string& problem, const std::string& remedy) const;

  std::unique_ptr<V4l2Calls> calls_;
  V4l2CameraOptions options_;
  CameraIntrinsics camera_;
  double unit_;
  FrameCheck check_;
  std::size_t bytes_per_line_ = 0;
  std::vector<Buffer> buffers_;
  std::optional<V4l2Recorder> recorder_;
};

}  // namespace stonestack::hardware
