#include "stonestack/physics/stack.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

#include "physics/bodies.hpp"
#include "physics/settle.hpp"
#include "physics/world.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::physics {
namespace {

using test::at;
using test::body;
using test::box;

/// A beam on two legs: its convex hull would rest on whatever stands between the legs.
Mesh bridge_mesh() {
  const std::vector<Eigen::Vector2d> outline{{-0.08, 0}, {-0.05, 0}, {-0.05, 0.04}, {0.05, 0.04},
                                             {0.05, 0},  {0.08, 0},  {0.08, 0.07},  {-0.08, 0.07}};
  const std::vector<Eigen::Vector3i> front{{0, 1, 2}, {0, 2, 7}, {7, 2, 3}, {7, 3, 6}, {3, 4, 5}, {3, 5, 6}};
  Mesh mesh;
  for (const double y : {-0.03, 0.03})
    for (const auto& p : outline) mesh.vertices.emplace_back(p.x(), y, p.y());
  for (const auto& f : front) {
    mesh.faces.push_back(f);
    mesh.faces.emplace_back(f[0] + 8, f[2] + 8, f[1] + 8);
  }
  for (int i = 0; i < 8; ++i) {
    const int j = (i + 1) % 8;
    mesh.faces.emplace_back(j, i, i + 8);
    mesh.faces.emplace_back(j, i + 8, j + 8);
  }
  return mesh;
}

TEST(JudgeStack, CubesStandAndAreClean) {
  const ShapeList shapes{box(0.06, 0.06, 0.06), box(0.05, 0.07, 0.05)};
  const Stack stack{
      {{0_stone, at(0, 0, 0.03)}, {1_stone, at(0.005, 0, 0.085, 0.3)}, {0_stone, at(0, 0.004, 0.14, 0.8)}}};
  const StandVerdict verdict = judge_stack(shapes, stack);
  EXPECT_TRUE(verdict.stands) << verdict.reason;
  EXPECT_TRUE(verdict.clean) << verdict.reason;
  EXPECT_EQ(verdict.standing, 3);
  EXPECT_LT(verdict.shift, 1e-4);
}

TEST(JudgeStack, AnOverhangingStoneFalls) {
  const ShapeList shapes{box(0.06, 0.06, 0.06)};
  const Stack stack{{{0_stone, at(0, 0, 0.03)}, {0_stone, at(0.032, 0, 0.09)}}};
  StandOptions options;
  options.friction = 0.6;
  const StandVerdict verdict = judge_stack(shapes, stack, options);
  EXPECT_FALSE(verdict.stands);
  EXPECT_EQ(verdict.standing, 1);
  EXPECT_NE(verdict.reason.find("stone 1"), std::string::npos) << verdict.reason;
}

TEST(JudgeStack, EndsWhereAStoneMovedIfNobodyAsksWhatStays) {
  const ShapeList shapes{box(0.06, 0.06, 0.06)};
  const Stack stack{{{0_stone, at(0, 0, 0.03)}, {0_stone, at(0.032, 0, 0.09)}}};
  StandOptions options;
  options.friction = 0.6;
  EXPECT_GT(judge_stack(shapes, stack, options).shift, 0.03) << "it lies on the table";
  options.fall = 0.0;
  const StandVerdict verdict = judge_stack(shapes, stack, options);
  EXPECT_FALSE(verdict.stands);
  EXPECT_LT(verdict.shift, 0.02) << "it has begun to tip";
}

TEST(StandingWhenShaken, ALowColumnOutlastsWhatTipsASlenderOne) {
  // Tips statically at g times width over height: 2 m/s^2 are 0.2 g.
  StandOptions options;
  options.friction = 0.6;
  const ShapeList shapes{box(0.08, 0.08, 0.06), box(0.06, 0.016, 0.16)};
  const Stack low{{{0_stone, at(0, 0, 0.03)}, {0_stone, at(0, 0, 0.09)}}};
  const Stack slender{{{0_stone, at(0, 0, 0.03)}, {1_stone, at(0, 0, 0.14)}}};
  EXPECT_EQ(standing_when_shaken(shapes, low, options), 2);
  EXPECT_TRUE(judge_stack(shapes, slender, options).stands);
  EXPECT_EQ(standing_when_shaken(shapes, slender, options, {0.5, 2.4, 0.7}), 2);
  EXPECT_EQ(standing_when_shaken(shapes, slender, options), 1);
  EXPECT_EQ(standing_when_shaken(shapes, {}), 0);
}

TEST(JudgeStack, TheWeightMayActBesideTheCentreOfMass) {
  // 2 mm inside the edge; the upper cube is turned by a quarter, so that its y axis points along -x.
  const ShapeList shapes{box(0.06, 0.06, 0.06)};
  const Stack stack{{{0_stone, at(0, 0, 0.03)}, {0_stone, at(0.028, 0, 0.09, M_PI / 2)}}};
  StandOptions options;
  options.friction = 0.6;
  options.seconds = 2.0;
  options.com_error_O = {Eigen::Vector3d::Zero(), {0, 0.003, 0}};
  EXPECT_TRUE(judge_stack(shapes, stack, options).stands);
  options.com_error_O[1] = {0.003, 0, 0};
  EXPECT_TRUE(judge_stack(shapes, stack, options).stands);
  options.com_error_O[1] = {0, -0.001, 0};
  EXPECT_TRUE(judge_stack(shapes, stack, options).stands);
  options.com_error_O[1] = {0, -0.003, 0};
  EXPECT_EQ(judge_stack(shapes, stack, options).standing, 1);
  options.com_error_O.pop_back();
  EXPECT_THROW(static_cast<void>(judge_stack(shapes, stack, options)), InvalidArgument);
}

TEST(JudgeStack, LeaningOnTheTableIsNotClean) {
  const ShapeList shapes{box(0.06, 0.06, 0.03), box(0.20, 0.05, 0.02)};
  // The plank lies with one end on the block and with the other on the table.
  const double tilt = std::asin(0.03 / 0.14);
  Pose plank = make_pose({0, 0, 0}, Eigen::Quaterniond(Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitY())));
  double low = 0.0;
  for (const auto& v : shapes[1]->scan.vertices) low = std::min(low, (plank * v).z());
  plank.translation() = Eigen::Vector3d(0.095, 0, -low);
  const Stack stack{{{0_stone, at(0, 0, 0.015)}, {1_stone, plank}}};
  StandOptions options;
  options.friction = 0.9;
  const StandVerdict verdict = judge_stack(shapes, stack, options);
  EXPECT_FALSE(verdict.clean);
  EXPECT_EQ(verdict.standing, verdict.stands ? 1 : std::min(verdict.standing, 1));
  EXPECT_NE(verdict.reason.find("table"), std::string::npos) << verdict.reason;
}

