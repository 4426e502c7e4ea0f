#include <gtest/gtest.h>

#include "pebble.hpp"
#include "simulation/simulated_devices.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::simulation {
namespace {

constexpr double kHalfTurn = 1.5707963267948966;  // 90 deg

/// A pebble on the table, the open gripper over it.
struct Bench {
  SimulationOptions options;
  TrueWorld world;
  CellKeeper nowhere;
  SimulatedGripper gripper;

  explicit Bench(double mass, const SimulationOptions& simulation = {})
      : Bench(make_pebble("pebble", mass), simulation) {}
  explicit Bench(const Stone& stone, const SimulationOptions& simulation)
      : options(simulation), world({stone}, {0_stone}, make_robotiq_3f(), options), gripper(world, nowhere) {
    Pose T_W_O = Pose::Identity();
    double lowest = 0;
    for (const auto& p : world.shapes()[0]->scan.vertices) lowest = std::min(lowest, p.z());
    T_W_O.translation().z() = 0.0005 - lowest;
    GripperPose gripper_pose{tool_down({0, 0, 0.5}), {}};
    gripper_pose.finger.fill(0.0775);
    world.set_gripper_pose(gripper_pose);
    world.place(0_stone, T_W_O);
    (void)world.wait(6.0);
  }

  /// Straight, with a smooth start and end.
  Progress carry(const Pose& T_W_T, double seconds) {
    const GripperPose from = world.gripper_pose();
    return world.advance(seconds, [&](double t) {
      const double s = t / seconds;
      GripperPose gripper_pose = from;
      gripper_pose.T_W_T = interpolate(from.T_W_T, T_W_T, s * s * (3 - 2 * s));
      return gripper_pose;
    });
  }
  [[nodiscard]] Pose T_T_O() const { return world.gripper_pose().T_W_T.inverse() * world.pose(0_stone); }
  /// Fingers round the stone, palm clear of it.
  GripperState grip() {
    const double z = std::max(0.003, world.centre_of_mass(0_stone).z() - 0.020);
    (void)carry(tool_down({0, 0, z}), 1.0);
    return gripper.move(0.0, 0.05, 60.0);
  }
};

class Grasp : public testing::TestWithParam<double> {};

TEST_P(Grasp, HoldsThroughLiftTurnAndTenSeconds) {
  Bench bench(GetParam());
  ASSERT_TRUE(bench.world.rests(0_stone));
  const GripperState gripped = bench.grip();
  EXPECT_TRUE(gripped.object);
  EXPECT_GT(gripped.opening, 0.03);
  EXPECT_GE(bench.world.finger_force()[0], 50.0);
  const Pose T_W_T_lifted = tool_down({0, 0, 0.25});
  ASSERT_EQ(bench.carry(T_W_T_lifted, 1.5).stopped, "");
  const Pose T_T_O_lifted = bench.T_T_O();
  Pose turned = T_W_T_lifted;
  turned.rotate(Eigen::AngleAxisd(kHalfTurn, Eigen::Vector3d::UnitY()));
  ASSERT_EQ(bench.carry(turned, 2.0).stopped, "");
  const auto in_turn = difference(bench.T_T_O(), T_T_O_lifted);
  ASSERT_EQ(bench.world.wait(10.0).stopped, "");
  const auto slip = difference(bench.T_T_O(), T_T_O_lifted);
  EXPECT_LT(slip.translation, 0.002) << in_turn.translation << " m of it in the turn";
  EXPECT_LT(slip.angle, 0.05) << in_turn.angle << " rad of it in the turn";
  EXPECT_NEAR(bench.world.load().force.z(), -9.81 * bench.world.shapes()[0]->mass.mass, 0.3);
}

INSTANTIATE_TEST_SUITE_P(Masses, Grasp, testing::Values(0.4, 1.5, 3.0));

TEST(Grasp, FingersBAndCDrawTogetherAndStillHold) {
  Bench bench(0.8);
  const double before = bench.world.time();
  const GripperModel& model = bench.world.gripper_body().gripper;
  bench.gripper.spread(model.narrow_spacing);
  EXPECT_GT(bench.world.time(), before) << "it takes a while";
  const GripperPose gripper_pose = bench.world.gripper_pose();
  const double apart = (pad_pose(bench.world.gripper_body(), 1, gripper_pose).translation() -
                        pad_pose(bench.world.gripper_body(), 2, gripper_pose).translation())
                           .norm();
  EXPECT_NEAR(apart, model.narrow_spacing, 1e-9);
  EXPECT_TRUE(bench.grip().object);
  ASSERT_EQ(bench.carry(tool_down({0, 0, 0.25}), 1.5).stopped, "");
  ASSERT_EQ(bench.world.wait(5.0).stopped, "");
  EXPECT_GT(bench.world.centre_of_mass(0_stone).z(), 0.2) << "it hangs in the gripper";
  EXPECT_THROW(bench.gripper.spread(0.02), InvalidArgument);
}

/// A carton that lies flat in all three pads: the stiffest grip of the lightest thing.
TEST(Grasp, LightCartonsAreHeldQuietlyByStiffPads) {
  SimulationOptions options;
  options.pad_stiffness = 3e8;  // N/m^3: twice the usual, as in the cell `lab` at most
  options.pad_stiffness_spread = 1.0;
  Stone carton;
  carton.name = "carton";
  carton.scan = carton.mesh = make_box({0.05, 0.08, 0.08});
  carton.density = 300.0;
  carton.mass = mass_properties(carton.scan, carton.density);
  Bench bench(carton, options);
  ASSERT_TRUE(bench.grip().object);
  ASSERT_EQ(bench.carry(tool_down({0, 0, 0.25}), 1.5).stopped, "");
  for (int k = 0; k < 100; ++k) {
    ASSERT_EQ(bench.world.wait(0.01).stopped, "");
    ASSERT_NEAR(bench.world.finger_force()[0], 60.0, 15.0) << "N of a grip at rest, " << k;
  }
  EXPECT_NEAR(bench.world.load().force.z(), -9.81 * bench.world.shapes()[0]->mass.mass, 0.3);
}

TEST(Grasp, SlipsWhenTheForceIsTooSmallForTheWeight) {
  Bench bench(3.0);
  (void)bench.carry(tool_down({0, 0, bench.world.centre_of_mass(0_stone).z() - 0.02}), 1.0);
  (void)bench.gripper.move(0.0, 0.05, 15.0);  // bears 2 * 0.5 * 15 N of 29 N
  (void)bench.carry(tool_down({0, 0, 0.3}), 1.5);
  EXPECT_LT(bench.world.centre_of_mass(0_stone).z(), 0.1);
}

TEST(Grasp, PadsGripStonesDifferentlyFromRunToRun) {
  for (const double spread : {0.0, 0.3}) {
    int held = 0;
    constexpr int kSeeds = 8;
    for (int seed = 1; seed <= kSeeds; ++seed) {
      SimulationOptions options;
      options.seed = seed;
      options.pad_friction_spread = spread;
      options.mass_error = options.com_error = 0.0;
      Bench bench(2.2, options);
      (void)bench.carry(tool_down({0, 0, bench.world.centre_of_mass(0_stone).z() - 0.02}), 1.0);
      (void)bench.gripper.move(0.0, 0.05, 28.0);  // bears 2 * 0.5 * 28 N of 21.6 N
      (void)bench.carry(tool_down({0, 0, 0.3}), 1.5);
      held += bench.world.centre_of_mass(0_stone).z() > 0.1 ? 1 : 0;
    }
    EXPECT_EQ(held == kSeeds, spread == 0.0) << held << " of " << kSeeds << " held, spread " << spread;
    EXPECT_GT(held, 0) << spread;
  }
}

TEST(Grasp, FingersCloseFurtherWhenTheStoneIsRemovedUnlessTheyAreLocked) {
  for (const bool regrip : {true, false}) {
    SimulationOptions options;
    options.regrip = regrip;
    Bench bench(1.5, options);
    const GripperState gripped = bench.grip();
    ASSERT_TRUE(gripped.object);
    bench.world.place(0_stone, make_pose(Eigen::Vector3d(0.5, 0.0, 0.1)));
    (void)bench.world.wait(3.0);
    const GripperState now = bench.gripper.state();
    EXPECT_EQ(now.object, !regrip);
    EXPECT_NEAR(now.opening, regrip ? 0.0 : gripped.opening, 1e-6);
  }
}

TEST(Grasp, OpeningLetsTheStoneDownWhereItIs) {
  Bench bench(1.5);
  (void)bench.grip();
  (void)bench.carry(tool_down({0, 0, 0.2}), 1.0);
  (void)bench.carry(tool_down({0.1, 0, 0.2}), 1.0);
  const double height = bench.world.pose(0_stone).translation().z();
  (void)bench.carry(tool_down({0.1, 0, 0.2 - (height - 0.06)}), 1.0);
  const Eigen::Vector3d before = bench.world.centre_of_mass(0_stone);
  const GripperState open = bench.gripper.move(0.155, 0.05, 15.0);
  EXPECT_FALSE(open.object);
  EXPECT_NEAR(open.opening, 0.155, 1e-6);
  (void)bench.world.wait(6.0);
  (void)bench.carry(tool_down({0.1, 0, 0.4}), 1.0);
  (void)bench.world.wait(1.0);
  EXPECT_TRUE(bench.world.rests(0_stone));
  const Eigen::Vector3d after = bench.world.centre_of_mass(0_stone);
  EXPECT_LT((after - before).head<2>().norm(), 0.02);
  EXPECT_LT(after.z(), before.z() + 0.001);
}

TEST(Grasp, AnOpeningFingerPushesNoHarderThanAsked) {
  FingerDriveState drive{0.07, 0.05, 60.0};
  EXPECT_GT(next_finger_place(drive, 0.05, -59.0, 0.002), 0.05);
  EXPECT_EQ(next_finger_place(drive, 0.05, -60.0, 0.002), 0.05);
}

TEST(Grasp, AStopByForceIsAFaultUntilTheNextMotion) {
  Bench bench(1.0);
  (void)bench.grip();
  EXPECT_EQ(bench.gripper.state().fault, "");
  Pose T_W_O = bench.world.pose(0_stone);
  T_W_O.translation().x() += 0.030;  // into a finger
  bench.world.place(0_stone, T_W_O);
  EXPECT_THROW((void)bench.gripper.move(0.155, 0.05, 60.0), DeviceError);
  EXPECT_NE(bench.gripper.state().fault, "");
  bench.world.place(0_stone, make_pose(Eigen::Vector3d(0.5, 0.0, 0.1)));
  EXPECT_EQ(bench.gripper.move(0.155, 0.05, 60.0).fault, "");
}

TEST(Grasp, ClosesOnNothing) {
  Bench bench(0.4);
  const GripperState closed = bench.gripper.move(0.0, 0.1, 30.0);
  EXPECT_FALSE(closed.object);
  EXPECT_NEAR(closed.opening, 0.0, 1e-6);
}

/// How rubber grips is the world's own, not what plans count on.
TEST(Grasp, OnSlipperyPadsAStoneStaysOnTheTable) {
  SimulationOptions options;
  options.pad_friction = 0.05;
  Bench bench(1.2, options);
  (void)bench.grip();
  (void)bench.carry(tool_down({0, 0, 0.25}), 2.0);
  EXPECT_LT(bench.world.centre_of_mass(0_stone).z(), 0.1);
}

/// One finger against one, on flat jaws and on the arc of its own file.
TEST(Grasp, TwoFingersHoldThroughLiftAndTurn) {
  for (const std::string linkage : {"parallel", "three_finger"}) {
    SimulationOptions options;
    options.linkage = linkage;
    const GripperModel model = read_gripper("robotiq-2f-140");
    TrueWorld world({make_pebble("pebble", 0.8)}, {0_stone}, model, options);
    CellKeeper nowhere;
    SimulatedGripper gripper(world, nowhere);
    Pose T_W_O = Pose::Identity();
    double lowest = 0;
    for (const auto& p : world.shapes()[0]->scan.vertices) lowest = std::min(lowest, p.z());
    T_W_O.translation().z() = 0.0005 - lowest;
    GripperPose start{tool_down({0.004, 0, 0.5}), {}};
    start.finger.fill(0.07);
    world.set_gripper_pose(start);
    world.place(0_stone, T_W_O);
    (void)world.wait(6.0);
    const auto carry = [&](const Pose& T_W_T, double seconds) {
      const GripperPose from = world.gripper_pose();
      return world.advance(seconds, [&](double t) {
        const double s = t / seconds;
        GripperPose pose = from;
        pose.T_W_T = interpolate(from.T_W_T, T_W_T, s * s * (3 - 2 * s));
        return pose;
      });
    };
    const double arc = linkage == "parallel" ? 0.0 : 0.024;  // by which the tips come further
    ASSERT_EQ(carry(tool_down({0.004, 0, world.centre_of_mass(0_stone).z() - 0.015 + arc}), 1.0).stopped, "");
    const GripperState gripped = gripper.move(0.0, 0.05, 100.0);
    EXPECT_TRUE(gripped.object) << linkage;
    const auto& finger = world.gripper_pose().finger;
    EXPECT_EQ(finger[0], finger[1]) << "one motor moves both";
    EXPECT_NEAR(0.5 * (world.finger_force()[0] + world.finger_force()[1]), 100.0, 5.0) << linkage;
    const auto T_T_O = [&] { return world.gripper_pose().T_W_T.inverse() * world.pose(0_stone); };
    Pose up = tool_down({0, 0, 0.25});
    ASSERT_EQ(carry(up, 1.5).stopped, "");
    ASSERT_EQ(world.wait(0.5).stopped, "");
    EXPECT_NEAR(world.finger_force()[0], world.finger_force()[1], 2.0) << "nothing else pushes the stone now";
    const Pose held = T_T_O();
    up.rotate(Eigen::AngleAxisd(kHalfTurn, Eigen::Vector3d::UnitX()));
    ASSERT_EQ(carry(up, 2.0).stopped, "");
    EXPECT_LT(difference(T_T_O(), held).translation, 0.003) << linkage;
    EXPECT_TRUE(gripper.state().object);
    EXPECT_NO_THROW(gripper.spread(0.0));
    EXPECT_THROW(gripper.spread(0.04), InvalidArgument);
  }
}

}  // namespace
}  // namespace stonestack::simulation
