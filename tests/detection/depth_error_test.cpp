// The smooth error of a depth image: read off the table, and what that is worth for a stone.
#include "detection/scene/depth_error.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include <cmath>

#include "detection/hypotheses/joint_refine.hpp"
#include "detection/scene/preprocess.hpp"
#include "detection/test_scene.hpp"

namespace stonestack::detection {
namespace {

/// Depth error at a pixel [m]; standard deviation 0.5 mm.
double bias_at(int u, int v) {
  return 0.001 * std::sin(0.055 * u + 0.4) * std::cos(0.06 * v - 0.7);
}

DepthImage with_bias(DepthImage image) {
  for (int v = 0; v < image.camera.height; ++v)
    for (int u = 0; u < image.camera.width; ++u)
      if (float& z = image.z[static_cast<std::size_t>(v * image.camera.width + u)]; z > 0)
        z += static_cast<float>(bias_at(u, v));
  return image;
}

TEST(DepthError, IsReadOffTheTable) {
  const Pose T_W_C = test::make_camera_pose(0.4, 0.3);
  const DetectionScene scene =
      preprocess(test::with_noise(with_bias(test::look_at({}, T_W_C)), 0.0005, 1), {}, true, {});
  ASSERT_EQ(scene.views.size(), 1U);
  const DepthError& error = scene.views[0].error;
  EXPECT_NEAR(error.sigma, 0.0005, 0.0002);
  EXPECT_GT(error.length, 8);
  EXPECT_LT(error.length, 60);
  double squares = 0;
  int cells = 0;
  for (int row = 1; row + 1 < error.rows; ++row)
    for (int column = 1; column + 1 < error.columns; ++column) {
      const auto i = static_cast<std::size_t>(row * error.columns + column);
      if (error.count[i] < error.cell * error.cell / 2) continue;
      double mean = 0;
      for (int k = 0; k < error.cell * error.cell; ++k)
        mean += bias_at(error.cell * column + k % error.cell, error.cell * row + k / error.cell);
      squares += std::pow(error.offset[i] - mean / (error.cell * error.cell), 2);
      ++cells;
    }
  ASSERT_GT(cells, 1000);
  EXPECT_LT(std::sqrt(squares / cells), 0.00015) << "of 0.5 mm";
}

TEST(DepthError, APerfectTableHasNone) {
  const DetectionScene scene = preprocess(test::look_at({}, test::make_camera_pose(0.4, 0.3)), {}, true, {});
  EXPECT_LT(scene.views.at(0).error.sigma, 0.00005);
}

TEST(DepthError, WithoutATableItIsAssumed) {
  DetectionOptions options;
  options.bias_sigma = 0.0007;
  const DepthError error = assumed_depth_error({}, options);
  EXPECT_EQ(error.sigma, 0.0007);
  EXPECT_EQ(error.offset.size(), static_cast<std::size_t>(error.columns * error.rows));
}

TEST(JointRefine, TheTableBesideAStoneCorrectsItsPose) {
  const std::vector<Stone> stones{test::make_test_stone(2)};
  const DetectionModels models(stones);
  double with = 0, without = 0;
  for (int number = 0; number < 6; ++number) {
    Random random = Random::stream(static_cast<std::uint64_t>(number), "depth error");
    const Pose T_W_C = test::make_camera_pose(random.uniform(0.1, 0.8), random.uniform(0, 6.28));
    const Pose T_W_O =
        test::on_table(stones[0], random.rotation(), random.uniform(-0.1, 0.1), random.uniform(-0.1, 0.1));
    const Pose T_C_O = T_W_C.inverse() * T_W_O;
    DetectionScene scene = preprocess(with_bias(test::look_at({{&stones[0], T_W_O}}, T_W_C)), {}, true, {});
    Detection start;
    start.stone = 0_stone;
    start.T_C_O = make_pose({0.0005, -0.0005, 0.0005}) * T_C_O;
    const auto error = [&] {
      return difference(refined_together({start}, models.data(), scene).front().T_C_O, T_C_O).angle;
    };
    with += error();
    DetectionOptions none;
    none.bias_sigma = 1e-6;
    scene.views[0].error = assumed_depth_error(scene.views[0].depth.camera, none);
    without += error();
  }
  EXPECT_LT(with, 0.6 * without) << "rad, sum over scenes";
}

TEST(JointRefine, APoseThatRunsAwayStaysAsItCameAndIsUncertain) {
  Stone plate;
  plate.name = "plate";
  plate.mesh = plate.scan = make_box({0.04, 0.04, 0.03});
  const DetectionModels models(std::vector<Stone>{plate});
  const Pose T_W_C = test::make_camera_pose(0.0, 0.0, 0.5), T_W_O = make_pose({0, 0, 0.015});
  const DetectionScene scene = preprocess(test::look_at({{&plate, T_W_O}}, T_W_C), {}, true, {});
  Detection turned;  // about a line across the face: all that is seen lies within 6 mm, and turns it back
  turned.stone = 0_stone;
  const Pose lifted = make_pose({0, 0, 0.015});
  turned.T_C_O = T_W_C.inverse() * T_W_O * lifted * Pose(Eigen::AngleAxisd(0.29, Eigen::Vector3d::UnitX())) *
                 lifted.inverse();
  const Detection kept = refined_together({turned}, models.data(), scene).front();
  EXPECT_EQ(kept.T_C_O.matrix(), turned.T_C_O.matrix()) << "the trap is gone: it does not run away";
  EXPECT_GT(kept.covariance.trace(), 0.0);
  Eigen::Matrix<double, 6, 1> off;
  const Pose truth = T_W_C.inverse() * T_W_O;
  const Eigen::AngleAxisd turn(truth.linear() * kept.T_C_O.linear().transpose());
  off << truth.translation() - kept.T_C_O.translation(), turn.angle() * turn.axis();
  EXPECT_LT(off.dot(kept.covariance.ldlt().solve(off)), 12.6) << "beyond 95 %";  // chi^2, six degrees
}

}  // namespace
}  // namespace stonestack::detection