TEST(JudgeStack, ConcaveStonesTouchWhereTheyAre) {
  // A cube between the legs of a bridge, 2 mm below the beam: the hull of the bridge would lie on it.
  const ShapeList shapes{body(bridge_mesh(), "bridge"), box(0.038, 0.038, 0.038)};
  const Stack both{{{1_stone, at(0, 0, 0.019)}, {0_stone, at(0, 0, 0)}}};
  for (const Contact& c : geometric_contacts(shapes, both, 0.0005)) EXPECT_EQ(c.below, kTable);
  World world;
  const int cube = world.add_stone(shapes[1], at(0, 0, 0.019));
  const int bridge = world.add_stone(shapes[0], at(0, 0, 0));
  world.run(1.0);
  EXPECT_LT(difference(world.pose(cube), at(0, 0, 0.019)).translation, 1e-5);
  EXPECT_LT(difference(world.pose(bridge), at(0, 0, 0)).translation, 1e-5);
  for (const Contact& c : world.contacts()) EXPECT_EQ(c.below, kTable);

  // Lifted by a taller cube it does rest on it.
  World lifted;
  lifted.add_stone(box(0.045, 0.045, 0.045), at(0, 0, 0.0225));
  const int beam = lifted.add_stone(shapes[0], at(0, 0, 0.0052));
  lifted.run(1.0);
  EXPECT_NEAR(lifted.pose(beam).translation().z(), 0.005, 5e-5);
}

/// A lump with a rough flat top and underside, so that it may be stacked.
std::shared_ptr<const ContactShape> flat_lump(std::uint64_t seed) {
  Random random = Random::stream(seed, "flat lump");
  Mesh mesh = make_sphere(0.05, 2);
  for (auto& v : mesh.vertices) {
    v *= random.uniform(0.94, 1.0);
    v.z() = std::clamp(v.z(), -0.02, 0.02) + random.uniform(-0.002, 0.002);
  }
  return body(mesh, "flat lump");
}

/// Lumps dropped on each other; statics finds forces that hold them with a margin of 0.02 g. Empty: they
/// fell.
std::optional<Stack> balanced_lumps(const ShapeList& lumps, int seed, double friction) {
  Random random = Random::stream(static_cast<std::uint64_t>(seed), "lumps");
  Stack stack;
  for (int level = 0; level < 3; ++level) {
    SettleOptions settling;
    settling.world.friction = friction;
    const double yaw = random.uniform(0.0, 6.28);
    const SettleResult at_rest = settle(
        lumps, stack, StoneIndex(level),
        at(random.uniform(-0.01, 0.01), random.uniform(-0.01, 0.01), 0.025 + 0.045 * level, yaw), settling);
    if (!at_rest.rests) return std::nullopt;
    stack.stones.push_back({StoneIndex(level), at_rest.T_W_O});
  }
  EquilibriumOptions statics;
  statics.friction = friction;
  const Equilibrium balance = stack_equilibrium(lumps, stack, statics);
  if (!balance.stands || balance.margin < 0.02) return std::nullopt;
  return stack;
}

