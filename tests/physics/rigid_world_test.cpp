#include "physics/rigid_world.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/constants.hpp"
#include "physics/bodies.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::physics {
namespace {

using test::at;
using test::body;
using test::box;

constexpr double kStep = 0.0005;

WorldOptions with_friction(double friction) {
  WorldOptions options;
  options.friction = friction;
  options.iterations = 200;
  return options;
}

void pass(RigidWorld& world, double seconds, double step = kStep) {
  for (long k = std::lround(seconds / step); k > 0; --k) world.step(step);
}

/// Behaviour that every engine must have.
class Engines : public testing::TestWithParam<EngineKind> {
 protected:
  [[nodiscard]] static std::unique_ptr<RigidWorld> make(double friction) {
    return make_rigid_world(GetParam(), with_friction(friction));
  }
};
INSTANTIATE_TEST_SUITE_P(All, Engines, testing::Values(EngineKind::kBullet, EngineKind::kOde),
                         [](const auto& param) { return to_text(param.param); });

TEST(EngineKind, HasANameThatIsReadAgain) {
  EXPECT_EQ(engine_named("bullet"), EngineKind::kBullet);
  EXPECT_EQ(engine_named(to_text(EngineKind::kOde)), EngineKind::kOde);
  EXPECT_THROW((void)engine_named("mujoco"), InvalidArgument);
}

TEST_P(Engines, ABodyFallsFreely) {
  const auto world = make(0.3);
  world->add_stone(box(0.06, 0.05, 0.04), at(0, 0, 1.0), false);
  pass(*world, 0.25);
  EXPECT_NEAR(world->pose(0).translation().z(), 1.0 - 0.5 * kGravity * 0.0625, 1e-3);
  EXPECT_NEAR(world->twist(0).v.z(), -kGravity * 0.25, 1e-6);
}

/// How far a flat block slides in 1 s on a plane tilted by `share` of atan(friction), in a direction that is
/// neither the block's nor an axis of the world.
double slid(RigidWorld& world, double friction, double yaw, double share) {
  world.add_stone(box(0.08, 0.08, 0.02), at(0, 0, 0.01, yaw), false);
  const double tilt = std::atan(friction) * share;
  pass(world, 0.1);
  const Eigen::Vector3d before = world.pose(0).translation();
  world.set_gravity(kGravity * Eigen::Vector3d(std::sin(tilt) * std::cos(0.6), std::sin(tilt) * std::sin(0.6),
                                               -std::cos(tilt)));
  pass(world, 1.0);
  return (world.pose(0).translation() - before).head<2>().norm();
}

TEST_P(Engines, ABoxSlipsAtTheFrictionAngleInAnyDirection) {
  for (const double friction : {0.1, 0.3, 0.5})
    for (const double yaw : {0.0, 0.4}) {
      const double tilt = std::atan(friction) * 1.05;
      const double expected = 0.5 * kGravity * (std::sin(tilt) - friction * std::cos(tilt));
      const auto holds = make(friction), slides = make(friction);
      EXPECT_LT(slid(*holds, friction, yaw, 0.95), 5e-4) << "friction " << friction << ", yaw " << yaw;
      EXPECT_NEAR(slid(*slides, friction, yaw, 1.05), expected, 0.05 * expected)
          << "friction " << friction << ", yaw " << yaw;
    }
}

/// Table of 2 x 2 m that passes through the origin, 2 mm above it, and falls by `tilt` (rad) along x.
TableSurface tilted_table(double tilt) {
  const Eigen::Matrix3d R = Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitY()).toRotationMatrix();
  Pose T_W_slab = Pose::Identity();
  T_W_slab.linear() = R;
  T_W_slab.translation() = Eigen::Vector3d(0, 0, 0.002) - 0.025 * R.col(2);
  const Plane plane{R.col(2), 0.002 * R(2, 2)};
  const Mesh slab = transformed(make_box({2.0, 2.0, 0.05}), T_W_slab);
  return {make_contact_shape(slab, mass_properties(slab, 700.0), "table", {0.02, 0.03, 0.06}),
          [plane](const Eigen::Vector2d&) { return plane; }};
}

