#include <gtest/gtest.h>

#include "geometry/convex_pieces.hpp"
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
  const ObjectModel model = model_objects(a).front().value();  // in W as it lay first
  const Pose moved = second.T_W_O * first.T_W_O.inverse();
  Pose meant = Eigen::Translation3d(0.006, -0.004, 0.003) * moved;
  meant.rotate(Eigen::AngleAxisd(0.15, Eigen::Vector3d(1, 1, 0).normalized()));
  const auto found = find_turned(model, {}, {&b, 0, meant});
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
  const auto found = find_turned(model_objects(a).front().value(), {}, {&b, 0, Pose::Identity()});
  EXPECT_TRUE(!found || found->agreement < 0.6) << found->agreement;
}

/// Half of a lying stone: what is left of it on one side of a cut.
Thing cut(const Thing& lying, double share) {
  Mesh points;
  for (const auto& v : lying.mesh.vertices) points.vertices.push_back(v);
  const Eigen::AlignedBox3d box = bounds(lying.mesh);
  Mesh kept;
  for (const auto& v : points.vertices)
    if (v.x() < box.min().x() + share * box.sizes().x()) kept.vertices.push_back(v);
  return {convex_hull(kept), lying.T_W_O};
}

/// Five cameras above the side of -x: they do not show the face at +x where a stone was cut, but what lies
/// beyond.
std::vector<Pose> cameras_behind_cut() {
  std::vector<Pose> poses;
  for (int k = -2; k <= 2; ++k) {
    const double azimuth = M_PI + 0.5 * k, elevation = k % 2 == 0 ? 1.2 : 1.0;
    poses.push_back(
        looking_at(0.55 * Eigen::Vector3d(std::cos(elevation) * std::cos(azimuth),
                                          std::cos(elevation) * std::sin(azimuth), std::sin(elevation)),
                   {0, 0, 0.03}));
  }
  return poses;
}

TEST(FindTurned, ViewsOfWhichTheModelWasMadeRefuteWhatTheySawThrough) {
  // Half of the stone lay there first, and the whole of it lies there now: all that was seen of the half is
  // seen again, but the views before saw through what lies beside it.
  const Thing whole = lying_stone(3, 0.0, 0.0), half = cut(whole, 0.6);
  const AlignedScene a = align_scene(views_of({half}, cameras_behind_cut()));
  const AlignedScene b = align_scene(views_of({whole}, cameras_around(5)));
  const ObjectModel model = model_objects(a).front().value();
  const LyingObject made_of{&a, 0, Pose::Identity()};
  EXPECT_TRUE(find_turned(model, {}, {&b, 0, Pose::Identity()}).has_value());
  EXPECT_FALSE(find_turned(model, {&made_of, 1}, {&b, 0, Pose::Identity()}).has_value());
  const AlignedScene again = align_scene(views_of({half}, cameras_around(4)));
  EXPECT_TRUE(find_turned(model, {&made_of, 1}, {&again, 0, Pose::Identity()}).has_value());
}

}  // namespace
}  // namespace stonestack::modelling
