#include "hardware/camera/v4l2_camera.hpp"

#include <linux/videodev2.h>

#include <array>
#include <cerrno>
#include <cstring>

#include "hardware/camera/v4l2_calls.hpp"
#include "hardware/constants.hpp"
#include "protocol/z16.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::hardware {
namespace {

std::string four_letters(std::uint32_t code) {
  std::string text;
  for (unsigned shift = 0; shift < 32; shift += 8) {
    const auto letter = static_cast<char>(code >> shift & 0xFFU);
    text.push_back(letter >= ' ' && letter < 0x7F ? letter : '?');
  }
  return text;
}

v4l2_buffer make_buffer(unsigned index) {
  v4l2_buffer buffer{};
  buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  buffer.memory = V4L2_MEMORY_MMAP;
  buffer.index = index;
  return buffer;
}

}  // namespace

FieldList fields(V4l2CameraOptions& o) {
  FieldList own = {
      user(field("device", o.device, "path of the depth node, see `v4l2-ctl --list-devices`")),
      field("frame_timeout", o.frame_timeout, {0.05, 60.0}, "s", "until the next frame"),
      field("record", o.record, "folder for what the driver gives, to be played as `recorded`; empty: none"),
  };
  return join({own, fields(o.camera), fields(o.check)});
}

V4l2Stream::V4l2Stream(std::unique_ptr<V4l2Calls> calls, const V4l2CameraOptions& options)
    : calls_(std::move(calls)),
      options_(options),
      camera_(to_intrinsics(options.camera)),
      unit_(depth_unit(options.camera)),
      check_("depth camera " + options.device, options.check) {
  try {
    open();
  } catch (...) {
    release();  // buffers that stay mapped keep the device busy for whoever tries again
    throw;
  }
}

