// This machine has no video device: a kernel that the test writes stands in for it, down to the ioctls.
#include "stonestack/hardware/camera/v4l2_camera.hpp"

#include <gmock/gmock.h>
#include <linux/videodev2.h>

#include <array>
#include <cerrno>
#include <deque>

#include "hardware/camera/v4l2_calls.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

/// What the fake driver shall do, and what was asked of it.
struct Script {
  std::uint32_t capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  std::uint32_t format = V4L2_PIX_FMT_Z16;
  std::uint32_t width = 2, height = 2, line = 6;  // padded
  int fail_at = 0;                                // errno of STREAMON
  struct Frame {
    double time;
    unsigned flags;
    std::uint32_t used;
    std::array<std::uint8_t, 12> bytes;
  };
  std::deque<Frame> frames;
  bool endless = false;  // frames of the second 99, as many as one asks for
  double clock = 100.0;
  bool streaming = false;
  int queued = 0, mapped = 0;
};

class FakeKernel final : public V4l2Calls {
 public:
  explicit FakeKernel(Script& script) : script_(&script) {}
  int control(unsigned long request, void* argument) override {
    auto* buffer = static_cast<v4l2_buffer*>(argument);
    switch (request) {
      case VIDIOC_QUERYCAP:
        static_cast<v4l2_capability*>(argument)->capabilities = script_->capabilities;
        return 0;
      case VIDIOC_S_FMT: {
        auto& pix = static_cast<v4l2_format*>(argument)->fmt.pix;
        EXPECT_EQ(pix.pixelformat, V4L2_PIX_FMT_Z16);
        pix.pixelformat = script_->format;
        pix.width = script_->width;
        pix.height = script_->height;
        pix.bytesperline = script_->line;
        return 0;
      }
      case VIDIOC_REQBUFS:
        static_cast<v4l2_requestbuffers*>(argument)->count = 3;
        return 0;
      case VIDIOC_QUERYBUF:
        buffer->length = 12;
        buffer->m.offset = 4096 * buffer->index;
        return 0;
      case VIDIOC_QBUF:
        ++script_->queued;
        return 0;
      case VIDIOC_STREAMON:
        errno = script_->fail_at;
        script_->streaming = script_->fail_at == 0;
        return script_->fail_at == 0 ? 0 : -1;
      case VIDIOC_STREAMOFF:
        script_->streaming = false;
        return 0;
      case VIDIOC_DQBUF:
        return dequeue(*buffer);
      default:
        errno = ENOTTY;
        return -1;
    }
  }
  void* map(std::size_t length, off_t offset) override {
    EXPECT_EQ(length, 12U);
    ++script_->mapped;
    return memory_.at(static_cast<std::size_t>(offset / 4096)).data();
  }
  void unmap(void* /*address*/, std::size_t /*length*/) override { --script_->mapped; }
  bool wait(Deadline /*deadline*/) override {
    if (script_->endless && script_->frames.empty()) script_->frames.push_back({99.0, 0, 12, {}});
    return !script_->frames.empty();
  }
  double now() override { return script_->clock; }

 private:
  int dequeue(v4l2_buffer& buffer) {
    const auto frame = script_->frames.front();
    script_->frames.pop_front();
    --script_->queued;
    buffer.index = sequence_ % 3;
    memory_[buffer.index] = frame.bytes;
    buffer.bytesused = frame.used;
    buffer.flags = frame.flags;
    buffer.sequence = sequence_++;
    buffer.timestamp.tv_sec = static_cast<time_t>(frame.time);
    buffer.timestamp.tv_usec =
        static_cast<suseconds_t>((frame.time - static_cast<double>(buffer.timestamp.tv_sec)) * 1e6);
    return 0;
  }
  Script* script_;
  std::array<std::array<std::uint8_t, 12>, 3> memory_{};
  unsigned sequence_ = 0;
};

constexpr std::array<std::uint8_t, 12> kRaw{0xF4, 0x01, 0xE8, 0x03, 0xAA, 0xAA,
                                            0x00, 0x00, 0x58, 0x02, 0xAA, 0xAA};
constexpr std::array<std::uint8_t, 12> kOther{0xF5, 0x01, 0xE8, 0x03, 0xAA, 0xAA,
                                              0x00, 0x00, 0x58, 0x02, 0xAA, 0xAA};

struct Bench {
  Script script;
  V4l2CameraOptions options;
  Bench() {
    options.device = "/dev/video9";
    options.camera.width = options.camera.height = 2;
    options.camera.fx = options.camera.fy = 2.0;
    options.camera.depth_scale = 1000;
    options.frame_timeout = 0.1;
  }
  [[nodiscard]] V4l2Stream open() { return {std::make_unique<FakeKernel>(script), options}; }
};