TEST_P(Engines, ATableMayLieHigherAndTilted) {
  constexpr double kTilt = 0.2;
  const Eigen::Matrix3d R = Eigen::AngleAxisd(kTilt, Eigen::Vector3d::UnitY()).toRotationMatrix();
  for (const double friction : {0.1, 0.3}) {
    const auto world = make(0.7);
    Pose T_W_O = Pose::Identity();
    T_W_O.linear() = R;
    T_W_O.translation() = Eigen::Vector3d(0, 0, 0.002) + 0.01 * R.col(2);
    world->add_stone(box(0.08, 0.08, 0.02), T_W_O, false);
    world->add_stone(box(0.08, 0.08, 0.02), at(0, 0.5, 5.0), true);
    world->add_table(tilted_table(kTilt));
    world->set_pair_friction(kTable, 0, friction);
    const int arm =
        world->add_box({0.1, 0.1, 0.1}, at(0, -0.5, 0.0));  // in the table: boxes meet stones only
    EXPECT_EQ(arm, 3);
    pass(*world, 1.0);
    const double expected = 0.5 * kGravity * (std::sin(kTilt) - friction * std::cos(kTilt));
    const Eigen::Vector3d moved = world->pose(0).translation() - T_W_O.translation();
    EXPECT_NEAR(moved.dot(R.col(2)), 0.0, 2e-4) << "lies on it";
    EXPECT_NEAR(moved.dot(R.col(0)), std::max(0.0, expected), 0.01 + 0.05 * std::max(0.0, expected))
        << friction;
    ASSERT_FALSE(world->contacts().empty());
    for (const Contact& contact : world->contacts()) {
      EXPECT_EQ(contact.below, kTable);
      EXPECT_EQ(contact.above, 0);
      EXPECT_GT(contact.n_W.dot(R.col(2)), 0.999);
    }
  }
}

TEST_P(Engines, FrictionIsThatOfThePair) {
  const auto world = make(0.05);
  world->add_stone(box(0.08, 0.08, 0.02), at(0, 0, 0.01), false);
  world->add_stone(box(0.06, 0.06, 0.02), at(0, 0, 0.03), false);
  world->set_pair_friction(0, kTable, 0.6);
  world->set_pair_friction(0, 1, 0.2);
  const double tilt = std::atan(0.4);  // the table holds, the upper box slides with 0.2
  pass(*world, 0.1);
  world->set_gravity(kGravity * Eigen::Vector3d(std::sin(tilt), 0, -std::cos(tilt)));
  pass(*world, 0.1);
  EXPECT_LT(world->pose(0).translation().norm(), 0.0105);
  const double expected = 0.5 * 0.01 * kGravity * (std::sin(tilt) - 0.2 * std::cos(tilt));
  EXPECT_NEAR(world->pose(1).translation().x(), expected, 0.1 * expected);
}

/// Of a ball on the table on which a box is pressed 0.5 mm deep: the force on the box when it has come to
/// rest, that of springs of 1e5 N/m as long as the touches are deep, and the largest on the way.
struct Press {
  double force = 0.0, springs = 0.0, largest = 0.0;  ///< [N]
};
Press press_ball(RigidWorld& world, bool gives_way) {
  constexpr double kRadius = 0.05, kStiffness = 1e5, kPressed = 0.0005;
  const int ball = world.add_stone(body(make_sphere(kRadius, 4), "ball"), at(0, 0, kRadius), false);
  const int above = world.add_box({0.2, 0.2, 0.02}, at(0, 0, 2 * kRadius + 0.0105));
  world.set_pair_friction(ball, above, 0.0);
  if (gives_way) world.set_pair_stiffness(ball, above, kStiffness);
  Press press;
  constexpr int kSteps = 300, kMean = 50;
  for (int k = 0; k < kSteps; ++k) {
    const double way = std::min(1.0, 2.0 * (k + 1) / kSteps);
    world.move_to(above, at(0, 0, 2 * kRadius + 0.0105 - way * (0.0005 + kPressed)));
    world.step(kStep);
    const bool at_rest = k >= kSteps - kMean;
    double force = 0.0;
    for (const Contact& contact : world.contacts()) {
      if (contact.below == kTable) continue;
      force += contact.impulse / kStep;
      if (at_rest) press.springs += kStiffness * std::max(0.0, -contact.gap) / kMean;
    }
    if (at_rest) press.force += force / kMean;
    press.largest = std::max(press.largest, force);
  }
  return press;
}

TEST_P(Engines, ABoxThatGivesWayPressesLikeASpring) {
  const auto soft = make(0.3), rigid = make(0.3);
  const Press press = press_ball(*soft, true);
  EXPECT_GT(press.springs, 20.0);
  EXPECT_LT(press.springs, 60.0) << "half a millimetre at most";
  EXPECT_NEAR(press.force, press.springs, 0.05 * press.springs);
  EXPECT_LT(press.largest, 1.5 * press.force);
  EXPECT_GT(press_ball(*rigid, false).largest, 3.0 * press.largest);
  EXPECT_THROW(rigid->set_pair_stiffness(0, 1, 0.0), InvalidArgument);
}

