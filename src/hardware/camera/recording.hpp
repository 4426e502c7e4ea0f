#pragma once
#include <optional>
#include <string>
#include <vector>

#include "geometry/depth_sequence.hpp"
#include "hardware/camera/recorded_camera.hpp"

/// Lists of frames on disk.
namespace stonestack::hardware {

struct RecordedFrame {
  double time = 0.0;  ///< [s]
  std::string path;
  std::size_t offset = 0;                 ///< bytes, of raw frames
  std::size_t bytes_per_line = 0;         ///< of raw frames; 0: no padding
  std::optional<DepthRecord> image = {};  ///< of BOP's layout: with a camera and a unit of its own
};

enum class RecordingFormat { kBop, kTum, kOpen3d, kClouds, kZ16, kV4l2 };
/// The format asked for, or the one that the path suggests. Throws FileError when it suggests none.
[[nodiscard]] RecordingFormat find_recording_format(const RecordedCameraOptions& options);
/// Camera settings: options, over them camera.yaml, over them the recording's own settings.
[[nodiscard]] CameraSettings read_camera_settings(RecordingFormat format,
                                                  const RecordedCameraOptions& options);
/// Parses "time file" lines; names are relative to `folder` and must stay in it. `path` is for errors.
[[nodiscard]] std::vector<RecordedFrame> parse_tum_list(const std::string& text, const std::string& folder,
                                                        const std::string& path);
/// All frames in order. Throws FileError when there is none.
[[nodiscard]] std::vector<RecordedFrame> list_frames(RecordingFormat format,
                                                     const RecordedCameraOptions& options,
                                                     const CameraIntrinsics& camera);

}  // namespace stonestack::hardware