TEST(V4l2Camera, DecodesAFrameOfPaddedLines) {
  Bench bench;
  bench.script.frames = {{100.5, 0, 12, kRaw}};
  V4l2Stream stream = bench.open();
  EXPECT_TRUE(bench.script.streaming);
  const DepthFrame frame = stream.capture();
  EXPECT_EQ(frame.image.z, (std::vector<float>{0.5F, 1.0F, 0.0F, 0.6F}));
  EXPECT_NEAR(frame.device_time, 100.5, 1e-5);
  EXPECT_LE(std::abs(frame.host_time - host_seconds()), 60.0);
  EXPECT_EQ(frame.number, 1);
  EXPECT_EQ(bench.script.queued, 3) << "the buffer went back";
}

TEST(V4l2Camera, FramesExposedBeforeTheCallAndDamagedOnesAreDropped) {
  Bench bench;
  bench.script.frames = {{99.9, 0, 12, kOther},
                         {100.1, V4L2_BUF_FLAG_ERROR, 12, kOther},
                         {100.2, 0, 7, kOther},
                         {100.3, 0, 12, kRaw}};
  V4l2Stream stream = bench.open();
  const DepthFrame frame = stream.capture();
  EXPECT_NEAR(frame.device_time, 100.3, 1e-5);
  EXPECT_EQ(frame.number, 4);
  EXPECT_EQ(bench.script.queued, 3);
}

TEST(V4l2Camera, OldFramesWithoutEndEndAtTheDeadline) {
  Bench bench;
  bench.script.endless = true;  // all exposed before the call: a clock that stands
  V4l2Stream stream = bench.open();
  EXPECT_THAT([&] { (void)stream.capture(); },
              ThrowsMessage<DeviceError>(HasSubstr("no frame within 0.1 s")));
}

TEST(V4l2Camera, AFrozenImageIsRefused) {
  Bench bench;
  bench.script.frames = {{100.1, 0, 12, kRaw}, {100.2, 0, 12, kRaw}, {100.3, 0, 12, kOther}};
  V4l2Stream stream = bench.open();
  (void)stream.capture();
  EXPECT_THAT([&] { (void)stream.capture(); }, ThrowsMessage<DeviceError>(HasSubstr("/dev/video9")));
  EXPECT_EQ(stream.capture().number, 3);
}

TEST(V4l2Camera, SilenceEndsAtTheDeadlineAndTellsOfDamagedFrames) {
  Bench bench;
  bench.script.frames = {{100.1, V4L2_BUF_FLAG_ERROR, 12, kRaw}};
  V4l2Stream stream = bench.open();
  EXPECT_THAT([&] { (void)stream.capture(); },
              ThrowsMessage<DeviceError>(HasSubstr("no frame within 0.1 s, 1 damaged")));
}

TEST(V4l2Camera, SaysWhatIsWrongWithTheNode) {
  const auto open_with = [](auto change, const char* text) {
    Bench bench;
    change(bench);
    EXPECT_THAT([&] { const V4l2Stream stream = bench.open(); }, ThrowsMessage<DeviceError>(HasSubstr(text)));
  };
  open_with([](Bench& b) { b.script.capabilities = V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING; },
            "give the depth node");
  open_with([](Bench& b) { b.script.format = V4L2_PIX_FMT_YUYV; }, "gives 'YUYV', not 'Z16 '");
  open_with([](Bench& b) { b.script.width = 640; }, "gives 640 x 2 pixels, not 2 x 2");
  open_with([](Bench& b) { b.script.fail_at = ENOSPC; }, "does not start: No space left");
  EXPECT_THAT(
      [] {
        V4l2CameraOptions options = Bench().options;
        options.device = "/dev/video-nothing";
        const V4l2Camera camera(options);
      },
      ThrowsMessage<DeviceError>(HasSubstr("/dev/video-nothing")));
}

TEST(V4l2Camera, ScaleAndFocalLengthsMustBeGiven) {
  Bench bench;
  bench.options.camera.depth_scale = 0;
  EXPECT_THROW((void)bench.open(), InvalidArgument);
  bench.options.camera.depth_scale = 1000;
  bench.options.camera.fx = 0;
  EXPECT_THROW(V4l2Camera{bench.options}, InvalidArgument);
}

TEST(V4l2Camera, StopsAndUnmapsAtTheEnd) {
  Bench bench;
  {
    const V4l2Stream stream = bench.open();
    EXPECT_EQ(bench.script.mapped, 3);
  }
  EXPECT_EQ(bench.script.mapped, 0);
  EXPECT_FALSE(bench.script.streaming);
}

}  // namespace
}  // namespace stonestack