/// A ball of mesh on a plane tilted by `tilt`: distance and turning after 0.4 s.
Eigen::Vector2d ball_on_slope(RigidWorld& world, double tilt) {
  constexpr double kRadius = 0.05;
  world.add_stone(body(make_sphere(kRadius, 4), "ball"), at(0, 0, kRadius), false);
  world.set_gravity(kGravity * Eigen::Vector3d(std::sin(tilt), 0, -std::cos(tilt)));
  pass(world, 0.4, 0.001);
  return {world.twist(0).v.x(), world.twist(0).w.y() * kRadius};
}

TEST_P(Engines, ABallRollsWhereFrictionSufficesAndSlidesWhereNot) {
  // A solid ball rolls down with 5/7 of g sin(tilt) as long as friction is at least 2/7 of tan(tilt).
  const double tilt = 0.3;
  const auto rough = make(0.5), smooth = make(0.04);
  const Eigen::Vector2d rolls = ball_on_slope(*rough, tilt), slides = ball_on_slope(*smooth, tilt);
  const double rolling = 5.0 / 7.0 * kGravity * std::sin(tilt) * 0.4;
  EXPECT_NEAR(rolls.x(), rolling, 0.06 * rolling) << "its facets cost a few per cent";
  EXPECT_NEAR(rolls.y(), rolls.x(), 0.03) << "rolls without slipping";
  const double expected = kGravity * (std::sin(tilt) - 0.04 * std::cos(tilt)) * 0.4;
  EXPECT_NEAR(slides.x(), expected, 0.03 * expected);
  EXPECT_NEAR(slides.y(), 2.5 * 0.04 * kGravity * std::cos(tilt) * 0.4, 0.05) << "friction turns it";
}

TEST_P(Engines, ContactsCarryTheWeightAndPointUp) {
  // A smooth ball between three fixed ones: level with the three, two radii from each.
  const auto world = make(0.3);
  constexpr double kRadius = 0.05, kFromAxis = 0.06;
  const auto ball = body(make_sphere(kRadius, 3), "ball");
  for (int k = 0; k < 3; ++k) {
    const double angle = 2.1 * k;  // nearly regular: no symmetry that a mistake could hide in
    world->add_stone(ball, at(kFromAxis * std::cos(angle), kFromAxis * std::sin(angle), 0.2), true);
  }
  const double up = std::sqrt(4 * kRadius * kRadius - kFromAxis * kFromAxis);
  const int top = world->add_stone(ball, at(0, 0, 0.2 + up + 0.001), false);
  for (int k = 0; k < 3; ++k) world->set_pair_friction(k, top, 0.0);
  pass(*world, 1.0);
  double carried = 0.0;
  constexpr int kMean = 200;
  for (int k = 0; k < kMean; ++k) {
    world->step(kStep);
    for (const Contact& c : world->contacts()) {
      EXPECT_EQ(c.above, top);
      EXPECT_NEAR(c.n_W.z(), up / (2 * kRadius), 0.1);
      carried += c.impulse * c.n_W.z() / kMean;
    }
  }
  const double weight = ball->mass.mass * kGravity * kStep;
  EXPECT_NEAR(carried, weight, 0.03 * weight);
}

TEST_P(Engines, ATowerStandsAndOneBeyondItsEdgeFalls) {
  // Equal slabs of length 0.10: the upper may overhang by half its length, then it tips.
  const auto turned = [](double overhang) {
    const auto world = make(0.5);
    world->add_stone(body(test::rough_slab({0.10, 0.10, 0.04}, 1), "slab"), at(0, 0, 0.02), false);
    world->add_stone(body(test::rough_slab({0.10, 0.10, 0.04}, 2), "slab"), at(overhang, 0, 0.06), false);
    pass(*world, 2.0);
    return difference(world->pose(1), at(overhang, 0, 0.06)).angle;
  };
  EXPECT_LT(turned(0.035), 0.05);
  EXPECT_GT(turned(0.060), 0.2);
}

