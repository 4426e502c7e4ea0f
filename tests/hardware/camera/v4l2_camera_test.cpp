// This machine has no video device: a kernel that the test writes stands in for it, down to the ioctls.
#include "hardware/camera/v4l2_camera.hpp"

#include <gmock/gmock.h>
#include <linux/videodev2.h>

#include <array>
#include <cerrno>
#include <deque>
#include <filesystem>

#include "hardware/camera/recorded_camera.hpp"
#include "hardware/camera/v4l2_calls.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "temporary_folder.hpp"

namespace stonestack::hardware {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;

/// Script of the fake driver, and the calls it received.
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
  std::string asked;  // S format, R buffers, Q a buffer in, + on, D a buffer out, - off
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
        script_->asked += 'S';
        auto& pix = static_cast<v4l2_format*>(argument)->fmt.pix;
        EXPECT_EQ(pix.pixelformat, V4L2_PIX_FMT_Z16);
        pix.pixelformat = script_->format;
        pix.width = script_->width;
        pix.height = script_->height;
        pix.bytesperline = script_->line;
        return 0;
      }
      case VIDIOC_REQBUFS:
        script_->asked += 'R';
        static_cast<v4l2_requestbuffers*>(argument)->count = 3;
        return 0;
      case VIDIOC_QUERYBUF:
        buffer->length = 12;
        buffer->m.offset = 4096 * buffer->index;
        return 0;
      case VIDIOC_QBUF:
        script_->asked += 'Q';
        ++script_->queued;
        return 0;
      case VIDIOC_STREAMON:
        script_->asked += '+';
        errno = script_->fail_at;
        script_->streaming = script_->fail_at == 0;
        return script_->fail_at == 0 ? 0 : -1;
      case VIDIOC_STREAMOFF:
        script_->asked += '-';
        script_->streaming = false;
        return 0;
      case VIDIOC_DQBUF:
        script_->asked += 'D';
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

// Lines of 6 bytes: the last one's padding may be missing, its pixels may not. 9 bytes would do without
// padding.
TEST(V4l2Camera, ShortFramesOfPaddedLinesAreDamaged) {
  Bench bench;
  bench.script.frames = {{100.1, 0, 9, kOther}, {100.2, 0, 10, kRaw}};
  V4l2Stream stream = bench.open();
  EXPECT_EQ(stream.capture().number, 2);
  EXPECT_EQ(bench.script.queued, 3);
}

TEST(V4l2Camera, AsksInTheOrderThatTheKernelWants) {
  Bench bench;
  bench.script.frames = {{100.1, 0, 12, kRaw}};
  {
    V4l2Stream stream = bench.open();
    (void)stream.capture();
  }
  EXPECT_EQ(bench.script.asked, "SRQQQ+DQ-");
}

TEST(V4l2Camera, AFailedStartLeavesNothingMapped) {
  Bench bench;
  bench.script.fail_at = ENOSPC;
  EXPECT_THROW((void)bench.open(), DeviceError);
  EXPECT_EQ(bench.script.mapped, 0);
}

TEST(V4l2Camera, TimeStampsOfAnotherClockAreRefused) {
  Bench bench;
  bench.script.frames = {{1.7e9, 0, 12, kRaw}};  // since 1970
  V4l2Stream stream = bench.open();
  EXPECT_THAT([&] { (void)stream.capture(); }, ThrowsMessage<DeviceError>(HasSubstr("monotonic clock")));
  EXPECT_EQ(bench.script.queued, 3);
}

