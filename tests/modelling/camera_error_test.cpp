#include "modelling/camera_error.hpp"

#include <gtest/gtest.h>

#include "core/quantile.hpp"
#include "seen_things.hpp"

namespace stonestack::modelling {
namespace {

using namespace test;

/// A smooth depth error: waves of 100 to 170 px, 0.7 mm high; `kind` tells one from another.
double planted(double u, double v, int kind = 0) {
  return 0.0007 * std::sin(u / (17.0 + 2.0 * kind)) * std::cos(v / (22.0 - 1.5 * kind));
}

/// Views of one camera, or of as many as there are views.
std::vector<DepthView> with_error(std::vector<DepthView> views, bool of_one_camera = true) {
  for (std::size_t k = 0; k < views.size(); ++k) {
    DepthImage& image = views[k].image;
    const int kind = of_one_camera ? 0 : static_cast<int>(k);
    for (int v = 0; v < image.camera.height; ++v)
      for (int u = 0; u < image.camera.width; ++u)
        if (float& z = image.z[static_cast<std::size_t>(v * image.camera.width + u)]; z > 0)
          z += static_cast<float>(planted(u, v, kind));
  }
  return views;
}

std::vector<Thing> stones_about() {
  return {lying_stone(3, 0.02, 0.0), lying_stone(4, 0.16, 0.1, 1.0), lying_stone(5, -0.14, 0.08, 2.0)};
}

/// Median distance of two errors over the middle of the image [m].
double apart(const CameraError& found) {
  std::vector<double> off;
  for (int v = 60; v < 420; v += 7)
    for (int u = 60; u < 580; u += 7) off.push_back(std::abs(found.at(u, v) - planted(u, v)));
  return quantile(off, 0.5);
}

TEST(CameraError, IsFoundWhereAllViewsShareIt) {
  const auto views = with_error(views_of(stones_about(), cameras_around(4)));
  const CameraError error = measure_camera_error(views);
  EXPECT_NEAR(error.sigma, 0.00035, 0.00007);  // 0.7 mm / 2: a sine times a cosine
  EXPECT_LT(apart(error), 0.00010);
  EXPECT_GT(apart({}), 0.00020);
}

TEST(CameraError, IsCarriedToPixelsThatShowNoTable) {
  auto views = with_error(views_of({}, cameras_around(4)));
  for (DepthView& view :
       views)  // a stone at the same place of each image, about as wide as the error is alike
    for (int v = 230; v < 256; ++v)
      for (int u = 300; u < 326; ++u) view.image.z[static_cast<std::size_t>(v * 640 + u)] = 0.0F;
  const CameraError error = measure_camera_error(views);
  for (int u = 302; u < 326; u += 4) EXPECT_NEAR(error.at(u, 243), planted(u, 243), 0.00030) << u;
}

TEST(CameraError, OfOneViewAloneIsNotTakenForTheCameras) {
  const auto views = with_error(views_of(stones_about(), cameras_around(6)), false);
  const CameraError error = measure_camera_error(views);
  double most = 0.0;
  for (const double offset : error.offset) most = std::max(most, std::abs(offset));
  EXPECT_LT(error.sigma, 0.00015);
  EXPECT_LT(most, 0.00025);
}

TEST(CameraError, ExactCameraHasHardlyAny) {
  const CameraError error = measure_camera_error(views_of(stones_about(), cameras_around(4)));
  double most = 0.0;
  for (const double offset : error.offset) most = std::max(most, std::abs(offset));
  EXPECT_LT(most, 0.00010);
}

TEST(CameraError, TakesTwoViewsOfOneSize) {
  auto views = with_error(views_of({}, cameras_around(2)));
  EXPECT_FALSE(measure_camera_error(views).offset.empty());
  EXPECT_TRUE(measure_camera_error({views.data(), 1}).offset.empty());
  EXPECT_TRUE(measure_camera_error({}).offset.empty());
  CameraIntrinsics small;
  small.width = 320;
  views[1].image = {small, std::vector<float>(320 * 480, 0.6F)};
  EXPECT_TRUE(measure_camera_error(views).offset.empty());
}

TEST(CameraError, ViewsFromOnePoseDoNotTellItFromAnUnevenTable) {
  const Pose camera = cameras_around(1).front();
  EXPECT_TRUE(measure_camera_error(with_error(views_of({}, {camera, camera, camera}))).offset.empty());
}

TEST(CameraError, PixelsWithoutDepthKeepNone) {
  auto views = with_error(views_of({}, cameras_around(2)));
  views[0].image.z[100] = 0.0F;
  EXPECT_EQ(without_error(views[0].image, measure_camera_error(views)).z[100], 0.0F);
}

TEST(CameraError, ViewsOfASceneAreFreeOfIt) {
  const auto exact = views_of(stones_about(), cameras_around(4), 0.0);
  const AlignedScene scene = align_scene(with_error(exact));
  std::vector<double> off;
  for (int v = 60; v < 420; v += 3)
    for (int u = 60; u < 580; u += 3) {
      const float z = exact[0].image.at(u, v);
      if (z > 0) off.push_back(std::abs(scene.views[0].image.at(u, v) - z));
    }
  EXPECT_LT(quantile(off, 0.5), 0.00010);
}

}  // namespace
}  // namespace stonestack::modelling
