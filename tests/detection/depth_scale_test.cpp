// What a wrong depth unit or focal length makes of the sizes of stones.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "detection/test_scene.hpp"

namespace stonestack::detection {
namespace {

class DepthScales : public test::FourOfFive {};

TEST_F(DepthScales, AWrongOneIsNoticed) {
  for (std::uint64_t seed = 1; seed <= 3; ++seed) {
    const DepthImage right = make_scene(seed).image;
    const auto scaled = [&](float factor) {
      DepthImage image = right;
      for (auto& z : image.z) z *= factor;
      return detect_stones(image, *models());
    };
    const auto as_it_is = scaled(1.0F);
    EXPECT_FALSE(as_it_is.detections.empty());
    EXPECT_EQ(as_it_is.note, "") << "seed " << seed << ": " << as_it_is.depth_scale;
    EXPECT_NEAR(as_it_is.depth_scale, 1.0, 0.012);
    EXPECT_LT(std::abs(as_it_is.depth_scale - 1.0), 3.5 * as_it_is.depth_scale_sigma);
    for (const float factor : {0.92F, 1.08F}) {
      const auto wrong = scaled(factor);
      EXPECT_TRUE(wrong.detections.empty()) << "centimetres off, seed " << seed << ", " << factor;
    }
    const auto doubtful = scaled(1.035F);
    EXPECT_FALSE(doubtful.detections.empty());
    EXPECT_THAT(doubtful.note, ::testing::HasSubstr("depth unit")) << doubtful.depth_scale;
    EXPECT_NEAR(doubtful.depth_scale, 1.035, 0.012);
  }
}

}  // namespace
}  // namespace stonestack::detection