/// A block at rest on a fixed one, the world's axes turned into no special position.
struct BlockOnBlock {
  Eigen::Vector3d lower{0.10, 0.10, 0.04}, upper{0.10, 0.10, 0.04};  ///< full sides [m]
  double yaw = 0.0, overhang = 0.0;                                  ///< of the upper [rad], [m]
};
std::unique_ptr<RigidWorld> lay(EngineKind engine, double friction, const BlockOnBlock& blocks) {
  auto world = make_rigid_world(engine, with_friction(friction));
  const auto& [lower, upper, yaw, overhang] = blocks;
  world->add_stone(box(lower.x(), lower.y(), lower.z()), at(0, 0, 0.5), true);
  world->add_stone(box(upper.x(), upper.y(), upper.z()),
                   at(overhang, 0, 0.5 + 0.5 * (lower.z() + upper.z()), yaw), false);
  return world;
}

TEST_P(Engines, ABlockRestsOnABlock) {
  for (const BlockOnBlock& blocks : {BlockOnBlock{}, BlockOnBlock{.yaw = 0.3}, BlockOnBlock{.overhang = 0.03},
                                     BlockOnBlock{.upper = {0.06, 0.05, 0.09}, .yaw = 0.003}}) {
    const auto world = lay(GetParam(), 0.3, blocks);
    const Pose before = world->pose(1);
    pass(*world, 10.0, 0.002);
    const auto moved = difference(before, world->pose(1));
    EXPECT_LT(moved.translation, 2e-5) << "yaw " << blocks.yaw << ", overhang " << blocks.overhang;
    EXPECT_LT(moved.angle, 2e-4) << "yaw " << blocks.yaw << ", overhang " << blocks.overhang;
  }
}

TEST_P(Engines, ABlockSlipsOnABlockAtTheFrictionAngle) {
  const auto slips = [](double friction, double share) {
    const auto world = lay(GetParam(), friction, {.upper = {0.06, 0.05, 0.02}, .yaw = 0.4});
    const double tilt = std::atan(share * friction);
    pass(*world, 0.05);
    const Eigen::Vector3d before = world->pose(1).translation();
    world->set_gravity(kGravity *
                       Eigen::Vector3d(std::sin(tilt) * 0.8, std::sin(tilt) * 0.6, -std::cos(tilt)));
    pass(*world, 0.4);
    return (world->pose(1).translation() - before).norm();
  };
  for (const double friction : {0.1, 0.3, 0.6}) {
    const double tilt = std::atan(1.02 * friction);
    const double free = 0.5 * kGravity * 0.16 * (std::sin(tilt) - friction * std::cos(tilt));
    EXPECT_LT(slips(friction, 0.98), 5e-5) << friction;
    EXPECT_GT(slips(friction, 1.02), 0.8 * free) << friction;
  }
}

TEST_P(Engines, ABlockTipsWhereItsWeightLeavesItsBase) {
  // The upper block, 40 mm wide and 60 mm high, overhangs by 5 mm: it tips over the lower one's rim.
  const double angle = std::atan(0.015 / 0.03);
  const auto turned = [](double tilt) {
    const auto world = lay(GetParam(), 0.9, {.upper = {0.04, 0.05, 0.06}, .overhang = 0.035});
    const Pose before = world->pose(1);
    world->set_gravity(kGravity * Eigen::Vector3d(std::sin(tilt), 0, -std::cos(tilt)));
    pass(*world, 0.8, 0.001);
    return difference(before, world->pose(1)).angle;
  };
  EXPECT_LT(turned(angle - 0.5 * kDegree), 0.001);
  EXPECT_GT(turned(angle + 0.5 * kDegree), 0.02);
}

TEST_P(Engines, ALadderStandsWhereFrictionAtBothEndsCarriesIt) {
  // A plank leans against a fixed block. N and mu N at floor and wall balance it as long as the lever x of
  // its weight about the foot is at most (mu sin + mu^2 cos) / (1 + mu^2) of its length: from 41 deg on. The
  // normal forces without friction, of a plank that slides, are smaller: 0.63 and 0.38 of its weight at 45
  // deg.
  constexpr double kLength = 0.30, kThickness = 0.01, kFriction = 0.45;
  const auto slid = [&](double angle) {
    auto world = make(kFriction);
    const Eigen::Matrix3d R = Eigen::AngleAxisd(-angle, Eigen::Vector3d::UnitY()).toRotationMatrix();
    const Eigen::Vector3d foot = R * Eigen::Vector3d(-0.5 * kLength, 0, -0.5 * kThickness);
    const Eigen::Vector3d head = R * Eigen::Vector3d(0.5 * kLength, 0, -0.5 * kThickness);
    Pose T_W_O = Pose::Identity();
    T_W_O.linear() = R;
    T_W_O.translation() << 0, 0, -foot.z();
    world->add_stone(box(0.1, 0.3, 0.6), at(head.x() + 0.05, 0, 0.3), true);
    const int plank = world->add_stone(box(kLength, 0.1, kThickness), T_W_O, false);
    pass(*world, 0.5, 0.0005);
    return difference(T_W_O, world->pose(plank)).translation;
  };
  EXPECT_LT(slid(45.0 * kDegree), 5e-4);
  EXPECT_GT(slid(37.0 * kDegree), 0.02);
}

