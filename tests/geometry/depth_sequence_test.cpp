#include "geometry/depth_sequence.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>

#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"

namespace stonestack::geometry {
namespace {

/// Small recordings in the three layouts.
class DepthSequences : public ::testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder + "/depth"); }
  void TearDown() override { std::filesystem::remove_all(folder); }

  /// An 8 x 6 image whose counts are 1000 + pixel number.
  void write_picture(const std::string& name) const {
    CameraIntrinsics camera;
    camera.width = 8, camera.height = 6;
    DepthImage image{camera, {}};
    for (int i = 0; i < 48; ++i) image.z.push_back(static_cast<float>(0.001 * (1000 + i)));
    write_depth_png(folder + "/" + name, image, 0.001);
  }
  void write(const std::string& name, const std::string& text) const {
    write_file(folder + "/" + name, text);
  }
  [[nodiscard]] DepthSequence read(const DepthSequenceInput& input = {}) const {
    return read_depth_sequence(folder, input);
  }
  void expect_refused(const DepthSequenceInput& input, const std::string& word) const {
    try {
      (void)read(input);
      FAIL() << "should be refused: " << word;
    } catch (const FileError& error) {
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos) << error.what();
    }
  }
  const std::string folder =
      (std::filesystem::temp_directory_path() / ("depth_sequence_" + std::to_string(::getpid()))).string();
};

TEST_F(DepthSequences, BopHasItsScaleInMillimetresAndTheWorldInTheCamera) {
  write_picture("depth/000007.png");
  write("scene_camera.json",
        R"({"7": {"cam_K": [600, 0, 4, 0, 610, 3, 0, 0, 1], "depth_scale": 0.1,
                  "cam_R_w2c": [1, 0, 0, 0, -1, 0, 0, 0, -1], "cam_t_w2c": [0, 0, 800]}})");
  const DepthSequence sequence = read();
  EXPECT_EQ(sequence.layout, "bop");
  ASSERT_EQ(sequence.records.size(), 1U);
  const DepthRecord& record = sequence.records[0];
  EXPECT_EQ(record.number, 7);
  EXPECT_DOUBLE_EQ(record.unit, 0.0001);
  EXPECT_DOUBLE_EQ(record.camera.fy, 610);
  EXPECT_DOUBLE_EQ(record.camera.cx, 4);
  ASSERT_TRUE(record.T_W_C.has_value());
  EXPECT_NEAR(record.T_W_C->translation().z(), 0.8, 1e-12);  // 0.8 m above the world's origin, looking down
  EXPECT_NEAR((record.T_W_C->linear() * Eigen::Vector3d::UnitZ()).z(), -1.0, 1e-12);
  const DepthImage image = read_depth(record);
  EXPECT_EQ(image.camera.width, 8);
  EXPECT_NEAR(image.at(3, 2), 0.0001 * (1000 + 19), 1e-7);
  write("scene_camera.json",  // a shear, whose determinant is that of a rotation
        R"({"7": {"cam_K": [600, 0, 4, 0, 610, 3, 0, 0, 1], "depth_scale": 0.1,
                  "cam_R_w2c": [1, 0.5, 0, 0, 1, 0, 0, 0, 1], "cam_t_w2c": [0, 0, 800]}})");
  expect_refused({}, "cam_R_w2c is not a rotation");
}

TEST_F(DepthSequences, Open3dIsColumnByColumnAndItsScaleIsNeverGuessed) {
  write_picture("depth/00000.png");
  write_picture("depth/00001.png");
  const std::string matrix = R"("intrinsic_matrix": [615, 0, 0, 0, 616, 0, 4.5, 3.5, 1])";
  write("camera_intrinsic.json", R"({"width": 8, "height": 6, )" + matrix + "}");
  expect_refused({}, "--depth-unit");
  DepthSequenceInput input;
  input.unit = 0.001;
  const DepthSequence sequence = read(input);
  EXPECT_EQ(sequence.layout, "open3d");
  ASSERT_EQ(sequence.records.size(), 2U);
  EXPECT_DOUBLE_EQ(sequence.records[0].camera.cx, 4.5);
  EXPECT_DOUBLE_EQ(sequence.records[0].camera.fy, 616);
  EXPECT_NEAR(read_depth(sequence.records[1]).at(0, 0), 1.0, 1e-6);
  write("camera_intrinsic.json", R"({"depth_scale": 5000.0, )" + matrix + "}");
  EXPECT_DOUBLE_EQ(read().records[0].unit, 0.0002);
  expect_refused(input, "was given");  // 0.0002 in the file, 0.001 given: a factor of five
}

