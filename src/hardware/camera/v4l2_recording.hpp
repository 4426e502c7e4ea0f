#pragma once
#include <cstdint>
#include <fstream>
#include <span>
#include <string>
#include <vector>

#include "hardware/camera/recording.hpp"

/// Raw buffers of a driver. A folder with
///   v4l2.raw     the bytes of all buffers, one behind the other, padding and all
///   v4l2.txt     "stonestack v4l2 1", "Z16 WIDTH HEIGHT BYTES_PER_LINE", then a line a buffer:
///                "SEQUENCE SECONDS MICROSECONDS ERROR BYTES", damaged and short ones, too
///   camera.yaml  settings that V4L2 lacks: scale and intrinsics
/// It plays through the same decoder as the device (RecordedCamera, format v4l2).
namespace stonestack::hardware {

struct V4l2Format {
  int width = 0, height = 0;
  std::size_t bytes_per_line = 0;
};

/// A buffer that the driver gave back.
struct V4l2Note {
  std::uint32_t sequence = 0;
  long long seconds = 0, microseconds = 0;
  bool error = false;
  std::size_t bytes = 0;
  [[nodiscard]] double time() const {
    return static_cast<double>(seconds) + 1e-6 * static_cast<double>(microseconds);
  }
};

class V4l2Recorder {
 public:
  /// Makes the folder. Throws FileError when it holds a recording already.
  V4l2Recorder(const std::string& folder, CameraSettings camera, const V4l2Format& format);
  void add(const V4l2Note& note, std::span<const std::uint8_t> bytes);

 private:
  std::string folder_;
  std::ofstream raw_, list_;
};

/// The whole, undamaged frames of a recording, as V4l2Camera would take them; `folder` is for paths and
/// errors. Throws FileError for a list that does not fit the camera, the bytes or itself.
[[nodiscard]] std::vector<RecordedFrame> parse_v4l2_list(const std::string& text, const std::string& folder,
                                                         const CameraIntrinsics& camera,
                                                         std::size_t raw_bytes);

}  // namespace stonestack::hardware
