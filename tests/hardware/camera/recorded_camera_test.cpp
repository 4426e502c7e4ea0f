#include "hardware/camera/recorded_camera.hpp"

#include <gmock/gmock.h>

#include <filesystem>

#include "geometry/bop_folder.hpp"
#include "hardware/camera/recording.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/geometry/cloud.hpp"
#include "temporary_folder.hpp"

namespace stonestack::hardware {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::ThrowsMessage;

class Recorded : public testing::Test {
 protected:
  fs::path folder =
      fs::path(test::temporary_folder()) /
      (std::string("recorded_") + testing::UnitTest::GetInstance()->current_test_info()->name());
  RecordedCameraOptions options;

  void SetUp() override {
    fs::remove_all(folder);
    fs::create_directories(folder / "depth");
    options.path = folder.string();
    options.camera.width = 8;
    options.camera.height = 6;
    options.camera.fx = options.camera.fy = 6.0;
    options.camera.cx = 3.5;
    options.camera.cy = 2.5;
  }
  void TearDown() override { fs::remove_all(folder); }

  [[nodiscard]] DepthImage plane(float z) const {
    return {to_intrinsics(options.camera), std::vector<float>(48, z)};
  }
  // Written at `scale` counts a metre.
  void write_tum(double scale) const {
    write_depth_png((folder / "depth/a.png").string(), plane(0.5F), 1 / scale);
    write_depth_png((folder / "depth/b.png").string(), plane(0.6F), 1 / scale);
    write_file((folder / "depth.txt").string(), "# depth maps\n10.5 depth/a.png\r\n10.75 depth/b.png\n");
  }
};

TEST_F(Recorded, PlaysATumFolderWithItsTimes) {
  write_tum(5000);
  options.camera.depth_scale = 5000;
  RecordedCamera camera(options);
  EXPECT_EQ(camera.frames(), 2U);
  const DepthFrame a = camera.capture(), b = camera.capture();
  EXPECT_NEAR(a.image.at(3, 3), 0.5, 1e-4);
  EXPECT_NEAR(b.image.at(3, 3), 0.6, 1e-4);
  EXPECT_DOUBLE_EQ(a.device_time, 10.5);
  EXPECT_DOUBLE_EQ(b.device_time, 10.75);
  EXPECT_LT(a.number, b.number);
  EXPECT_THAT([&] { (void)camera.capture(); },
              ThrowsMessage<DeviceError>(HasSubstr("is over after 2 frames")));
}

TEST_F(Recorded, NeverGuessesTheScale) {
  write_tum(5000);
  EXPECT_THAT([&] { RecordedCamera camera(options); },
              ThrowsMessage<InvalidArgument>(HasSubstr("depth_scale is not given")));
  write_file((folder / "camera.yaml").string(), "depth_scale: 5000\n");
  RecordedCamera camera(options);
  EXPECT_NEAR(camera.capture().image.at(0, 0), 0.5, 1e-4) << "metadata in the folder counts";
}

TEST_F(Recorded, NeedsFocalLengths) {
  write_tum(5000);
  options.camera.depth_scale = 5000;
  options.camera.fx = 0;
  EXPECT_THAT([&] { RecordedCamera camera(options); },
              ThrowsMessage<InvalidArgument>(HasSubstr("focal lengths are not given")));
}

TEST_F(Recorded, ALoopGoesOnInTime) {
  write_tum(5000);
  options.camera.depth_scale = 5000;
  options.loop = true;
  RecordedCamera camera(options);
  double time = 0.0;
  for (int i = 0; i < 5; ++i) {
    const DepthFrame frame = camera.capture();
    EXPECT_GT(frame.device_time, time);
    EXPECT_EQ(frame.number, i + 1);
    time = frame.device_time;
  }
}

TEST_F(Recorded, PlaysABopFolderWithWhatItSays) {
  options.rate = 10.0;
  DepthImage bent = plane(0.5F), next = plane(0.6F);
  options.camera = {};  // not needed: the recording has it all
  bent.camera.distortion = CameraIntrinsics::Distortion::kBrownConrady;
  bent.camera.k[0] = 0.1;
  BopFolder images(folder.string());
  images.add(bent, 20.0, std::nullopt);
  images.add(next, 20.25, std::nullopt);
  RecordedCamera camera(options);
  EXPECT_EQ(camera.intrinsics().distortion, CameraIntrinsics::Distortion::kBrownConrady);
  const DepthFrame a = camera.capture(), b = camera.capture();
  EXPECT_NEAR(a.image.at(3, 3), 0.5, 1e-4);
  EXPECT_NEAR(b.image.at(3, 3), 0.6, 1e-4);
  EXPECT_EQ(a.image.camera.k[0], 0.1);
  EXPECT_DOUBLE_EQ(b.device_time - a.device_time, 0.25);
  write_file((folder / "scene_camera.json").string(),  // as others write it, without times
             R"({"0": {"cam_K": [6, 0, 3.5, 0, 6, 2.5, 0, 0, 1], "depth_scale": 0.01},
                 "1": {"cam_K": [6, 0, 3.5, 0, 6, 2.5, 0, 0, 1], "depth_scale": 0.01}})");
  RecordedCamera untimed(options);
  const double first = untimed.capture().device_time;
  EXPECT_NEAR(untimed.capture().device_time - first, 0.1, 1e-12) << "at the rate that is set";
}