TEST(JudgeStack, AStackAtRestStaysAndMayEndEarly) {
  StandOptions options;
  options.friction = 0.5;
  options.seconds = 3.0;
  StandOptions early = options;
  early.still = 1e-7;
  std::vector<double> drift;
  for (int seed = 0; seed < 16; ++seed) {
    const auto base = static_cast<std::uint64_t>(3 * seed);
    const ShapeList lumps{flat_lump(base), flat_lump(base + 1), flat_lump(base + 2)};
    const auto stack = balanced_lumps(lumps, seed, options.friction);
    if (!stack) continue;
    const StandVerdict whole = judge_stack(lumps, *stack, options);
    const StandVerdict ended = judge_stack(lumps, *stack, early);
    EXPECT_EQ(whole.stands, ended.stands) << "seed " << seed;
    if (!whole.stands) continue;
    Stack at_rest = *stack;
    for (std::size_t i = 0; i < whole.T_W_O.size(); ++i) {
      EXPECT_LT(difference(whole.T_W_O[i], ended.T_W_O[i]).translation, 2e-6) << "seed " << seed;
      at_rest.stones[i].T_W_O = whole.T_W_O[i];
    }
    drift.push_back(judge_stack(lumps, at_rest, options).shift);
  }
  ASSERT_GE(drift.size(), 8U);
  // At 240 Hz the median is 65 um: stacks creep that have come to rest.
  std::sort(drift.begin(), drift.end());
  EXPECT_LT(drift[drift.size() / 2], 1e-5);
}

TEST(Settle, DroppedCubeRestsOnTheStackOnly) {
  const ShapeList shapes{box(0.08, 0.08, 0.04), box(0.05, 0.05, 0.05)};
  const Stack stack{{{0_stone, at(0, 0, 0.02)}}};
  const SettleResult result = settle(shapes, stack, 1_stone, at(0.005, 0, 0.067, 0.2));
  ASSERT_TRUE(result.rests) << result.reason;
  EXPECT_NEAR(result.T_W_O.translation().z(), 0.065, 2e-5);
  EXPECT_NEAR(result.travel, 0.002, 2e-4);
  EXPECT_LT(result.kinetic_energy, 1e-6);
  for (const Contact& c : result.contacts) {
    EXPECT_EQ(c.above, 1);
    EXPECT_EQ(c.below, 0);
  }
  const SupportPolygon polygon = support_polygon(result.contacts, result.T_W_O.translation());
  EXPECT_NEAR(polygon.area, 0.0025, 1e-5);
}

TEST(Settle, GivesTheReasonWhereItDoesNotRest) {
  const ShapeList shapes{box(0.06, 0.06, 0.06)};
  const Stack stack{{{0_stone, at(0, 0, 0.03)}}};
  const SettleResult beside = settle(shapes, stack, 0_stone, at(0.08, 0, 0.031));
  EXPECT_FALSE(beside.rests);
  EXPECT_NE(beside.reason.find("table"), std::string::npos) << beside.reason;
  const SettleResult high = settle(shapes, stack, 0_stone, at(0, 0, 0.2));
  EXPECT_FALSE(high.rests);
  EXPECT_NE(high.reason.find("travelled"), std::string::npos) << high.reason;
  EXPECT_THROW(static_cast<void>(settle(shapes, stack, 3_stone, at(0, 0, 1))), InvalidArgument);
}

TEST(StackEquilibrium, AgreesWithTheGeometryOfCubes) {
  const ShapeList shapes{box(0.06, 0.06, 0.06)};
  const Stack stack{{{0_stone, at(0, 0, 0.03)}, {0_stone, at(0.01, 0, 0.09)}}};
  EquilibriumOptions options;
  options.friction = 0.5;
  const Equilibrium result = stack_equilibrium(shapes, stack, options);
  EXPECT_TRUE(result.stands);
  // Both tip about the lower face's edge: the common centre lies 25 mm from it and 60 mm up.
  EXPECT_NEAR(result.margin, 0.025 / 0.06, 2e-3);
  EXPECT_LT(result.min_friction, 0.01);
}

}  // namespace
}  // namespace stonestack::physics
