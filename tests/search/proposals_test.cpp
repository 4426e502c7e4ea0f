#include "search/proposals.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "search/orientations.hpp"
#include "search_scenes.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::search {
namespace {

Mesh rough_stone(std::uint64_t seed, const Eigen::Vector3d& size) {
  Mesh mesh = make_sphere(1.0, 3);
  Random random = Random::stream(seed, "rough stone");
  for (Eigen::Vector3d& v : mesh.vertices) {
    const double flat = 0.62 / std::max({std::abs(v.x()), std::abs(v.y()), std::abs(v.z()), 0.62});
    v = (v * flat * random.uniform(0.99, 1.01)).cwiseProduct(size);
  }
  return mesh;
}

TEST(Orientations, KeepToTheTiltLimit) {
  OrientationOptions options;
  options.max_tilt = 0.7;
  options.up_O = Eigen::Vector3d(1, 2, -3).normalized();
  const auto list = orientations(options);
  EXPECT_GT(list.size(), 80U);
  for (const Eigen::Matrix3d& R_W_O : list) {
    EXPECT_NEAR(R_W_O.determinant(), 1.0, 1e-9);
    const Eigen::Vector3d up_O = R_W_O.transpose() * Eigen::Vector3d::UnitZ();
    EXPECT_LE(std::acos(std::clamp(up_O.dot(options.up_O), -1.0, 1.0)), options.max_tilt + 1e-9);
  }
  EXPECT_EQ(orientations({}).size(), 160U);
}

std::vector<Proposal> proposals_with(int threads) {
  static const StoneGeometry base = geometry_of(rough_stone(1, {0.11, 0.10, 0.07}), 2.0);
  static const StoneGeometry upper = geometry_of(rough_stone(2, {0.09, 0.08, 0.06}), 1.0);
  const std::vector<BodyPose> stack = {at(base, 0, 0, 0.62 * 0.07)};
  SearchOptions options;
  options.threads = threads;
  options.directions = 40;
  options.yaws = 3;
  options.grid = 0.004;
  options.placement_sigma_translation = 0.001;
  OrientationOptions which;
  which.directions = options.directions;
  const std::vector<LooseStone> loose = {{1_stone, &upper, orientations(which), 0.0, nullptr}};
  Proposals found = propose({stack, {}}, loose, {0, 0}, 6, options);
  EXPECT_GT(found.evaluated, 1000);
  return found.list;
}

TEST(Proposals, HoldAndLieOnTop) {
  const auto list = proposals_with(2);
  ASSERT_GE(list.size(), 2U);
  for (const Proposal& p : list) {
    EXPECT_EQ(p.stone, 1_stone);
    EXPECT_TRUE(p.landing.holds);
    EXPECT_GT(p.landing.margin, 0.005);
    EXPECT_GT(p.body.p_W_M.z(), 2 * 0.62 * 0.065);
    EXPECT_LT(std::hypot(p.landing.a, p.landing.b), 0.05);
    EXPECT_LE(p.robust, 0.15);
  }
}

TEST(Proposals, SameForAnyNumberOfThreads) {
  const auto one = proposals_with(1), two = proposals_with(2), four = proposals_with(4);
  ASSERT_EQ(one.size(), two.size());
  ASSERT_EQ(one.size(), four.size());
  for (std::size_t k = 0; k < one.size(); ++k) {
    EXPECT_TRUE(one[k].body.p_W_M == two[k].body.p_W_M && one[k].body.p_W_M == four[k].body.p_W_M);
    EXPECT_TRUE(one[k].body.R_W_O == two[k].body.R_W_O && one[k].body.R_W_O == four[k].body.R_W_O);
    EXPECT_EQ(one[k].robust, four[k].robust);
  }
}

TEST(Proposals, FirstStoneGoesToTheSite) {
  const StoneGeometry stone = geometry_of(rough_stone(3, {0.10, 0.08, 0.05}), 1.0);
  OrientationOptions which;
  const std::vector<LooseStone> loose = {{0_stone, &stone, orientations(which), 0.0, nullptr}};
  const auto list = propose({}, loose, {0.3, -0.2}, 6, {}).list;
  ASSERT_FALSE(list.empty());
  for (const Proposal& p : list)
    EXPECT_LT((p.body.p_W_M.head<2>() - Eigen::Vector2d(0.3, -0.2)).norm(), 1e-9);
  EXPECT_NEAR(list[0].robust, 0.1, 0.02);
}

}  // namespace
}  // namespace stonestack::search
