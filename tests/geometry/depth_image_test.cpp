#include "stonestack/geometry/depth_image.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/random.hpp"
#include "temporary_folder.hpp"

namespace stonestack::geometry {
namespace {

using ::testing::HasSubstr;
using Distortion = CameraIntrinsics::Distortion;

CameraIntrinsics lens(Distortion distortion) {
  CameraIntrinsics camera;
  camera.distortion = distortion;
  const double k[5] = {-0.11, 0.06, 0.002, -0.001, -0.01};
  std::copy(k, k + 5, camera.k);
  return camera;
}

CameraIntrinsics small_camera() {
  CameraIntrinsics camera;
  camera.width = 8;
  camera.height = 6;
  camera.fx = camera.fy = 6.0;
  camera.cx = 3.5;
  camera.cy = 2.5;
  return camera;
}

TEST(DepthImage, PinholeRays) {
  const CameraIntrinsics camera;
  EXPECT_LT((deproject(camera, 319.5 + 475, 239.5) - Eigen::Vector3d(1, 0, 1)).norm(), 1e-15);
  EXPECT_LT((project(camera, {0, 2, 4}) - Eigen::Vector2d(319.5, 239.5 + 237.5)).norm(), 1e-12);
  EXPECT_THROW((void)project(camera, {0, 0, -1}), InvalidArgument);
}

TEST(DepthImage, ProjectUndoesDeprojectForEveryLens) {
  Random random = Random::stream(1, "lens");
  for (const Distortion distortion :
       {Distortion::kNone, Distortion::kBrownConrady, Distortion::kInverseBrownConrady}) {
    const CameraIntrinsics camera = lens(distortion);
    for (int i = 0; i < 500; ++i) {
      const Eigen::Vector2d pixel(random.uniform(0, 640), random.uniform(0, 480));
      const Eigen::Vector3d ray = deproject(camera, pixel.x(), pixel.y());
      EXPECT_LT((project(camera, random.uniform(0.1, 3.0) * ray) - pixel).norm(), 1e-8);
    }
  }
}

TEST(DepthImage, BrownConradyDistortsFromRayToPixel) {
  CameraIntrinsics camera;
  camera.k[0] = 0.1;  // r^2 = 0.25: 2.5 % further out
  camera.distortion = Distortion::kBrownConrady;
  EXPECT_NEAR(project(camera, {0.5, 0, 1}).x(), 319.5 + 475 * 0.5 * 1.025, 1e-9);
  camera.distortion = Distortion::kInverseBrownConrady;
  EXPECT_NEAR(deproject(camera, 319.5 + 475 * 0.5, 239.5).x(), 0.5 * 1.025, 1e-12);
}

TEST(DepthImage, CloudAndBack) {
  DepthImage image{small_camera(), std::vector<float>(48, 0.0F)};
  for (std::size_t i = 0; i < image.z.size(); ++i)
    image.z[i] = i % 5 == 0 ? 0.0F : 0.5F + 0.01F * static_cast<float>(i);
  const Cloud cloud = to_cloud(image);
  EXPECT_EQ(cloud.width, 8);
  EXPECT_EQ(cloud.height, 6);
  EXPECT_TRUE(std::isnan(cloud.points[0].z()));
  const DepthImage again = to_depth_image(cloud, image.camera);
  EXPECT_EQ(again.z, image.z);
}

TEST(DepthImage, NearestPointWinsAndOutsideIsDropped) {
  Cloud cloud;
  cloud.points = {{0, 0, 2}, {0, 0, 1}, {0, 0, 3}, {1e30F, 0, 1}, {0, 0, -1}, {NAN, 0, 1}};
  const DepthImage image = to_depth_image(cloud, small_camera());
  EXPECT_EQ(image.at(4, 3), 1.0F);
  EXPECT_EQ(std::count(image.z.begin(), image.z.end(), 0.0F), 47);
}

TEST(DepthImage, SizesMustMatch) {
  EXPECT_THROW((void)to_cloud({small_camera(), std::vector<float>(47)}), InvalidArgument);
  CameraIntrinsics camera;
  camera.width = -3;
  EXPECT_THROW((void)to_depth_image({}, camera), InvalidArgument);
  camera = CameraIntrinsics{};
  camera.fx = 0;
  EXPECT_THROW((void)to_depth_image({}, camera), InvalidArgument);
}

class DepthPng : public testing::Test {
 protected:
  void SetUp() override {
    image_.z[7] = 1.2345F;
    image_.z[9] = 9.0F;  // more than 65535 counts of 0.125 mm
    write_depth_png(path_, image_, 0.000125);
  }
  void TearDown() override { std::filesystem::remove(path_); }

  std::string problem(const CameraIntrinsics& camera) const {
    try {
      (void)read_depth_png(path_, camera, 0.001);
    } catch (const FileError& error) {
      return error.what();
    }
    return "";
  }

  std::string path_ = test::temporary_folder() + "depth_png_test.png";
  DepthImage image_{small_camera(), std::vector<float>(48, 0.5F)};
};

TEST_F(DepthPng, RoundTripsToHalfAUnit) {
  const DepthImage again = read_depth_png(path_, image_.camera, 0.000125);
  EXPECT_EQ(again.z[0], 0.5F);
  EXPECT_NEAR(again.z[7], 1.2345, 0.0000626);
  EXPECT_EQ(again.z[9], 0.0F) << "beyond the range is no depth";
}

TEST_F(DepthPng, RefusesAnotherSize) {
  CameraIntrinsics camera = small_camera();
  camera.width = 9;
  EXPECT_THAT(problem(camera), HasSubstr("8 x 6, but the camera has 9 x 6"));
}

TEST_F(DepthPng, RefusesOtherPixelFormats) {
  std::string bytes = read_file(path_, 10000);
  bytes[24] = 8;  // bit depth; the checksum of the header is now wrong as well
  write_file(path_, bytes);
  EXPECT_THAT(problem(small_camera()), HasSubstr("not a depth image"));
}

TEST_F(DepthPng, SurvivesEveryTruncationAndManyMutations) {
  const std::string whole = read_file(path_, 10000);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    write_file(path_, whole.substr(0, size));
    EXPECT_NE(problem(small_camera()), "") << "cut to " << size;
  }
  Random random = Random::stream(2, "png");
  for (int i = 0; i < 300; ++i) {
    std::string bytes = whole;
    for (std::size_t n = 1 + random.index(3); n > 0; --n)
      bytes[random.index(bytes.size())] = static_cast<char>(random.index(256));
    write_file(path_, bytes);
    (void)problem(small_camera());
  }
}

}  // namespace
}  // namespace stonestack::geometry
