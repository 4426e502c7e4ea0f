// Errors of a lab, measured from outside: tips over the workspace, stones in the gripper,
// spheres in pictures, signals over time.
#include <gtest/gtest.h>

#include <functional>

#include "cell_bench.hpp"
#include "core/constants.hpp"
#include "simulation/simulated_devices.hpp"
#include "simulation/true_shape.hpp"
#include "simulation/true_view.hpp"

namespace stonestack::simulation {
namespace {

using Status = MotionResult::Status;

SimulationOptions ideal(int seed = 1) {
  SimulationOptions options = options_of_cell("ideal");
  options.seed = seed;
  return options;
}

Stone make_block(const std::string& name) {
  Stone stone;
  stone.name = name;
  stone.scan = stone.mesh = make_box({0.10, 0.08, 0.03});
  stone.mass = mass_properties(stone.scan, 2600);
  return stone;
}

// ---- the stones

/// Offset of each vertex from the scan of a sphere of 60 mm radius, outwards.
std::vector<double> offsets(const Stone& scanned, const SimulationOptions& options) {
  const Mesh real = as_they_are({scanned}, options)[0].scan;
  std::vector<double> off;
  for (std::size_t i = 0; i < real.vertices.size(); ++i)
    off.push_back(real.vertices[i].norm() - scanned.scan.vertices[i].norm());
  return off;
}

/// Correlation of the offsets of vertices so far apart, within a tenth.
double correlation(const Stone& stone, const std::vector<double>& off, double apart) {
  double together = 0.0, squares = 0.0;
  int pairs = 0;
  const auto& p = stone.scan.vertices;
  for (std::size_t i = 0; i < p.size(); i += 3)
    for (std::size_t j = 0; j < p.size(); ++j) {
      if (std::abs((p[i] - p[j]).norm() - apart) > 0.1 * apart) continue;
      together += off[i] * off[j];
      squares += 0.5 * (off[i] * off[i] + off[j] * off[j]);
      ++pairs;
    }
  EXPECT_GT(pairs, 100);
  return together / squares;
}

double rms(const std::vector<double>& values) {
  double squares = 0.0;
  for (const double value : values) squares += value * value;
  return std::sqrt(squares / static_cast<double>(values.size()));
}

TEST(RealErrors, SurfacesLieBesideTheirScansInWaves) {
  Stone ball;
  ball.name = "ball";
  ball.scan = make_sphere(0.06, 5);  // edges of 2 mm
  SimulationOptions options = ideal();
  options.scan_error = 0.0003;
  const auto slow = offsets(ball, options);
  EXPECT_NEAR(rms(slow), 0.0003, 0.00002);
  EXPECT_GT(correlation(ball, slow, 0.0025), 0.85);
  EXPECT_NEAR(correlation(ball, slow, 0.010), 0.0, 0.12) << "half a wave of 20 mm away";
  options.scan_error = 0.0;
  options.scan_roughness = 0.0001;
  const auto rough = offsets(ball, options);
  EXPECT_NEAR(rms(rough), 0.0001, 0.00001);
  EXPECT_LT(std::abs(correlation(ball, rough, 0.0025)), 0.3);
  options.scan_error = 0.0003;
  const Mesh both = as_they_are({ball}, options)[0].scan;
  EXPECT_NEAR(rms(offsets(ball, options)), std::hypot(0.0003, 0.0001), 0.00003);
  EXPECT_TRUE(is_closed(both));
  const auto before = face_normals(ball.scan), after = face_normals(both);
  for (std::size_t i = 0; i < before.size(); ++i)
    EXPECT_GT(before[i].dot(after[i]), 0.5) << "no face folds over";
}

/// True if a block on another starts to slide when the table is tilted to that slope.
bool slides(const SimulationOptions& options, double slope) {
  TrueWorld world({make_block("below"), make_block("above")}, {0_stone, 1_stone}, make_robotiq_3f(), options);
  world.place(0_stone, make_pose(Eigen::Vector3d(0, 0, 0.015)));
  world.place(1_stone, make_pose(Eigen::Vector3d(0, 0, 0.045)));
  const auto judge = world.judge_world(0.001, 200);
  const double angle = std::atan(slope);
  judge->set_gravity(kGravity * Eigen::Vector3d(std::sin(angle), 0, -std::cos(angle)));
  for (int step = 0; step < 500; ++step) {
    judge->place(0, world.pose(0_stone), {});  // held
    judge->step(0.001);
  }
  return judge->pose(1).translation().x() > 0.002;
}

TEST(RealErrors, StonesSlideOnEachOtherBetweenTheStatedFrictions) {
  for (const auto& [cell, low, high] : {std::tuple{"lab", 0.30, 0.65}, std::tuple{"paper", 0.10, 0.20}}) {
    int slippery = 0;
    constexpr int kSeeds = 12;
    for (int seed = 1; seed <= kSeeds; ++seed) {
      SimulationOptions options = ideal(seed);
      options.friction = options_of_cell(cell).friction;
      options.friction_spread = options_of_cell(cell).friction_spread;
      EXPECT_FALSE(slides(options, 0.95 * low)) << cell << " " << seed;
      EXPECT_TRUE(slides(options, 1.05 * high)) << cell << " " << seed;
      if (slides(options, 0.5 * (low + high))) ++slippery;
    }
    EXPECT_GT(slippery, 1) << cell;
    EXPECT_LT(slippery, kSeeds - 1) << cell;
  }
}

// ---- the arm

TEST(RealErrors, TheTipIsOffByOtherLinksDifferentlyOverTheCell) {
  const CellLayout layout;
  const Joints start = over(layout, {0.7, -0.18, 0.45});
  double total = 0.0;
  constexpr int kSeeds = 20;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    SimulationOptions options = ideal(seed);
    options.arm_kinematics = options_of_cell("lab").arm_kinematics;
    const TrueMounting mounting = draw_mounting(layout, options, ur10(), start);
    std::vector<Eigen::Vector3d> off;
    for (const double x : {0.5, 0.6, 0.7, 0.8, 0.9})
      for (const double y : {-0.4, -0.2, 0.0, 0.2, 0.3})
        for (const double z : {0.03, 0.2}) {
          const Joints q = over(layout, {x, y, z});
          off.push_back((forward(mounting.robot, q) * layout.T_F_T).translation() -
                        (forward(ur10(), q) * layout.T_F_T).translation());
        }
    double mean = 0.0, spread = 0.0;
    for (const auto& a : off) {
      mean += a.norm() / static_cast<double>(off.size());
      for (const auto& b : off) spread = std::max(spread, (a - b).norm());
    }
    EXPECT_GT(mean, 0.0005) << seed;
    EXPECT_LT(mean, 0.001) << seed;
    EXPECT_GT(spread, 0.0001) << seed << ": the error differs from place to place";
    total += mean / kSeeds;
  }
  EXPECT_NEAR(total, 0.00073, 0.0001);
}

TEST(RealErrors, AJointThatTurnsBackLagsByItsBacklash) {
  SimulationOptions options = ideal();
  options.arm_backlash = 0.0004;
  CellBench bench({make_pebble("pebble", 1.2)}, options);
  const Pose home = tool_down({0.7, 0.1, 0.3});
  const auto arrive_from = [&](double y) {
    EXPECT_EQ(bench.go(tool_down({0.7, y, 0.3})).status, Status::kDone);
    EXPECT_EQ(bench.go(home).status, Status::kDone);
    return bench.simulated.world().gripper_pose().T_W_T.translation().eval();
  };
  const Eigen::Vector3d left = arrive_from(0.0), right = arrive_from(0.2);
  EXPECT_LT((arrive_from(0.0) - left).norm(), 1e-6) << "the same side, the same place";
  EXPECT_GT((left - right).norm(), 0.0001);
  EXPECT_LT((left - right).norm(), 0.0008);
  EXPECT_LT(left.y(), right.y()) << "each short of the goal on its side";
}

TEST(RealErrors, TheArmSagsUnderAStone) {
  SimulationOptions options = ideal();
  options.arm_compliance = 3e-5;
  CellBench bench({make_pebble("pebble", 1.5)}, options);
  const auto sag = [&] {
    const double stated = bench.T_W_T(bench.cell.arm.state().q).translation().z();
    return stated - bench.simulated.world().gripper_pose().T_W_T.translation().z();
  };
  const Eigen::Vector3d p = bench.centre(0_stone);
  const double yaw = bench.yaw(0_stone), low = std::max(0.004, p.z() - 0.015);
  ASSERT_EQ(bench.go(tool_down({p.x(), p.y(), 0.25}, yaw)).status, Status::kDone);
  EXPECT_NEAR(sag(), 0.0, 1e-6);
  ASSERT_EQ(bench.go(tool_down({p.x(), p.y(), low}, yaw), 0.1).status, Status::kDone);
  ASSERT_TRUE(bench.cell.gripper.move(0.0, 0.05, 60.0).object);
  ASSERT_EQ(bench.go(tool_down({0.7, -0.18, 0.25}, yaw), 0.1).status, Status::kDone);
  bench.simulated.wait(0.5);
  const double expected = 3e-5 * 9.81 * bench.stones[0].mass.mass;
  EXPECT_NEAR(sag(), expected, 0.25 * expected);
}

TEST(RealErrors, TheBaseStandsBesideItsStatedPlace) {
  const CellLayout layout;
  const Joints q = over(layout, {0.7, -0.18, 0.45});
  for (int seed = 1; seed <= 5; ++seed) {
    SimulationOptions options = ideal(seed);
    options.base_translation = 0.002;
    options.base_rotation = 0.00349066;
    const auto off = difference(draw_mounting(layout, options, ur10(), q).T_W_R, layout.T_W_R);
    EXPECT_NEAR(off.translation, 0.002, 1e-9);
    EXPECT_NEAR(off.angle, 0.00349066, 1e-6);
    CellBench bench({make_pebble("pebble", 1.2)}, options);
    const Eigen::Vector3d stated = bench.T_W_T(bench.cell.arm.state().q).translation();
    const double tip = (bench.simulated.world().gripper_pose().T_W_T.translation() - stated).norm();
    EXPECT_GT(tip, 0.0002);
    EXPECT_LT(tip, 0.002 + 0.00349066 * 1.0);
  }
}

// ---- the gripper

/// Final opening on the same stone with the pads of this seed.
double gripped_opening(int seed, double spread) {
  SimulationOptions options = ideal(seed);
  options.pad_stiffness_spread = spread;
  TrueWorld world({make_pebble("pebble", 1.2)}, {0_stone}, make_robotiq_3f(), options);
  double lowest = 0;
  for (const auto& p : world.shapes()[0]->scan.vertices) lowest = std::min(lowest, p.z());
  GripperPose gripper_pose{tool_down({0, 0, std::max(0.003, -lowest - 0.015)}), {}};
  gripper_pose.finger.fill(0.0775);
  world.set_gripper_pose(gripper_pose);
  world.place(0_stone, make_pose(Eigen::Vector3d(0, 0, 0.0002 - lowest)));
  (void)world.wait(1.0);
  CellKeeper nowhere;
  SimulatedGripper gripper(world, nowhere);
  return gripper.move(0.0, 0.05, 60.0).opening;
}

TEST(RealErrors, PadsOfDifferentRunsYieldDifferently) {
  const double plain = gripped_opening(1, 1.0);
  EXPECT_EQ(plain, gripped_opening(2, 1.0));
  double softest = plain, stiffest = plain;
  for (int seed = 1; seed <= 6; ++seed) {
    const double opening = gripped_opening(seed, 2.0);
    softest = std::min(softest, opening);
    stiffest = std::max(stiffest, opening);
  }
  EXPECT_LT(softest, plain - 0.0002);
  EXPECT_GT(stiffest, plain + 0.0002);
  EXPECT_GT(softest, plain - 0.006);
}

// ---- the wrist sensor

/// A world without stones near, the gripper over an empty table, and its sensor.
struct Wrist {
  SimulationOptions options;
  TrueWorld world;
  TrueMounting mounting;
  SimulatedForceTorque sensor;

