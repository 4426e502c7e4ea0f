#include "stone/symmetry.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "stone/geodesic.hpp"
#include "stone/reduce_mesh.hpp"
#include "stone/stone_yaml.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/stone/catalogue.hpp"
#include "stonestack/stone/model_stone.hpp"
#include "temporary_folder.hpp"

namespace stonestack::stone {
namespace {

/// A sphere pressed into another shape.
template <class Press>
Mesh pressed(const Press& press) {
  Mesh mesh = make_geodesic(16);
  for (auto& v : mesh.vertices) v = press(v);
  return mesh;
}

/// A round body about z, thicker below.
Mesh egg() {
  return pressed([](const Eigen::Vector3d& v) {
    return Eigen::Vector3d(0.04 * v.x() * (1.0 - 0.35 * v.z()), 0.04 * v.y() * (1.0 - 0.35 * v.z()),
                           0.06 * v.z());
  });
}

/// A body that a third of a turn about z leaves as it is.
Mesh three_lobes() {
  return pressed([](const Eigen::Vector3d& v) {
    const double r = 0.05 * (1.0 + 0.2 * std::cos(3.0 * std::atan2(v.y(), v.x())) * std::hypot(v.x(), v.y()));
    return Eigen::Vector3d(r * v.x(), r * v.y(), 0.05 * (1.0 + 0.3 * v.z()) * v.z());
  });
}

TEST(Symmetry, OfACuboidAreThreeHalfTurnsAndThreePlanes) {
  const Symmetries found = find_symmetries(make_box({0.06, 0.09, 0.14}));
  EXPECT_EQ(found.axes.size(), 3U);
  for (const auto& axis : found.axes) EXPECT_EQ(axis.order, 2);
  EXPECT_EQ(found.planes.size(), 3U);
  EXPECT_EQ(discrete_turns(found).size(), 3U);
}

TEST(Symmetry, OfACubeAreItsTwentyThreeTurns) {
  const Symmetries found = find_symmetries(make_box({0.08, 0.08, 0.08}));
  EXPECT_EQ(std::count_if(found.axes.begin(), found.axes.end(), [](const auto& a) { return a.order == 4; }),
            3);
  EXPECT_EQ(discrete_turns(found).size(), 23U);
  EXPECT_EQ(found.planes.size(), 9U);
}

TEST(Symmetry, OfAnEggIsItsAxisWhereverItLies) {
  const Pose T = make_pose({0.03, -0.02, 0.01}, Eigen::Quaterniond(0.8, 0.1, -0.5, 0.3).normalized());
  const Symmetries found = find_symmetries(transformed(reduce_mesh(egg(), 500), T));
  ASSERT_EQ(found.axes.size(), 1U);
  EXPECT_EQ(found.axes[0].order, 0);
  EXPECT_GT(std::abs(found.axes[0].n_O.dot(T.linear().col(2))), 0.999);
  EXPECT_LT((T.inverse() * found.p_O).head<2>().norm(), 0.001);
  EXPECT_EQ(found.planes.size(), 1U) << "all planes that hold the axis are alike";
  EXPECT_TRUE(discrete_turns(found).empty());
}

TEST(Symmetry, OfThreeLobesIsAThirdOfATurn) {
  const Symmetries found = find_symmetries(three_lobes());
  ASSERT_EQ(found.axes.size(), 1U);
  EXPECT_EQ(found.axes[0].order, 3);
  EXPECT_EQ(found.planes.size(), 3U);
  EXPECT_EQ(discrete_turns(found).size(), 2U);
}

TEST(Symmetry, IsNoneOfLimestones) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const Symmetries found = find_symmetries(reduce_mesh(make_limestone(seed), 500));
    EXPECT_TRUE(found.axes.empty() && found.planes.empty()) << "seed " << seed;
  }
}

TEST(Symmetry, IsWrittenIntoTheCatalogueAndRead) {
  const std::string folder = test::temporary_folder() + concat("symmetry_test_", ::getpid());
  const Stone stone = model_stone(egg(), "egg", "egg.ply", {}).stone;
  write_stone(folder, stone);
  const StoneFile file = read_stone_yaml(folder + "/egg/stone.yaml");
  const Symmetries found = find_symmetries(stone.mesh);
  ASSERT_EQ(file.symmetries.axes.size(), 1U);
  EXPECT_EQ(file.symmetries.axes[0].order, 0);
  EXPECT_EQ(file.symmetries.axes[0].n_O, found.axes[0].n_O);
  EXPECT_EQ(file.symmetries.p_O, found.p_O);
  EXPECT_EQ(file.symmetries.planes.size(), found.planes.size());
  EXPECT_EQ(read_catalogue(folder).stones.size(), 1U);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace stonestack::stone
