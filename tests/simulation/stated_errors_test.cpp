// The errors of the cell are as large as its options say, measured where the stones are handled.
#include <gtest/gtest.h>

#include "pebble.hpp"
#include "simulation/simulated_devices.hpp"
#include "stonestack/kinematics/forward.hpp"
#include "stonestack/kinematics/inverse.hpp"

namespace stonestack {
namespace {

const RobotModel& ur10() {
  static const RobotModel robot = read_robot("ur10");
  return robot;
}

Joints over(const CellLayout& layout, const Eigen::Vector3d& p_W) {
  const Joints seed = (Joints() << 0.0, -1.57, 1.57, -1.57, -1.57, 0.0).finished();
  return inverse(ur10(), layout.T_W_R.inverse() * tool_down(p_W) * layout.T_F_T.inverse(), seed).front().q;
}

Eigen::Vector3d over_field(const CellLayout& layout, double z) {
  return {layout.field_centre.x(), layout.field_centre.y(), z};
}

TEST(StatedErrors, TheCameraSitsAMillimetreAndThreeTenthsOfADegreeOff) {
  const CellLayout layout;
  const Joints q = over(layout, over_field(layout, 0.45));
  for (int seed = 1; seed <= 20; ++seed) {
    SimulationOptions options;
    options.seed = seed;
    const auto error = difference(draw_mounting(layout, options, ur10(), q).T_T_C, layout.T_T_C);
    EXPECT_NEAR(error.translation, 0.001, 1e-9);
    EXPECT_NEAR(error.angle, 0.3 * M_PI / 180, 1e-6);
  }
}

TEST(StatedErrors, TheTipIsAMillimetreOffWhereStonesArePickedAndPlaced) {
  constexpr int kSeeds = 400;
  const CellLayout layout;
  const Joints start = over(layout, over_field(layout, 0.45));
  for (const Eigen::Vector3d& place :
       {over_field(layout, 0.1), Eigen::Vector3d(layout.site.x(), layout.site.y(), 0.2)}) {
    const Joints q = over(layout, place);
    const auto tip = [&](const Joints& joints) -> Eigen::Vector3d {
      return (layout.T_W_R * forward(ur10(), joints) * layout.T_F_T).translation();
    };
    double squares = 0.0;
    for (int seed = 1; seed <= kSeeds; ++seed) {
      SimulationOptions options;
      options.seed = seed;
      const Joints error = draw_mounting(layout, options, ur10(), start).joint_error;
      squares += (tip(q + error) - tip(q)).squaredNorm() / kSeeds;
    }
    EXPECT_NEAR(std::sqrt(squares), 0.001, 0.0001) << place.transpose();
  }
}

TEST(StatedErrors, TheArmComesBackToATenthOfAMillimetre) {
  const CellLayout layout;
  SimulationOptions options;
  TrueWorld world({make_pebble("absent", 0.5)}, {0}, make_robotiq_3f(), options);
  world.put_away(0);
  const Joints home = over(layout, over_field(layout, 0.3));
  const Joints away = over(layout, {layout.site.x(), layout.site.y(), 0.3});
  const TrueMounting mounting = draw_mounting(layout, options, ur10(), home);
  SimulatedForceTorque force_torque(world, mounting, options);
  SimulatedArm arm(world, ur10(), mounting, force_torque, options, home);
  constexpr int kVisits = 150;
  double squares = 0.0;
  for (int k = 0; k < kVisits; ++k) {
    for (const Joints& goal : {away, home}) {
      JointTrajectory way;
      way.time = {0.0, 2.0};
      way.q = {arm.state().q, goal};
      way.qd = {Joints::Zero(), Joints::Zero()};
      ASSERT_EQ(arm.follow(way).status, MotionResult::Status::kDone);
    }
    const Eigen::Vector3d off = world.hand().T_W_T.translation() - arm.true_T_W_T(home).translation();
    squares += off.squaredNorm() / kVisits;
  }
  EXPECT_NEAR(std::sqrt(squares), 0.0001, 0.00001);
}

}  // namespace
}  // namespace stonestack
