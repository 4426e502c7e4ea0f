#include "stonestack/geometry/depth_image.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace stonestack::geometry {
namespace {

/// A tilted plane with holes as a camera sees it.
Cloud view_of_plane(const CameraIntrinsics& camera) {
  DepthImage image{camera, std::vector<float>(static_cast<std::size_t>(camera.width * camera.height), 0.0F)};
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u)
      if ((u + v) % 7 != 0)
        image.z[static_cast<std::size_t>(v * camera.width + u)] =
            static_cast<float>(0.6 + 0.0005 * u + 0.0003 * v);
  return to_cloud(image);
}

TEST(FitCamera, RecoversIntrinsics) {
  CameraIntrinsics camera;
  camera.width = 160;
  camera.height = 120;
  camera.fx = 118.0;
  camera.fy = 121.0;
  camera.cx = 77.5;
  camera.cy = 61.25;
  const auto fitted = fit_camera(view_of_plane(camera));
  ASSERT_TRUE(fitted.has_value());
  EXPECT_NEAR(fitted->fx, 118.0, 0.05);
  EXPECT_NEAR(fitted->fy, 121.0, 0.05);
  EXPECT_NEAR(fitted->cx, 77.5, 0.05);
  EXPECT_NEAR(fitted->cy, 61.25, 0.05);
}

TEST(FitCamera, RefusesWhatIsNotACamerasCloud) {
  CameraIntrinsics camera;
  camera.width = 160;
  camera.height = 120;
  Cloud cloud = view_of_plane(camera);
  Cloud unorganised = without_gaps(cloud);
  EXPECT_FALSE(fit_camera(unorganised).has_value());
  Cloud turned = cloud;  // the same points in a frame that is not a camera's
  const Eigen::AngleAxisf turn(1.0F, Eigen::Vector3f::UnitX());
  for (auto& p : turned.points) p = turn * p;
  EXPECT_FALSE(fit_camera(turned).has_value());
  for (auto& p : cloud.points) p.setConstant(std::numeric_limits<float>::quiet_NaN());
  EXPECT_FALSE(fit_camera(cloud).has_value());
}

TEST(FitCamera, DistinguishesAMirroredCloudFromATurnedOne) {
  CameraIntrinsics camera;
  camera.width = 160;
  camera.height = 120;
  const Cloud cloud = view_of_plane(camera);
  const auto scaled = [&](float x, float y) {
    Cloud out = cloud;
    for (auto& p : out.points) p = Eigen::Vector3f(x * p.x(), y * p.y(), p.z());
    return out;
  };
  EXPECT_FALSE(is_mirrored(cloud));
  EXPECT_TRUE(is_mirrored(scaled(-1, 1)));
  EXPECT_TRUE(is_mirrored(scaled(1, -1)));
  EXPECT_FALSE(is_mirrored(scaled(-1, -1))) << "turned upside down";
  EXPECT_FALSE(is_mirrored(without_gaps(scaled(-1, 1)))) << "unobservable without rows";
}

TEST(CameraFor, TakesInAWideCloudAndFillsItsPixels) {
  const auto sheet = [](float half, float spacing) {
    Cloud cloud;
    for (float x = -half; x <= half; x += spacing)
      for (float y = -half; y <= half; y += spacing) cloud.points.emplace_back(x, y, 1.0F);
    return cloud;
  };
  EXPECT_EQ(camera_for(sheet(0.3F, 0.002F)).width, 640);
  EXPECT_EQ(camera_for(sheet(0.3F, 0.002F)).fx, 475.0);
  EXPECT_GT(camera_for(sheet(1.0F, 0.002F)).width, 900) << "seen whole";
  const CameraIntrinsics coarse = camera_for(sheet(0.3F, 0.006F));
  EXPECT_LT(coarse.fx * 0.006, 1.2) << "a pixel is about as wide as the points are apart";
  EXPECT_NEAR(coarse.width / coarse.fx, 640.0 / 475.0, 0.02);
  EXPECT_EQ(camera_for(Cloud{}).width, 640);
}

}  // namespace
}  // namespace stonestack::geometry
