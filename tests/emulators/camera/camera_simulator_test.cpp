#include "emulators/camera/camera_simulator.hpp"

#include <gmock/gmock.h>

#include <memory>
#include <vector>

#include "hardware/camera/stream_camera.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::emulators {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

CameraIntrinsics small_camera() {
  CameraIntrinsics camera;
  camera.width = 64;
  camera.height = 48;
  camera.fx = camera.fy = 47.5;
  camera.cx = 31.5;
  camera.cy = 23.5;
  camera.distortion = CameraIntrinsics::Distortion::kInverseBrownConrady;
  camera.k[0] = 0.1;
  return camera;
}

struct CameraBench {
  IdealDepthPlant plant{small_camera(), 0.7, 0.000125};
  CameraSimulator simulator{plant};
  StreamCameraOptions options;
  CameraBench() {
    options.port = simulator.endpoint().port;
    options.frame_timeout = 2.0;
  }
};

TEST(CameraSimulator, AFrameArrivesAsItWasSeen) {
  CameraBench bench;
  StreamCamera camera(bench.options);
  const DepthFrame first = camera.capture(), second = camera.capture();
  EXPECT_EQ(first.image.camera.width, 64);
  EXPECT_EQ(first.image.camera.distortion, CameraIntrinsics::Distortion::kInverseBrownConrady);
  EXPECT_DOUBLE_EQ(first.image.camera.fx, 47.5);
  EXPECT_DOUBLE_EQ(first.image.camera.k[0], 0.1);
  EXPECT_NEAR(first.image.at(10, 10), 0.7, 0.0002);
  EXPECT_GT(second.number, first.number);
  EXPECT_GT(second.device_time, first.device_time);
}

TEST(CameraSimulator, StreamsToWhoAsksForIt) {
  CameraBench bench;
  TcpStream viewer = TcpStream::connect(bench.simulator.endpoint(), Deadline::in(10));
  StreamCamera camera(bench.options);
  ASSERT_TRUE(viewer.write_all("stream\n", Deadline::in(10)));
  std::vector<std::uint8_t> frames(3 * (128 + 2 * 64 * 48));
  EXPECT_TRUE(viewer.read_exact(frames, Deadline::in(10)));
  EXPECT_EQ((std::string{frames.begin(), frames.begin() + 4}), "SSD1");
  EXPECT_EQ(frames[4], 128);
  EXPECT_EQ(frames[8], 64);
  EXPECT_EQ(frames[12], 48);
  EXPECT_EQ(frames[128 + 6144], 'S') << "the next frame follows at once";
  EXPECT_GT(camera.capture().number, 0) << "beside it another client is served";
}

TEST(CameraSimulator, OneDamagedFrameIsAskedForAgain) {
  for (int CameraFaults::*fault : {&CameraFaults::hang_up, &CameraFaults::bad_crc, &CameraFaults::garbage,
                                   &CameraFaults::wrong_size, &CameraFaults::not_finite}) {
    CameraBench bench;
    StreamCamera camera(bench.options);
    CameraFaults faults;
    faults.*fault = 1;
    bench.simulator.set_faults(faults);
    EXPECT_NEAR(camera.capture().image.at(5, 5), 0.7, 0.0002);
  }
}

TEST(CameraSimulator, DamageWithoutEndIsAnErrorThatNamesTheAddress) {
  const std::vector<std::pair<int CameraFaults::*, const char*>> cases{
      {&CameraFaults::no_frame, "no frame within 0.2 s"},
      {&CameraFaults::hang_up, "connection was closed"},
      {&CameraFaults::truncated, "no frame within 0.2 s"},
      {&CameraFaults::bad_crc, "do not match their checksum"},
      {&CameraFaults::garbage, "no frame of this protocol"},
      {&CameraFaults::wrong_size, "bytes for 64 x 48 pixels"},
      {&CameraFaults::not_finite, "values out of range"},
      {&CameraFaults::delayed, "no frame within 0.2 s"}};
  for (const auto& [fault, text] : cases) {
    CameraBench bench;
    bench.options.frame_timeout = 0.2;
    StreamCamera camera(bench.options);
    CameraFaults faults;
    faults.*fault = -1;
    faults.delay = 0.4;
    bench.simulator.set_faults(faults);
    EXPECT_THAT(
        [&] { (void)camera.capture(); },
        ThrowsMessage<DeviceError>(AllOf(HasSubstr(to_text(bench.simulator.endpoint())), HasSubstr(text))));
  }
}

TEST(CameraSimulator, StaleFrozenEmptyAndMisscaledFramesAreRefused) {
  const std::vector<std::pair<int CameraFaults::*, const char*>> cases{
      {&CameraFaults::repeated, "the stream is stale"},
      {&CameraFaults::frozen, "the image is frozen"},
      {&CameraFaults::empty, "of the pixels have a depth"},
      {&CameraFaults::scaled, "check depth_scale"}};
  for (const auto& [fault, text] : cases) {
    CameraBench bench;
    StreamCamera camera(bench.options);
    (void)camera.capture();
    CameraFaults faults;
    faults.*fault = 1;
    bench.simulator.set_faults(faults);
    EXPECT_THAT([&] { (void)camera.capture(); }, ThrowsMessage<DeviceError>(HasSubstr(text)));
    EXPECT_NEAR(camera.capture().image.at(5, 5), 0.7, 0.0002) << "the next good one is taken";
  }
}

TEST(CameraSimulator, AServerThatWasStartedAgainIsTakenUpOnce) {
  IdealDepthPlant plant(small_camera(), 0.7, 0.000125);
  auto simulator = std::make_unique<CameraSimulator>(plant);
  StreamCameraOptions options;
  options.port = simulator->endpoint().port;
  options.frame_timeout = 2.0;
  StreamCamera camera(options);
  for (int k = 0; k < 3; ++k) (void)camera.capture();
  simulator.reset();
  IdealDepthPlant again(small_camera(), 0.7, 0.000125);  // numbers and times begin anew
  CameraSimulatorOptions same_port;
  same_port.port = options.port;
  simulator = std::make_unique<CameraSimulator>(again, same_port);
  EXPECT_EQ(camera.capture().number, 1);
  EXPECT_EQ(camera.capture().number, 2);
  CameraFaults faults;
  faults.repeated = 1;
  simulator->set_faults(faults);
  EXPECT_THAT([&] { (void)camera.capture(); }, ThrowsMessage<DeviceError>(HasSubstr("the stream is stale")));
}

TEST(CameraSimulator, AMissingDeviceIsNamed) {
  StreamCameraOptions options;
  {
    const CameraBench bench;
    options.port = bench.options.port;
  }
  EXPECT_THAT([&] { StreamCamera camera(options); },
              ThrowsMessage<DeviceError>(HasSubstr("connection refused")));
}

}  // namespace
}  // namespace stonestack::emulators
