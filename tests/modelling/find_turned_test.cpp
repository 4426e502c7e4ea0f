#include <gtest/gtest.h>

#include "seen_things.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::modelling {
namespace {

using namespace test;

Thing on_its_side(const Thing& lying) {
  Thing turned = lying;
  turned.T_W_O = Pose(Eigen::AngleAxisd(1.4, Eigen::Vector3d::UnitX()));
  double lowest = 1.0;
  for (const auto& v : turned.mesh.vertices) lowest = std::min(lowest, (turned.T_W_O * v).z());
  turned.T_W_O = Eigen::Translation3d(0.01, -0.02, -lowest) * turned.T_W_O;
  return turned;
}

TEST(FindTurned, AStoneThatWasTurnedIsFoundNearWhereItWasMeantToLie) {
  const Thing first = lying_stone(3, 0.0, 0.0);
  const Thing second = on_its_side(first);
  const AlignedScene a = align_scene(views_of({first}, cameras_around(5)));
  const AlignedScene b = align_scene(views_of({second}, cameras_around(5)));
  const ObjectModel model = model_objects(a).front();  // in W as it lay first
  const Pose moved = second.T_W_O * first.T_W_O.inverse();
  Pose meant = Eigen::Translation3d(0.006, -0.004, 0.003) * moved;
  meant.rotate(Eigen::AngleAxisd(0.15, Eigen::Vector3d(1, 1, 0).normalized()));
  const auto found = find_turned(model, {&b, 0, meant});
  ASSERT_TRUE(found.has_value());
  const Eigen::Vector3d middle = first.T_W_O * Eigen::Vector3d::Zero();
  EXPECT_LT((found->T_W_O * middle - moved * middle).norm(), 0.002);
  EXPECT_LT(difference(found->T_W_O, moved).angle, 0.02);
  EXPECT_GT(found->agreement, 0.35);
}

TEST(FindTurned, AnotherStoneIsNotTakenForIt) {
  const Thing first = lying_stone(3, 0.0, 0.0);
  const Thing other{make_box({0.05, 0.05, 0.05}), make_pose({0.0, 0.0, 0.025})};
  const AlignedScene a = align_scene(views_of({first}, cameras_around(4)));
  const AlignedScene b = align_scene(views_of({other}, cameras_around(4)));
  const auto found = find_turned(model_objects(a).front(), {&b, 0, Pose::Identity()});
  EXPECT_TRUE(!found || found->agreement < 0.6) << found->agreement;
}

}  // namespace
}  // namespace stonestack::modelling
