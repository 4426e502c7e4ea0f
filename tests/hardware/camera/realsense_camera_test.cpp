// The RealSense backend, compiled against a declared part of librealsense over a scripted camera, and what a
// build without the library says.
#include "stonestack/hardware/camera/realsense_camera.hpp"

#include <gmock/gmock.h>

#include <librealsense2/rs.hpp>

#include "hardware/camera/realsense_device.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/hardware/cell_file.hpp"

namespace stonestack::hardware {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::ThrowsMessage;

/// 2 x 2 pixels in lines of three.
rs2::StubFrame frame(unsigned long long number, std::uint16_t count) {
  return {{count, 2000, 0xFFFF, 3000, 0, 0xFFFF}, 2, 2, 6, number, 1e3 * static_cast<double>(number)};
}

struct Realsense : testing::Test {
  Realsense() { rs2::stub() = {}; }
  static RealsenseCameraOptions options() {
    RealsenseCameraOptions options;
    options.width = options.height = 2;
    options.frame_timeout = 0.1;
    return options;
  }
};

TEST_F(Realsense, TakesUnitAndIntrinsicsFromTheCamera) {
  rs2::stub().intrinsics.model = RS2_DISTORTION_INVERSE_BROWN_CONRADY;
  rs2::stub().intrinsics.coeffs[1] = 0.25F;
  rs2::stub().depth_scale = 1.0F / 2048.0F;
  rs2::stub().to_come = {frame(1, 900), frame(2, 1024)};
  {
    const auto camera = open_realsense(options());
    EXPECT_TRUE(rs2::stub().started);
    const DepthFrame got = camera->capture();
    EXPECT_THAT(got.image.z, testing::ElementsAre(0.5F, 0.9765625F, 1.46484375F, 0.0F)) << "lines are padded";
    EXPECT_EQ(got.image.camera.fx, 400.0);
    EXPECT_EQ(got.image.camera.fy, 401.0);
    EXPECT_EQ(got.image.camera.distortion, CameraIntrinsics::Distortion::kInverseBrownConrady);
    EXPECT_EQ(got.image.camera.k[1], 0.25);
    EXPECT_EQ(got.number, 2);
    EXPECT_EQ(got.device_time, 2.0);
  }
  EXPECT_FALSE(rs2::stub().started);
}

TEST_F(Realsense, FramesFromBeforeTheCallAreDropped) {
  const auto camera = open_realsense(options());
  rs2::stub().waiting = {frame(1, 900), frame(2, 910)};
  rs2::stub().to_come = {frame(3, 920), frame(4, 930)};
  EXPECT_EQ(camera->capture().number, 4) << "what came next may have been exposed before, too";
  rs2::stub().to_come = {frame(4, 940), frame(4, 930)};
  EXPECT_THAT([&] { (void)camera->capture(); }, ThrowsMessage<DeviceError>(HasSubstr("stale")));
}

TEST_F(Realsense, NamesTheFault) {
  RealsenseCameraOptions other = options();
  other.serial = "1";
  EXPECT_THAT([&] { (void)open_realsense(other); },
              ThrowsMessage<DeviceError>(AllOf(HasSubstr("RealSense camera 1"), HasSubstr("No device"),
                                               HasSubstr("rs-enumerate-devices"))));
  other = options();
  other.width = 640;
  EXPECT_THAT([&] { (void)open_realsense(other); }, ThrowsMessage<DeviceError>(HasSubstr("resolve")));
  const auto camera = open_realsense(options());
  EXPECT_THAT([&] { (void)camera->capture(); },
              ThrowsMessage<DeviceError>(HasSubstr("no frame within 0.1 s")));
  rs2::stub().unplugged = true;
  EXPECT_THAT([&] { (void)camera->capture(); }, ThrowsMessage<DeviceError>(HasSubstr("was lost")));
  rs2::stub() = {};
  rs2::stub().intrinsics.model = RS2_DISTORTION_FTHETA;
  rs2::stub().intrinsics.coeffs[0] = 1.0F;
  EXPECT_THAT([&] { (void)open_realsense(options()); }, ThrowsMessage<DeviceError>(HasSubstr("lens model")));
}

TEST_F(Realsense, IsADriverOfACell) {
  CellConfig cell;
  for (const auto& field : fields(cell))
    if (field.name == "camera.realsense.serial") return;
  FAIL() << "a cell file cannot name it";
}

}  // namespace
}  // namespace stonestack::hardware
