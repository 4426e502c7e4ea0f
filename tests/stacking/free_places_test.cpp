#include "stacking/free_places.hpp"

#include <gtest/gtest.h>

#include "physics/settle.hpp"
#include "physics/shape.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/stone/catalogue.hpp"

namespace stonestack::stacking {
namespace {

/// Angle between the ups of two poses as the stone sees them [rad].
double tilt_between(const Pose& a, const Pose& b) {
  return std::acos(std::clamp(a.linear().row(2).dot(b.linear().row(2)), -1.0, 1.0));
}

TEST(FreePlaces, AStoneThatWouldRollIsOfferedAsItRestsAndThenAsItIsHeld) {
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  const ShapeList shapes = make_contact_shapes(catalogue.stones);
  Pose T_W_O = make_pose(Eigen::Vector3d(0.7, 0.28, 0.2));
  T_W_O.linear() = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1.0, 2.0, 0.0).normalized()).toRotationMatrix();
  const PlacedStone held{1_stone, T_W_O};
  const auto places = free_places(shapes, CellLayout{}, Arrangement{}, held);
  ASSERT_GE(places.size(), 16U);
  const std::size_t half = places.size() / 2;
  for (std::size_t k = 0; k < places.size(); ++k) {
    const double low = lowest(*shapes[1], places[k]);
    if (k < half) {
      EXPECT_GT(tilt_between(places[k], T_W_O), 0.1) << k << ": at rest";
      EXPECT_NEAR(low, 0.0, 0.002) << k;
    } else {
      EXPECT_LT(tilt_between(places[k], T_W_O), 1e-6) << k << ": as held";
      EXPECT_NEAR(low, 0.002, 1e-9) << k;
      const Eigen::Vector3d apart =
          places[k] * shapes[1]->mass.p_O_M - places[k - half] * shapes[1]->mass.p_O_M;
      EXPECT_LT(apart.head<2>().norm(), 1e-9) << k << ": the same place";
    }
  }
  // One that lies as it rests is offered once.
  const PlacedStone resting{1_stone, Eigen::Translation3d(0.0, 0.0, 0.2) * places.front()};
  for (const Pose& place : free_places(shapes, CellLayout{}, Arrangement{}, resting))
    EXPECT_LT(tilt_between(place, resting.T_W_O), 0.15);
}

}  // namespace
}  // namespace stonestack::stacking