TEST_F(DepthSequences, IntrinsicsOfAnotherImageAreRefused) {
  write_picture("depth/00000.png");
  const auto with = [&](const std::string& size, const std::string& matrix) {
    write("camera_intrinsic.json",
          "{" + size + R"("depth_scale": 1000, "intrinsic_matrix": )" + matrix + "}");
  };
  const std::string good = "[7, 0, 0, 0, 7, 0, 4, 3, 1]";
  with("", good);
  EXPECT_EQ(read().records.size(), 1U);
  with(R"("width": 640, "height": 480, )", good);
  expect_refused({}, "640 x 480");
  with("", "[7, 0, 4, 0, 7, 3, 0, 0, 1]");
  expect_refused({}, "by columns");
  with("", "[7, 0, 0, 0, 7, 0, 0, 0, 1]");
  expect_refused({}, "by columns");
  with("", "[7, 0, 0, 0, 7, 0, 319.5, 239.5, 1]");
  expect_refused({}, "319.5, 239.5 in an image of 8 x 6");
  DepthSequenceInput given;
  given.camera = CameraIntrinsics{};
  EXPECT_EQ(read(given).records.size(), 1U) << "the caller knows better";
}

TEST_F(DepthSequences, TumMatchesPosesByTimeAndNeedsCameraAndScale) {
  write_picture("depth/a.png");
  write_picture("depth/b.png");
  write("depth.txt", "# depth maps\n10.000 depth/a.png\n10.500 depth/b.png\n");
  write("groundtruth.txt",
        "# time tx ty tz qx qy qz qw\n9.995 1 2 3 0 0 0 1\n10.005 1.1 2 3 0 0 0 1\n10.4 9 9 9 0 0 0 1\n");
  DepthSequenceInput input;
  expect_refused(input, "--camera");
  input.camera = CameraIntrinsics{};
  expect_refused(input, "--depth-unit");
  input.unit = 0.0002;
  const DepthSequence sequence = read(input);
  ASSERT_EQ(sequence.records.size(), 2U);
  EXPECT_DOUBLE_EQ(sequence.records[0].time, 10.0);
  ASSERT_TRUE(sequence.records[0].T_W_C.has_value());
  EXPECT_NEAR(sequence.records[0].T_W_C->translation().y(), 2.0, 1e-12);
  EXPECT_FALSE(sequence.records[1].T_W_C.has_value()) << "100 ms is too far";
  EXPECT_NEAR(read_depth(sequence.records[0]).at(1, 0), 0.0002 * 1001, 1e-7);
  write("depth.txt", "10.0 ../../etc/passwd\n");
  expect_refused(input, "inside the folder");
}

TEST_F(DepthSequences, BadFilesAreRefusedByName) {
  expect_refused({}, "no folder of depth images");
  write("scene_camera.json", "{\"1\": {\"cam_K\": [1, 2, 3]");
  expect_refused({}, "not JSON");
  write("scene_camera.json", R"({"1": {"cam_K": [600, 0, 4, 0, 610, 3, 0, 0, 1]}})");
  expect_refused({}, "depth_scale");
  write("scene_camera.json", R"({"1": {"cam_K": [600, 0, 4, 0], "depth_scale": 1}})");
  expect_refused({}, "cam_K");
  write("scene_camera.json", R"({"../x": {"cam_K": [600, 0, 4, 0, 610, 3, 0, 0, 1], "depth_scale": 1}})");
  expect_refused({}, "../x");
  write("scene_camera.json", R"({"1": {"cam_K": [600, 0, 4, 0, 610, 3, 0, 0, 1], "depth_scale": 1}})");
  expect_refused({}, "000001.png");
}

}  // namespace
}  // namespace stonestack::geometry