// As they came: padding, a damaged one, a short one, one from before the call. The recording gives what the
// device gave, and the one from before, for nobody waits any more.
TEST(V4l2Camera, RecordingsPlayThroughTheSameDecoder) {
  const auto folder = std::filesystem::path(test::temporary_folder()) / "v4l2_recording";
  std::filesystem::remove_all(folder);
  Bench bench;
  bench.options.record = folder.string();
  bench.options.camera.cx = 0.25;
  bench.script.frames = {{99.5, 0, 12, kOther},
                         {100.1, V4L2_BUF_FLAG_ERROR, 12, kOther},
                         {100.2, 0, 9, kOther},
                         {100.25, 0, 10, kRaw},
                         {100.5, 0, 12, kOther}};
  std::vector<DepthFrame> live;
  {
    V4l2Stream stream = bench.open();
    live.push_back(stream.capture());
    live.push_back(stream.capture());
  }
  RecordedCameraOptions options;
  options.path = folder.string();
  RecordedCamera played(options);
  ASSERT_EQ(played.frames(), 3U);
  EXPECT_EQ(played.intrinsics().cx, 0.25);
  EXPECT_NEAR(played.capture().device_time, 99.5, 1e-5);
  for (const DepthFrame& frame : live) {
    const DepthFrame again = played.capture();
    EXPECT_EQ(again.image.z, frame.image.z);
    EXPECT_EQ(again.device_time, frame.device_time);
  }
  EXPECT_EQ(std::filesystem::file_size(folder / "v4l2.raw"), 12U + 12 + 9 + 10 + 12);
  EXPECT_THAT([&] { (void)bench.open(); }, ThrowsMessage<FileError>(HasSubstr("holds a recording already")));
}

TEST(V4l2Camera, RecordingsThatLieAreNamed) {
  CameraIntrinsics camera;
  camera.width = camera.height = 2;
  const auto refused = [&](const std::string& text, const char* problem) {
    EXPECT_THAT([&] { (void)parse_v4l2_list(text, "/r", camera, 24); },
                ThrowsMessage<FileError>(HasSubstr(problem)))
        << text;
  };
  const std::string head = "stonestack v4l2 1\nZ16 2 2 6\n";
  EXPECT_EQ(parse_v4l2_list(head + "0 5 0 0 12\n1 6 0 0 12\n", "/r", camera, 24).at(1).offset, 12U);
  refused("", "does not begin");
  refused("stonestack v4l2 1\nYUYV 2 2 6\n", "line 2");
  refused("stonestack v4l2 1\nZ16 4 2 8\n", "frames of 4 x 2");
  refused("stonestack v4l2 1\nZ16 2 2 3\n", "lines of 3 bytes");
  refused(head + "0 5 0 0 25\n", "no more than 24");
  refused(head + "0 5 0 0 12\n1 5 0 0 12\n", "line 4: a time that does not rise");
  refused(head + "0 5 0 0\n", "line 3");
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

TEST(V4l2Camera, EqualImagesPassWhereTheOptionAllowsThem) {
  Bench bench;
  bench.options.check.refuse_equal_image = false;
  bench.script.frames = {{100.1, 0, 12, kRaw}, {100.2, 0, 12, kRaw}};
  V4l2Stream stream = bench.open();
  (void)stream.capture();
  EXPECT_EQ(stream.capture().number, 2);
}

TEST(V4l2Camera, SilenceEndsAtTheDeadlineAndReportsDamagedFrames) {
  Bench bench;
  bench.script.frames = {{100.1, V4L2_BUF_FLAG_ERROR, 12, kRaw}};
  V4l2Stream stream = bench.open();
  EXPECT_THAT([&] { (void)stream.capture(); },
              ThrowsMessage<DeviceError>(HasSubstr("no frame within 0.1 s, 1 damaged")));
}

TEST(V4l2Camera, NamesTheFaultOfTheNode) {
  const auto open_with = [](auto change, const char* text) {
    Bench bench;
    change(bench);
    EXPECT_THAT([&] { const V4l2Stream stream = bench.open(); }, ThrowsMessage<DeviceError>(HasSubstr(text)));
  };
  open_with([](Bench& b) { b.script.capabilities = V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING; },
            "give the depth node");
  open_with([](Bench& b) { b.script.format = V4L2_PIX_FMT_YUYV; }, "gives 'YUYV', not 'Z16 '");
  open_with([](Bench& b) { b.script.width = 640; }, "gives 640 x 2 pixels, not 2 x 2");
  open_with([](Bench& b) { b.script.line = 3; }, "gives lines of 3 bytes for 2 pixels");
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
}  // namespace stonestack::hardware
