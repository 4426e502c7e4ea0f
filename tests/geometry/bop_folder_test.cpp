#include "geometry/bop_folder.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "temporary_folder.hpp"

namespace stonestack::geometry {
namespace {

using Distortion = CameraIntrinsics::Distortion;
using nlohmann::json;

class BopFolders : public ::testing::Test {
 protected:
  void SetUp() override { std::filesystem::remove_all(folder); }
  void TearDown() override { std::filesystem::remove_all(folder); }

  /// An 8 x 6 image, 0.125 mm a count; a hole at pixel 5.
  [[nodiscard]] static DepthImage picture(int first) {
    CameraIntrinsics camera;
    camera.width = 8, camera.height = 6;
    camera.fx = 600, camera.fy = 610, camera.cx = 4, camera.cy = 3;
    DepthImage image{camera, {}};
    for (int i = 0; i < 48; ++i)
      image.z.push_back(i == 5 ? 0.0F : static_cast<float>(0.000125 * (first + i)));
    return image;
  }
  [[nodiscard]] json scene_camera() const {
    return json::parse(read_file(folder + "/scene_camera.json", 1 << 20));
  }
  const std::string folder = test::temporary_folder() + "bop_folder_" +
                             testing::UnitTest::GetInstance()->current_test_info()->name();
};

TEST_F(BopFolders, WritesBopsKeysInBopsUnits) {
  Pose T_W_C = Pose::Identity();  // 0.8 m above (0.7, -0.2), looking down, x of the image along x of W
  T_W_C.linear() = Eigen::Vector3d(1, -1, -1).asDiagonal();
  T_W_C.translation() = Eigen::Vector3d(0.7, -0.2, 0.8);
  BopFolder images(folder);
  images.add(picture(4000), 12.5, T_W_C);
  images.add(picture(4100), 13.0, std::nullopt);
  const json all = scene_camera();
  ASSERT_EQ(all.size(), 2U);
  const json& first = all["0"];
  EXPECT_EQ(first["cam_K"], json({600.0, 0.0, 4.0, 0.0, 610.0, 3.0, 0.0, 0.0, 1.0}));
  EXPECT_NEAR(first["depth_scale"].get<double>(), 0.125, 1e-12) << "mm a count";
  EXPECT_EQ(first["cam_R_w2c"], json({1.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.0, 0.0, -1.0}));
  const auto t = first["cam_t_w2c"].get<std::vector<double>>();  // -R p, mm
  EXPECT_NEAR(t[0], -700.0, 1e-9);
  EXPECT_NEAR(t[1], -200.0, 1e-9);
  EXPECT_NEAR(t[2], 800.0, 1e-9);
  EXPECT_FALSE(first.contains("distortion"));
  EXPECT_FALSE(all["1"].contains("cam_R_w2c")) << "its pose is not known";
  EXPECT_TRUE(std::filesystem::exists(folder + "/depth/000001.png"));
}

TEST_F(BopFolders, IsReadBackExactly) {
  DepthImage bent = picture(5000);
  bent.camera.distortion = Distortion::kInverseBrownConrady;
  const double k[5] = {0.12, -0.3, 0.001, -0.002, 0.05};
  std::copy(std::begin(k), std::end(k), bent.camera.k);
  const Pose T_W_C = make_pose({0.1, 0.2, 0.9}, Eigen::Quaterniond(0.1, 0.9, 0.2, -0.3).normalized());
  BopFolder images(folder);
  images.add(bent, 100.25, T_W_C);
  EXPECT_EQ(read_depth_sequence(folder).records.size(), 1U) << "it can be read after each image";
  images.add(picture(6000), 100.5, std::nullopt);
  const DepthSequence sequence = read_depth_sequence(folder);
  EXPECT_EQ(sequence.layout, "bop");
  ASSERT_EQ(sequence.records.size(), 2U);
  const DepthRecord& record = sequence.records[0];
  EXPECT_EQ(record.time, 100.25);
  EXPECT_EQ(record.camera.distortion, Distortion::kInverseBrownConrady);
  EXPECT_TRUE(std::equal(std::begin(k), std::end(k), record.camera.k));
  ASSERT_TRUE(record.T_W_C);
  EXPECT_TRUE(record.T_W_C->isApprox(T_W_C, 1e-12));
  EXPECT_EQ(read_depth(record).z, bent.z) << "every count";
  EXPECT_EQ(sequence.records[1].camera.distortion, Distortion::kNone);
  EXPECT_EQ(read_depth(sequence.records[1]).z, picture(6000).z);
}

TEST_F(BopFolders, AnImageThatCannotBeWrittenIsNotNamed) {
  BopFolder images(folder);
  images.add(picture(4000), 1.0, std::nullopt);
  std::filesystem::create_directories(folder + "/depth/000001.png");  // no picture can take its place
  EXPECT_THROW(images.add(picture(4000), 2.0, std::nullopt), FileError);
  EXPECT_EQ(scene_camera().size(), 1U);
  EXPECT_EQ(images.records().size(), 1U);
}

TEST_F(BopFolders, ALensThatNobodyKnowsIsRefused) {
  BopFolder images(folder);
  images.add(picture(4000), 1.0, std::nullopt);
  json all = scene_camera();
  const auto problem = [&] {
    write_file(folder + "/scene_camera.json", all.dump());
    try {
      (void)read_depth_sequence(folder);
    } catch (const FileError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  all["0"]["distortion"] = "fisheye";
  EXPECT_NE(problem().find("distortion is \"fisheye\""), std::string::npos) << problem();
  all["0"]["distortion"] = "brown_conrady";
  EXPECT_NE(problem().find("k is missing"), std::string::npos) << problem();
  all["0"]["k"] = {0, 0, 0, 0, 0};
  EXPECT_EQ(problem(), "");
}

}  // namespace
}  // namespace stonestack::geometry
