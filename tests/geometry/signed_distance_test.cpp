#include "geometry/signed_distance.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include "geometry/rough_stone.hpp"
#include "geometry/surface_tree.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::geometry {
namespace {

constexpr double kCell = 0.0015;
constexpr double kBand = 0.012;

TEST(SignedDistance, IsExactOverAFlatFace) {
  const SignedDistance field(make_box({0.1, 0.08, 0.06}), kCell, kBand);
  Random random = Random::stream(1, "signed distance");
  for (int i = 0; i < 1000; ++i) {
    const double height = random.uniform(-0.01, 0.01);
    Eigen::Vector3d gradient;
    const Eigen::Vector3d p(random.uniform(-0.03, 0.03), random.uniform(-0.02, 0.02), 0.03 + height);
    EXPECT_NEAR(field.distance(p, &gradient), height, 1e-8);
    EXPECT_LT((gradient - Eigen::Vector3d::UnitZ()).norm(), 1e-5);
  }
}

TEST(SignedDistance, IsClampedFarAwayOnTheRightSide) {
  const SignedDistance field(make_sphere(0.1, 4), kCell, kBand);
  Random random = Random::stream(2, "signed distance");
  for (int i = 0; i < 5000; ++i) {
    const double radius = random.uniform(0.0, 0.2);
    const double distance = field.distance(radius * random.unit_vector());
    EXPECT_NEAR(distance, std::clamp(radius - 0.1, -kBand, kBand), 5e-4);
    if (std::abs(radius - 0.1) > kBand + 2.0 * kCell) {
      EXPECT_EQ(std::abs(distance), field.band());
    }
  }
  Eigen::Vector3d gradient(1, 1, 1);
  EXPECT_EQ(field.distance({5, 5, 5}, &gradient), field.band());
  EXPECT_EQ(gradient, Eigen::Vector3d::Zero());
  EXPECT_EQ(field.distance({NAN, 0, 0}), field.band());
  EXPECT_EQ(field.distance({INFINITY, 0, 0}), field.band());
}

TEST(SignedDistance, GradientIsThatOfTheInterpolation) {
  const SignedDistance field(make_rough_stone(3), kCell, kBand);
  Random random = Random::stream(3, "signed distance");
  int checked = 0;
  for (const SurfaceSample& sample : sample_surface(make_rough_stone(3), 0.004)) {
    const Eigen::Vector3d p = sample.point + random.uniform(0.0, 0.004) * random.unit_vector();
    Eigen::Vector3d gradient;
    (void)field.distance(p, &gradient);
    constexpr double kStep = 1e-5;
    Eigen::Vector3d slope;
    bool same_cell = true;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d step = kStep * Eigen::Vector3d::Unit(k);
      slope[k] = field.distance(p + step) - field.distance(p - step);
      const double at = (p[k] - field.box().min()[k]) / kCell;
      same_cell = same_cell && std::abs(at - std::round(at)) > 0.01;
    }
    if (!same_cell) continue;
    EXPECT_LT((slope.normalized() - gradient).norm(), 1e-3);
    ++checked;
  }
  EXPECT_GT(checked, 1000);
}

struct Errors {
  double median, worst;
};

/// |interpolated - exact| at points within 1 mm of the surface.
Errors errors_near(const Mesh& mesh, std::uint64_t seed) {
  const SignedDistance field(mesh, kCell, kBand);
  const SurfaceTree tree(mesh);
  Random random = Random::stream(seed, "signed distance errors");
  std::vector<double> errors;
  for (const SurfaceSample& sample : sample_surface(mesh, 0.002)) {
    const Eigen::Vector3d p = sample.point + random.uniform(0.0, 0.001) * random.unit_vector();
    errors.push_back(std::abs(field.distance(p) - tree.nearest(p).distance));
  }
  std::sort(errors.begin(), errors.end());
  return {errors[errors.size() / 2], errors.back()};
}

TEST(SignedDistance, ErrorOnRoughStonesIsAFractionOfTheCell) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const Errors errors = errors_near(make_rough_stone(seed), seed);
    RecordProperty("median_um_" + std::to_string(seed), std::to_string(1e6 * errors.median));
    RecordProperty("worst_um_" + std::to_string(seed), std::to_string(1e6 * errors.worst));
    EXPECT_LT(errors.median, 0.02 * kCell) << "seed " << seed;
    EXPECT_LT(errors.worst, 0.4 * kCell) << "seed " << seed;
  }
}

TEST(SignedDistance, IsTheSameEveryTime) {
  const Mesh stone = make_rough_stone(5, 2);
  const SignedDistance one(stone, 0.003, 0.006);
  const SignedDistance two(stone, 0.003, 0.006);
  Random random = Random::stream(5, "signed distance");
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d p = 0.1 * random.uniform() * random.unit_vector();
    EXPECT_EQ(one.distance(p), two.distance(p));
  }
}

/// Bricks are filled by whoever asks first.
TEST(SignedDistance, DependsNeitherOnTheOrderOfQueriesNorOnThreads) {
  const Mesh stone = make_rough_stone(6, 2);
  Random random = Random::stream(6, "signed distance");
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 4000; ++i) points.emplace_back(0.1 * random.uniform() * random.unit_vector());
  const SignedDistance alone(stone, 0.003, 0.006), together(stone, 0.003, 0.006);
  std::vector<double> expected(points.size());
  for (std::size_t i = points.size(); i-- > 0;) expected[i] = alone.distance(points[i]);
  std::vector<std::vector<double>> found(4, std::vector<double>(points.size()));
  std::vector<std::thread> threads;
  for (std::vector<double>& own : found)
    threads.emplace_back([&] {
      for (std::size_t i = 0; i < points.size(); ++i) own[i] = together.distance(points[i]);
    });
  for (std::thread& thread : threads) thread.join();
  for (const std::vector<double>& own : found) EXPECT_EQ(own, expected);
}

TEST(SignedDistance, RefusesOpenMeshesAndGridsThatAreTooFine) {
  Mesh open = make_box({0.1, 0.1, 0.1});
  open.faces.pop_back();
  EXPECT_THROW(SignedDistance(open, kCell, kBand), InvalidArgument);
  EXPECT_THROW(SignedDistance(make_box({1, 1, 1}), 1e-3, 0.01), InvalidArgument);
  EXPECT_THROW(SignedDistance(make_box({1, 1, 1}), 1e-12, 0.01), InvalidArgument);
  EXPECT_THROW(SignedDistance(make_box({1, 1, 1}), -0.01, 0.01), InvalidArgument);
  EXPECT_THROW(SignedDistance(make_box({1, 1, 1}), 0.1, NAN), InvalidArgument);
}

}  // namespace
}  // namespace stonestack::geometry