  explicit Wrist(const SimulationOptions& o)
      : options(o),
        world({make_pebble("absent", 0.5)}, {0_stone}, make_robotiq_3f(), options),
        mounting(draw_mounting({}, options, ur10(), over({}, {0.7, -0.18, 0.45}))),
        sensor(world, mounting, options) {
    world.put_away(0_stone);
    world.set_gripper_pose({tool_down({0.7, 0, 0.1}), {}});
  }
  /// The tip's height over time.
  void follow(double seconds, const std::function<double(double)>& z) {
    const double begin = world.time();
    (void)world.advance(seconds, [&](double t) {
      return GripperPose{tool_down({0.7, 0, z(begin + t)}), {}};
    });
  }
};

TEST(RealErrors, ForceReadingsAreLateByCrossCorrelation) {
  for (const double delay : {0.0, 0.030}) {
    SimulationOptions options = ideal();
    options.force_delay = delay;
    Wrist wrist(options);
    std::vector<double> pressed, read;
    wrist.follow(0.05, [](double) { return 0.0; });
    for (int k = 0; k < 300; ++k) {
      wrist.follow(0.010, [](double t) { return -0.0002 * (1 + std::sin(20 * t) * std::cos(7 * t)); });
      pressed.push_back(wrist.world.load().force.z());
      read.push_back(-wrist.sensor.measure().force.z());  // z of the flange points down
    }
    const auto correlation = [&](std::size_t lag) {
      const std::size_t n = pressed.size() - 10;
      double a = 0, b = 0, ab = 0, aa = 0, bb = 0;
      for (std::size_t k = 0; k < n; ++k) {
        a += pressed[k] / static_cast<double>(n);
        b += read[k + lag] / static_cast<double>(n);
      }
      for (std::size_t k = 0; k < n; ++k) {
        ab += (pressed[k] - a) * (read[k + lag] - b);
        aa += (pressed[k] - a) * (pressed[k] - a);
        bb += (read[k + lag] - b) * (read[k + lag] - b);
      }
      return ab / std::sqrt(aa * bb);
    };
    std::size_t best = 0;
    for (std::size_t lag = 1; lag < 10; ++lag)
      if (correlation(lag) > correlation(best)) best = lag;
    EXPECT_EQ(best, static_cast<std::size_t>(std::lround(delay / 0.010)));
    EXPECT_GT(correlation(best), 0.999);
  }
}

TEST(RealErrors, TheWristFeelsTheGripperAccelerate) {
  for (const bool inertia : {false, true}) {
    SimulationOptions options = ideal();
    options.gripper_inertia = inertia;
    Wrist wrist(options);
    wrist.follow(0.3, [](double) { return 0.1; });
    const double at_rest = wrist.sensor.measure().force.z();
    constexpr double kAcceleration = 1.5;
    const double begin = wrist.world.time();
    wrist.follow(0.3, [&](double t) { return 0.1 + 0.5 * kAcceleration * (t - begin) * (t - begin); });
    const double extra = wrist.sensor.measure().force.z() - at_rest;
    const double mass = sensed_mass(wrist.world.gripper_body().gripper);
    EXPECT_NEAR(extra, inertia ? mass * kAcceleration : 0.0, 0.02 * mass)
        << "it seems heavier while it is lifted";
  }
}

TEST(RealErrors, TheZeroOfTheWristDrifts) {
  SimulationOptions options = ideal();
  options.force_drift = 0.02;
  Wrist wrist(options);
  std::vector<Eigen::Vector3d> forces;
  for (int k = 0; k < 60; ++k) {
    (void)wrist.world.wait(5.0);
    forces.push_back(wrist.sensor.measure().force);
  }
  double fastest = 0.0;
  for (std::size_t k = 1; k < forces.size(); ++k)
    fastest = std::max(fastest, (forces[k] - forces[k - 1]).norm() / 5.0);
  EXPECT_NEAR(fastest, 0.02, 0.001);
}

// ---- the camera

/// Middle of a sphere in the picture, px. The camera looks down from the origin's place on a table without
/// edge.
Eigen::Vector2d seen_at(const SimulationOptions& options, const Eigen::Vector3d& p_C) {
  Stone ball;
  ball.scan = make_sphere(0.02, 4);
  SeenWorld world;
  world.table = transformed(make_box({4, 4, 0.01}), make_pose(Eigen::Vector3d(0, 0, 1.2)));
  world.stones = {{0_stone, make_pose(p_C)}};
  Random random(1);
  const DepthImage image = true_view(world, {ball}, Pose::Identity(), choose_sensor(options), random);
  Eigen::Vector2d sum(0, 0);
  int count = 0;
  for (int v = 0; v < image.camera.height; ++v)
    for (int u = 0; u < image.camera.width; ++u)
      if (const float z = image.at(u, v); z > 0 && z < 0.9F) {
        sum += Eigen::Vector2d(u, v);
        ++count;
      }
  EXPECT_GT(count, 100);
  const CameraIntrinsics plain;
  EXPECT_EQ(image.camera.fx, plain.fx) << "the camera does not know";
  EXPECT_EQ(image.camera.cx, plain.cx);
  EXPECT_EQ(image.camera.k[0], 0.0);
  return sum / count;
}

TEST(RealErrors, TheLensIsOffByWhatCalibrationLeftOver) {
  const auto off = [](const SimulationOptions& options, double x, double y) {
    const Eigen::Vector3d p(x, y, 0.7);
    return Eigen::Vector2d(seen_at(options, p) - seen_at(ideal(options.seed), p));
  };
  for (int seed = 1; seed <= 3; ++seed) {
    SimulationOptions options = ideal(seed);
    options.lens_centre = 1.0;
    EXPECT_NEAR(off(options, 0, 0).norm(), 1.0, 0.15);
    EXPECT_NEAR(off(options, 0.3, 0.2).norm(), 1.0, 0.15);
    options = ideal(seed);
    options.lens_focal = 0.01;  // larger than in a lab, to be seen in whole pixels
    EXPECT_NEAR(off(options, 0, 0).norm(), 0.0, 0.1);
    EXPECT_NEAR(off(options, 0.3, 0).norm(), 0.01 * 475 * 0.3 / 0.7, 0.2);
    options = ideal(seed);
    options.lens_distortion = 4.0;
    EXPECT_NEAR(off(options, 0, 0).norm(), 0.0, 0.1);
    const double radius = 475 * std::hypot(0.35, 0.26) / 0.7;
    EXPECT_NEAR(off(options, 0.35, 0.26).norm(), 4.0 * std::pow(radius / 400.0, 3), 0.4);
  }
}

TEST(RealErrors, ADoubledSensorErrsTwiceAsMuch) {
  SimulationOptions options;
  options.sensor = "f200";
  const SensorModel plain = choose_sensor(options);
  options.sensor_scale = 2.0;
  const SensorModel twice = choose_sensor(options);
  EXPECT_DOUBLE_EQ(twice.sigma, 2 * plain.sigma);
  EXPECT_DOUBLE_EQ(twice.bias, 2 * plain.bias);
  EXPECT_LE(twice.edge_flying + twice.edge_holes, 1.0);
  EXPECT_GT(twice.edge_flying, plain.edge_flying);
}

// ---- what no catalogue has

TEST(RealErrors, ForeignObjectsLieAmongTheStonesAndAreSeen) {
  SimulationOptions options = ideal();
  options.foreign_objects = 2;
  CellBench bench({make_pebble("pebble", 1.2)}, options);
  const auto truth = bench.simulated.truth();
  ASSERT_EQ(truth.T_W_O.size(), 3u);
  const auto image = bench.cell.camera.capture().image;
  const Pose T_C_W = (bench.T_W_T(bench.cell.arm.state().q) * bench.layout.T_T_C).inverse();
  for (std::size_t i = 1; i < 3; ++i) {
    EXPECT_TRUE(bench.simulated.world().is_foreign(StoneIndex(i)));
    const Eigen::Vector3d p = truth.T_W_O[i].translation();
    EXPECT_LT(std::abs(p.x() - bench.layout.field_centre.x()), 0.5 * bench.layout.field_size.x());
    const Eigen::Vector3d p_C = T_C_W * p;
    const Eigen::Vector2d uv = project(image.camera, p_C);
    EXPECT_LT(image.at(static_cast<int>(uv.x()), static_cast<int>(uv.y())), p_C.z() - 0.01) << i;
    EXPECT_GT(image.at(static_cast<int>(uv.x()), static_cast<int>(uv.y())), 0.0F) << i;
  }
  EXPECT_FALSE(bench.simulated.world().is_foreign(0_stone));
  EXPECT_TRUE(bench.simulated.world().rests(1_stone) && bench.simulated.world().rests(2_stone));
}

}  // namespace
}  // namespace stonestack::simulation
