// The errors of the cell are as large as its options state, measured where the stones are handled.
#include <gtest/gtest.h>

#include "cell_bench.hpp"
#include "core/constants.hpp"
#include "simulation/shared_world.hpp"
#include "simulation/simulated_devices.hpp"
#include "simulation/true_shape.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::simulation {
namespace {

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
  TrueWorld world({make_pebble("absent", 0.5)}, {0_stone}, make_robotiq_3f(), options);
  world.put_away(0_stone);
  const Joints home = over(layout, over_field(layout, 0.3));
  const Joints away = over(layout, {layout.site.x(), layout.site.y(), 0.3});
  const TrueMounting mounting = draw_mounting(layout, options, ur10(), home);
  SimulatedForceTorque force_torque(world, mounting, options);
  CellKeeper nowhere;
  SimulatedArm arm(world, make_agile(), mounting, force_torque, nowhere, options, home, layout);
  constexpr int kVisits = 150;
  double squares = 0.0;
  for (int k = 0; k < kVisits; ++k) {
    for (const Joints& goal : {away, home}) {
      JointTrajectory trajectory;
      trajectory.time = {0.0, 2.0};
      trajectory.q = {arm.state().q, goal};
      trajectory.qd = {Joints::Zero(), Joints::Zero()};
      ASSERT_EQ(arm.follow(trajectory).status, MotionResult::Status::kDone);
    }
    const Eigen::Vector3d off = world.gripper_pose().T_W_T.translation() - arm.true_T_W_T(home).translation();
    squares += off.squaredNorm() / kVisits;
  }
  EXPECT_NEAR(std::sqrt(squares), 0.0001, 0.00001);
}

TEST(StatedErrors, SurfacesDeviateFromTheirScansAsStated) {
  const std::vector<Stone> scanned{make_pebble("a", 1.0), make_pebble("b", 1.0)};
  SimulationOptions options;
  const std::vector<Stone> same = as_they_are(scanned, options);
  EXPECT_EQ(same[0].scan.vertices, scanned[0].scan.vertices);
  options.scan_error = 0.0003;
  const std::vector<Stone> real = as_they_are(scanned, options);
  const auto off = [&](std::size_t stone, int vertex) {
    const auto i = static_cast<std::size_t>(vertex);
    const Eigen::Vector3d d = real[stone].scan.vertices[i] - scanned[stone].scan.vertices[i];
    return std::copysign(d.norm(), d.dot(scanned[stone].scan.vertices[i]));
  };
  // Waves of 20 mm in all directions: what neighbours share falls with their distance as sin(x) / x.
  const auto shared = [&](const Eigen::Vector3i& face) {
    const auto& p = scanned[0].scan.vertices;
    const double x =
        kTwoPi / 0.020 * (p[static_cast<std::size_t>(face[0])] - p[static_cast<std::size_t>(face[1])]).norm();
    return std::sin(x) / x;
  };
  double squares = 0.0, steps = 0.0, expected = 0.0;
  for (const auto& face : scanned[0].scan.faces) {
    squares += off(0, face[0]) * off(0, face[0]);
    steps += std::pow(off(0, face[0]) - off(0, face[1]), 2);
    expected += 2.0 * 0.0003 * 0.0003 * (1.0 - shared(face));
  }
  const auto faces = static_cast<double>(scanned[0].scan.faces.size());
  EXPECT_NEAR(std::sqrt(squares / faces), 0.0003, 0.00003);
  EXPECT_NEAR(std::sqrt(steps / expected), 1.0, 0.2) << "neighbours err alike";
  EXPECT_NE(off(0, 0), off(1, 0)) << "each stone has its own error";
  EXPECT_TRUE(is_closed(real[0].scan));

  SimulatedCell cell(scanned, {0_stone, 1_stone}, ur10(), {},
                     options);  // and the cell has them, not the scans
  EXPECT_EQ(cell.shared().stones()[0].scan.vertices, real[0].scan.vertices);
  EXPECT_EQ(cell.shared().lock().world.shapes()[1]->scan.vertices, real[1].scan.vertices);
}

}  // namespace
}  // namespace stonestack::simulation
