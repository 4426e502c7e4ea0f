#include "physics/shape_store.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "stonestack/geometry/mesh.hpp"

namespace stonestack::physics {
namespace {

constexpr ShapeOptions kCoarse{0.01, 0.02, 0.02};

TEST(ShapeStore, MakesTheSameScanOnce) {
  const Mesh scan = make_box({0.1, 0.08, 0.06});
  const auto once = shape_geometry(scan, kCoarse);
  EXPECT_EQ(shape_geometry(scan, kCoarse), once);
  const auto light = make_contact_shape(scan, mass_properties(scan, 1000.0), "light", kCoarse);
  const auto heavy = make_contact_shape(scan, mass_properties(scan, 3000.0), "heavy", kCoarse);
  EXPECT_EQ(light->features, heavy->features);
  EXPECT_LT(2 * light->mass.mass, heavy->mass.mass);
}

TEST(ShapeStore, DistinguishesScansAndOptions) {
  Mesh scan = make_box({0.1, 0.08, 0.06});
  const auto first = shape_geometry(scan, kCoarse);
  EXPECT_NE(shape_geometry(scan, {0.005, 0.02, 0.02}), first);
  EXPECT_NE(shape_geometry(scan, {0.01, 0.03, 0.02}), first);
  EXPECT_NE(shape_geometry(scan, {0.01, 0.02, 0.01}), first);
  scan.vertices[0].x() = std::nextafter(scan.vertices[0].x(), -1.0);
  EXPECT_NE(shape_geometry(scan, kCoarse), first);
}

TEST(ShapeStore, KeepsTheLastUsedOnly) {
  const Mesh old = make_box({0.05, 0.05, 0.05});
  const std::weak_ptr<const ShapeGeometry> first = shape_geometry(old, kCoarse);
  const Mesh used = make_box({0.06, 0.05, 0.05});
  const auto second = shape_geometry(used, kCoarse);
  for (std::size_t k = 0; k + 1 < kMaxKept; ++k) {
    (void)shape_geometry(make_box({0.05, 0.05, 0.051 + 0.0001 * static_cast<double>(k)}), kCoarse);
    EXPECT_EQ(shape_geometry(used, kCoarse), second);
  }
  EXPECT_TRUE(first.expired());
}

TEST(ShapeStore, FindsWhatIsHeldAndLosesWhatIsNot) {
  const Mesh held_scan = make_box({0.07, 0.05, 0.05}), lost_scan = make_box({0.08, 0.05, 0.05});
  const auto held = make_contact_shape(held_scan, mass_properties(held_scan, 2000.0), "held", kCoarse);
  const std::weak_ptr<const ShapeGeometry> lost = shape_geometry(lost_scan, kCoarse);
  EXPECT_FALSE(lost.expired());
  for (std::size_t k = 0; k < kMaxKept; ++k)
    (void)shape_geometry(make_box({0.05, 0.05, 0.081 + 0.0001 * static_cast<double>(k)}), kCoarse);
  EXPECT_TRUE(lost.expired());
  EXPECT_EQ(shape_geometry(held_scan, kCoarse)->features.get(), held->features.get());
}

TEST(ShapeStore, KeepsNothingOfAScanThatNeverComesAgain) {
  Stone stone;
  stone.scan = make_box({0.09, 0.05, 0.05});
  stone.mass = mass_properties(stone.scan, 2000.0);
  const std::weak_ptr<const SurfaceFeatures> kept = make_contact_shapes({stone}, kCoarse).front()->features;
  EXPECT_FALSE(kept.expired());
  stone.scan = make_box({0.091, 0.05, 0.05});
  const std::weak_ptr<const SurfaceFeatures> passing =
      make_passing_shapes({stone}, kCoarse).front()->features;
  EXPECT_TRUE(passing.expired());
}

}  // namespace
}  // namespace stonestack::physics