TEST_F(Recorded, PlaysAnOpen3dFolderWithItsIntrinsics) {
  write_depth_png((folder / "depth/00000.png").string(), plane(0.5F), 0.001);
  write_file((folder / "camera_intrinsic.json").string(),
             R"({"width": 8, "height": 6, "intrinsic_matrix": [7.0, 0, 0, 0, 7.5, 0, 3.0, 2.0, 1]})");
  options.camera.depth_scale = 1000;
  options.camera.fx = 0;  // not needed: the recording has it
  RecordedCamera camera(options);
  EXPECT_EQ(camera.intrinsics().fx, 7.0);
  EXPECT_EQ(camera.intrinsics().fy, 7.5);
  EXPECT_EQ(camera.intrinsics().cx, 3.0);
  EXPECT_EQ(camera.intrinsics().cy, 2.0);
  EXPECT_NEAR(camera.capture().image.at(1, 1), 0.5, 1e-4);
}

TEST_F(Recorded, BrokenCalibrationOfOpen3dIsNamed) {
  for (const char* json : {"{", "{}", R"({"width": 8, "height": 6, "intrinsic_matrix": [1, 2]})",
                           R"({"width": "x", "height": 6, "intrinsic_matrix": [1,2,3,4,5,6,7,8,9]})"}) {
    write_file((folder / "camera_intrinsic.json").string(), json);
    EXPECT_THAT([&] { RecordedCamera camera(options); },
                ThrowsMessage<FileError>(HasSubstr("camera_intrinsic.json")))
        << json;
  }
}

TEST_F(Recorded, PlaysClouds) {
  write_cloud((folder / "a.pcd").string(), to_cloud(plane(0.5F)));
  write_cloud((folder / "b.ply").string(), to_cloud(plane(0.75F)));
  RecordedCamera camera(options);
  EXPECT_NEAR(camera.capture().image.at(4, 3), 0.5, 1e-5);
  EXPECT_NEAR(camera.capture().image.at(4, 3), 0.75, 1e-5);
}

TEST_F(Recorded, PlaysRawFramesByTheByte) {
  std::string raw;
  for (int i = 0; i < 48; ++i) raw += std::string("\xF4\x01", 2);  // 500
  for (int i = 0; i < 48; ++i) raw += std::string("\x58\x02", 2);  // 600
  write_file((folder / "depth.z16").string(), raw);
  options.path = (folder / "depth.z16").string();
  options.camera.depth_scale = 1000;
  {
    RecordedCamera camera(options);
    EXPECT_EQ(camera.frames(), 2U);
    EXPECT_FLOAT_EQ(camera.capture().image.at(7, 5), 0.5F);
    EXPECT_FLOAT_EQ(camera.capture().image.at(0, 0), 0.6F);
  }
  options.rate = 4.0;
  {
    RecordedCamera camera(options);
    const double first = camera.capture().device_time;
    EXPECT_DOUBLE_EQ(camera.capture().device_time - first, 0.25) << "a recording without times has this rate";
  }
  raw.pop_back();
  write_file(options.path, raw);
  EXPECT_THAT([&] { RecordedCamera camera(options); },
              ThrowsMessage<FileError>(HasSubstr("191 bytes are no whole number of 8 x 6 frames")));
}

TEST_F(Recorded, RefusesListsThatLieOrLeaveTheFolder) {
  const auto parse = [](const char* text) { return parse_tum_list(text, "/data", "depth.txt"); };
  EXPECT_EQ(parse("1 a.png\n2  b.png\n").at(1).path, "/data/b.png");
  EXPECT_TRUE(parse("# nothing\n\n").empty());
  EXPECT_THAT([&] { parse("1 a.png\n1 b.png\n"); },
              ThrowsMessage<FileError>(HasSubstr("line 2: a time that does not rise")));
  for (const char* text : {"a.png\n", "x a.png\n", "nan a.png\n", "1e999 a.png\n", "1 ../a.png\n",
                           "1 /etc/passwd\n", "1 depth/../../a.png\n"})
    EXPECT_THROW((void)parse(text), FileError) << text;
}

TEST_F(Recorded, ReportsWhenThereIsNoRecording) {
  EXPECT_THROW(RecordedCamera{options}, FileError);
  write_file((folder / "depth.txt").string(), "# none\n");
  options.camera.depth_scale = 1000;
  EXPECT_THAT([&] { RecordedCamera camera(options); },
              ThrowsMessage<FileError>(HasSubstr("no depth frames")));
  options.format = "bag";
  EXPECT_THROW(RecordedCamera{options}, InvalidArgument);
  options.format = "auto";
  options.path = "/nonexistent";
  EXPECT_THROW(RecordedCamera{options}, FileError);
}

TEST_F(Recorded, AWrongScaleShowsInTheMedian) {
  write_tum(5000);
  options.camera.depth_scale = 100000;
  RecordedCamera camera(options);
  EXPECT_THAT([&] { (void)camera.capture(); }, ThrowsMessage<DeviceError>(HasSubstr("check depth_scale")));
}

}  // namespace
}  // namespace stonestack::hardware
