#include "hardware/camera/recorded_camera.hpp"

#include <fstream>

#include "hardware/camera/recording.hpp"
#include "protocol/z16.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/geometry/cloud.hpp"

namespace stonestack::hardware {

FieldList fields(RecordedCameraOptions& o) {
  FieldList own = {
      user(field("path", o.path, "of the recording: a folder, a cloud, or a file of raw frames")),
      user(field("format", o.format, "auto, bop, tum, open3d, clouds, z16 or v4l2")),
      field("rate", o.rate, {0.01, 1000.0}, "1/s", "of recordings without times"),
      field("loop", o.loop, "true: after the last frame comes the first"),
  };
  return join({own, fields(o.camera), fields(o.check)});
}

struct RecordedCamera::Recording {
  RecordedCameraOptions options;
  RecordingFormat format;
  CameraIntrinsics camera;
  double unit = 0.0;
  std::vector<RecordedFrame> frames;
  FrameCheck check;
  std::size_t next = 0;
  long number = 0;
  double round_start = 0.0;  // s, added to the recording's times in later rounds

  explicit Recording(const RecordedCameraOptions& o)
      : options(o), format(find_recording_format(o)), check("recording " + o.path, adapt(o)) {
    const CameraSettings settings = read_camera_settings(format, o);
    camera = to_intrinsics(settings);
    if (format != RecordingFormat::kClouds) unit = depth_unit(settings);
    frames = list_frames(format, o, camera);
  }

  // A recording of one frame that is looped shows the same image again, as it should.
  static FrameCheckOptions adapt(const RecordedCameraOptions& o) {
    FrameCheckOptions check = o.check;
    check.refuse_equal_image = check.refuse_equal_image && !o.loop;
    return check;
  }

  [[nodiscard]] DepthImage read(const RecordedFrame& frame) const {
    if (frame.image) return read_depth(*frame.image);
    if (format == RecordingFormat::kClouds) return to_depth_image(read_cloud(frame.path), camera);
    if (format != RecordingFormat::kZ16 && format != RecordingFormat::kV4l2)
      return read_depth_png(frame.path, camera, unit);
    std::vector<std::uint8_t> bytes(z16_bytes(camera, frame.bytes_per_line));
    std::ifstream in(frame.path, std::ios::binary);
    in.seekg(static_cast<std::streamoff>(frame.offset));
    if (!in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(bytes.size())))
      throw FileError(frame.path, concat("no whole frame at byte ", frame.offset), "record it again");
    return decode_z16(bytes, frame.bytes_per_line, camera, unit);
  }
};

RecordedCamera::RecordedCamera(const RecordedCameraOptions& options)
    : recording_(std::make_unique<Recording>(options)) {}
RecordedCamera::~RecordedCamera() = default;

DepthFrame RecordedCamera::capture() {
  Recording& r = *recording_;
  if (r.next == r.frames.size()) {
    if (!r.options.loop)
      throw DeviceError("recording " + r.options.path, concat("is over after ", r.frames.size(), " frames"),
                        "set loop, or record more");
    r.round_start += r.frames.back().time - r.frames.front().time + 1.0 / r.options.rate;
    r.next = 0;
  }
  const RecordedFrame& recorded = r.frames[r.next++];
  DepthFrame frame;
  frame.image = r.read(recorded);
  frame.number = ++r.number;
  frame.device_time = r.round_start + recorded.time;
  return r.check.pass(std::move(frame));
}

std::size_t RecordedCamera::frames() const {
  return recording_->frames.size();
}
const CameraIntrinsics& RecordedCamera::intrinsics() const {
  return recording_->camera;
}

}  // namespace stonestack::hardware