TEST_P(Engines, ConcaveStonesStayWhereTheyLie) {
  const auto world = make(0.5);
  const auto stone = test::lump(7);
  world->add_stone(stone, at(0, 0, 0.06), false);
  pass(*world, 4.0, 0.001);
  const Pose before = world->pose(0);
  pass(*world, 2.0, 0.001);
  const auto moved = difference(before, world->pose(0));
  EXPECT_LT(moved.translation, 2e-5);
  EXPECT_LT(moved.angle, 2e-4);
}

TEST_P(Engines, ABoxPushesAStoneAndFixedStonesStay) {
  const auto world = make(0.1);
  const auto cube = box(0.06, 0.06, 0.06);
  world->add_stone(cube, at(0, 0, 0.03), false);
  world->add_stone(cube, at(0, 0.2, 0.5), true);
  const int pusher = world->add_box({0.02, 0.1, 0.04}, at(-0.041, 0, 0.03));
  double push = 0.0;
  constexpr int kSteps = 2000;
  for (int k = 1; k <= kSteps; ++k) {
    world->move_to(pusher, at(-0.041 + 0.05 * k / kSteps, 0, 0.03));
    world->step(kStep);
    if (k <= kSteps / 2) continue;
    for (const Contact& c : world->contacts())
      if (c.above == pusher) push -= 2.0 * c.impulse * c.n_W.x() / kStep / kSteps;
  }
  EXPECT_NEAR(world->pose(pusher).translation().x(), 0.009, 1e-9);
  EXPECT_NEAR(world->pose(0).translation().x(), 0.049, 5e-4);
  EXPECT_NEAR(push, 0.1 * cube->mass.mass * kGravity, 0.1) << "friction of the stone on the table, N";
  EXPECT_LT(difference(world->pose(1), at(0, 0.2, 0.5)).translation, 1e-9);
}

TEST_P(Engines, ForcesActForOneStepAndTurnsAreDamped) {
  WorldOptions options = with_friction(0.3);
  options.angular_damping = 0.5;
  const auto world = make_rigid_world(GetParam(), options);
  const auto shape = box(0.06, 0.06, 0.06);
  world->add_stone(shape, at(0, 0, 1.0), false);
  world->place(0, at(0, 0, 1.0), {Eigen::Vector3d::Zero(), Eigen::Vector3d(0, 0, 2.0)});
  for (int k = 0; k < 2000; ++k) {
    world->apply(0, {0, 0, kGravity * shape->mass.mass}, Eigen::Vector3d::Zero());
    world->step(kStep);
  }
  EXPECT_NEAR(world->pose(0).translation().z(), 1.0, 1e-6);
  EXPECT_NEAR(world->twist(0).w.z(), 2.0 * 0.5, 0.01) << "half of it is left after a second";
  world->step(kStep);
  EXPECT_LT(world->twist(0).v.z(), -0.9 * kGravity * kStep);
}

TEST_P(Engines, SameStepsSameBits) {
  const auto fallen = [] {
    const auto world = make(0.4);
    world->add_stone(test::lump(3), at(0, 0, 0.06), false);
    world->add_stone(test::lump(4), at(0.01, 0, 0.16), false);
    pass(*world, 0.5, 0.001);
    return world->pose(1).matrix().eval();
  };
  EXPECT_TRUE((fallen().array() == fallen().array()).all());
}

TEST_P(Engines, RefusesWhatCannotBe) {
  const auto world = make(0.3);
  const int stone = world->add_stone(box(0.06, 0.06, 0.06), at(0, 0, 0.03), false);
  EXPECT_THROW((void)world->pose(7), InvalidArgument);
  EXPECT_THROW(world->move_to(stone, at(0, 0, 1)), InvalidArgument);
  EXPECT_THROW(world->step(0.0), InvalidArgument);
  EXPECT_THROW((void)make(std::nan("")), InvalidArgument);
  EXPECT_THROW(world->add_box({0.1, 0, 0.1}, at(0, 0, 1)), InvalidArgument);
}

}  // namespace
}  // namespace stonestack::physics