void V4l2Stream::open() {
  v4l2_capability capability{};
  if (calls_->control(VIDIOC_QUERYCAP, &capability) < 0)
    fail("is no video device: " + std::string(std::strerror(errno)), "give the depth node of the camera");
  const unsigned can = (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? capability.device_caps
                                                                             : capability.capabilities;
  if ((can & V4L2_CAP_VIDEO_CAPTURE) == 0 || (can & V4L2_CAP_STREAMING) == 0)
    fail("cannot stream pictures", "give the depth node; other nodes of the camera carry metadata");
  set_format();
  map_buffers();
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  if (calls_->control(VIDIOC_STREAMON, &type) < 0)
    fail("does not start: " + std::string(std::strerror(errno)), "use a USB 3 port; end other programs");
}

V4l2Stream::~V4l2Stream() {
  release();
}

void V4l2Stream::release() noexcept {
  int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  calls_->control(VIDIOC_STREAMOFF, &type);
  for (const auto& buffer : buffers_) calls_->unmap(buffer.start, buffer.length);
  buffers_.clear();
}

void V4l2Stream::fail(const std::string& problem, const std::string& remedy) const {
  throw DeviceError("depth camera " + options_.device, problem, remedy);
}

void V4l2Stream::set_format() {
  v4l2_format format{};
  format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  format.fmt.pix.width = static_cast<std::uint32_t>(camera_.width);
  format.fmt.pix.height = static_cast<std::uint32_t>(camera_.height);
  format.fmt.pix.pixelformat = V4L2_PIX_FMT_Z16;
  format.fmt.pix.field = V4L2_FIELD_NONE;
  if (calls_->control(VIDIOC_S_FMT, &format) < 0)
    fail("refuses Z16: " + std::string(std::strerror(errno)), "end other programs that use the camera");
  const auto& got = format.fmt.pix;
  if (got.pixelformat != V4L2_PIX_FMT_Z16)
    fail("gives '" + four_letters(got.pixelformat) + "', not 'Z16 '",
         "give the depth node, not the colour node; an SR300 gives Z16 since kernel 4.12, and librealsense "
         "serves it up to 2.50.0");
  if (got.width != static_cast<std::uint32_t>(camera_.width) ||
      got.height != static_cast<std::uint32_t>(camera_.height))
    fail(
        concat("gives ", got.width, " x ", got.height, " pixels, not ", camera_.width, " x ", camera_.height),
        "ask for a size that it has, and give the intrinsics of that size");
  bytes_per_line_ = got.bytesperline;
  if (z16_bytes(camera_, bytes_per_line_) == 0)
    fail(concat("gives lines of ", bytes_per_line_, " bytes for ", camera_.width, " pixels"),
         "update the kernel: its driver is broken");
  if (!options_.record.empty())
    recorder_.emplace(options_.record, options_.camera,
                      V4l2Format{camera_.width, camera_.height, bytes_per_line_});
}

void V4l2Stream::map_buffers() {
  v4l2_requestbuffers request{};
  request.count = static_cast<std::uint32_t>(kBuffers);
  request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
  request.memory = V4L2_MEMORY_MMAP;
  if (calls_->control(VIDIOC_REQBUFS, &request) < 0 || request.count < 2)
    fail("gives no buffers: " + std::string(std::strerror(errno)), "end other programs that use the camera");
  for (unsigned i = 0; i < request.count; ++i) {
    v4l2_buffer buffer = make_buffer(i);
    if (calls_->control(VIDIOC_QUERYBUF, &buffer) < 0) fail("loses a buffer", "plug the camera in again");
    void* start = calls_->map(buffer.length, static_cast<off_t>(buffer.m.offset));
    if (start == nullptr)
      fail("cannot map a buffer: " + std::string(std::strerror(errno)), "free some memory");
    buffers_.push_back({start, buffer.length});
    queue(i);
  }
}

void V4l2Stream::queue(unsigned index) {
  v4l2_buffer buffer = make_buffer(index);
  if (calls_->control(VIDIOC_QBUF, &buffer) < 0)
    fail("does not take a buffer back: " + std::string(std::strerror(errno)), "plug the camera in again");
}

// With another clock, frames that waited in the queue could not be distinguished from new ones.
void V4l2Stream::check_time(double time) const {
  constexpr double kAhead = 1.0;  // s
  if (time > calls_->now() + kAhead)
    fail(concat("its time stamps are ", time - calls_->now(), " s ahead of the monotonic clock"),
         "load its driver with that clock: modprobe uvcvideo clock=CLOCK_MONOTONIC");
}

DepthFrame V4l2Stream::capture() {
  const double asked = calls_->now();
  const Deadline deadline = Deadline::in(options_.frame_timeout).or_interrupt();
  int damaged = 0;
  bool waits = true;  // for one that is new and whole, however many others come
  for (; waits && calls_->wait(deadline); waits = !deadline.over()) {
    throw_if_interrupted();
    v4l2_buffer buffer = make_buffer(0);
    if (calls_->control(VIDIOC_DQBUF, &buffer) < 0) {
      if (errno == EAGAIN || errno == EINTR) continue;
      fail("was lost: " + std::string(std::strerror(errno)), "plug the camera in again");
    }
    if (buffer.index >= buffers_.size())
      fail("gives a buffer that does not exist", "plug the camera in again");
    const auto& place = buffers_[buffer.index];
    const V4l2Note note{buffer.sequence, buffer.timestamp.tv_sec, buffer.timestamp.tv_usec,
                        (buffer.flags & V4L2_BUF_FLAG_ERROR) != 0,
                        std::min<std::size_t>(buffer.bytesused, place.length)};
    const std::span bytes(static_cast<const std::uint8_t*>(place.start), note.bytes);
    if (recorder_) recorder_->add(note, bytes);
    DepthFrame frame;
    const bool whole = !note.error && note.bytes >= z16_bytes(camera_, bytes_per_line_);
    if (note.time() >= asked && whole) {
      frame.image = decode_z16(bytes, bytes_per_line_, camera_, unit_);
      frame.number = static_cast<long>(note.sequence) + 1;
      frame.device_time = note.time();
    }
    queue(buffer.index);
    check_time(note.time());
    if (frame.number > 0) return check_.pass(std::move(frame));
    if (!whole) ++damaged;
  }
  fail(concat("no frame within ", options_.frame_timeout, " s",
              damaged > 0 ? concat(", ", damaged, " damaged ones") : ""),
       "plug the camera in again, into a USB 3 port");
}

struct V4l2Camera::Device {
  V4l2Stream stream;
};

V4l2Camera::V4l2Camera(const V4l2CameraOptions& options) {
  static_cast<void>(to_intrinsics(options.camera));
  static_cast<void>(depth_unit(options.camera));
  device_.reset(new Device{{open_v4l2(options.device), options}});
}
V4l2Camera::~V4l2Camera() = default;

DepthFrame V4l2Camera::capture() {
  return device_->stream.capture();
}

}  // namespace stonestack::hardware
