#include "geometry/depth_unit.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "stonestack/core/random.hpp"

namespace stonestack::geometry {
namespace {

DepthImage image_of(std::vector<float> z) {
  DepthImage image;
  image.camera.width = static_cast<int>(z.size());
  image.camera.height = 1;
  image.z = std::move(z);
  return image;
}

/// A slope with noise and a few far pixels, in counts of `unit`, as a camera delivers it.
DepthImage counted(double unit, Random random) {
  std::vector<float> z = {0.0F, std::nanf("")};
  for (int i = 0; i < 2000; ++i)
    z.push_back(static_cast<float>(unit * std::round((0.5 + 1e-4 * i + random.normal(0.0, 0.002)) / unit)));
  for (int i = 0; i < 5; ++i)
    z.push_back(static_cast<float>(unit * std::round(random.uniform(2.0, 4.0) / unit)));
  return image_of(std::move(z));
}

TEST(DepthUnit, IsFoundInTheDepthsOfACamera) {
  for (const double unit : {0.000125, 0.0001, 0.001, 0.0002, 0.00025, 0.00012498664727900177})
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
      const DepthImage image = counted(unit, Random::stream(seed, "depth unit"));
      const auto found = find_depth_unit(image);
      ASSERT_TRUE(found) << unit << ", seed " << seed;
      EXPECT_NEAR(*found, unit, 1e-6 * unit) << "seed " << seed;
      EXPECT_TRUE(is_depth_unit(image, *found));
    }
  EXPECT_EQ(find_depth_unit(counted(0.000125, Random::stream(1, "depth unit"))), 0.000125)
      << "as a person writes it";
}

TEST(DepthUnit, IsFoundWhereNoTwoDepthsAreNeighbours) {
  std::vector<float> z;
  for (int i = 0; i < 30; ++i) z.push_back(static_cast<float>(0.001 * (701 + 2 * i)));
  const auto found = find_depth_unit(image_of(z));
  ASSERT_TRUE(found) << "odd counts alone";
  EXPECT_EQ(*found, 0.001);
}

TEST(DepthUnit, DepthsThatNobodyCountedHaveNone) {
  Random random = Random::stream(1, "depths of a cloud");
  std::vector<float> z;
  for (int i = 0; i < 1000; ++i) z.push_back(static_cast<float>(random.uniform(0.5, 1.5)));
  EXPECT_FALSE(find_depth_unit(image_of(z)));
  EXPECT_FALSE(find_depth_unit(image_of({0.5F, 0.5F})));
  EXPECT_FALSE(find_depth_unit(image_of({})));
  EXPECT_FALSE(is_depth_unit(image_of({0.0001F, 10.0F}), 0.0001)) << "100,000 counts are no 16 bits";
}

TEST(DepthUnit, TheFinestReachesTheFarthestDepth) {
  EXPECT_EQ(finest_depth_unit(image_of({})), 1e-5);
  EXPECT_EQ(finest_depth_unit(image_of({0.65F})), 1e-5);
  EXPECT_EQ(finest_depth_unit(image_of({0.3F, 0.66F})), 2e-5);
  EXPECT_EQ(finest_depth_unit(image_of({6.5F})), 1e-4);
  EXPECT_EQ(finest_depth_unit(image_of({100.0F})), 1e-3);
}

}  // namespace
}  // namespace stonestack::geometry
