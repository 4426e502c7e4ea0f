#include "simulation/finger_linkage.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "cell_bench.hpp"
#include "motion/grasp/finger_reach.hpp"
#include "pebble.hpp"
#include "simulation/simulated_devices.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/motion/pick_and_place.hpp"

namespace stonestack::simulation {
namespace {

using Kind = motion::PlanStep::Kind;

const GripperModel kFlatJaws = make_robotiq_3f(), kThreeFingers = make_robotiq_3f(Linkage::kThreeFinger);

/// Distance from the middle (x) and height over the mount (y) of the pad's edge at the tip [m], joints 1 to 3
/// turned by `theta`: robotiq-3f-gripper_articulated_macro.xacro and ..._finger_articulated_macro.xacro of
/// ros-industrial, multiplied out link by link. The palm's frame lies 57.4 mm before the mount. From the
/// meshes: last phalanx 38.1 mm long with a plate of 7.94 mm; rubber of 3.17 mm makes the opening 155 mm.
Eigen::Vector2d published_pad(const std::array<double, 3>& theta) {
  using Transform = Eigen::Isometry2d;
  const auto turn = [](double angle) { return Transform(Eigen::Rotation2Dd(angle)); };
  const auto shift = [](double x, double y) { return Transform(Eigen::Translation2d(x, y)); };
  // x of a finger points out of the palm, y towards the middle.
  const Transform T_palm_tip = shift(0.0214 + 0.020, 0.0) * turn(theta[0]) * shift(0.050, -0.028) *
                               turn(-0.52) * turn(theta[1]) * shift(0.039, 0.0) * turn(theta[2]) * turn(0.52);
  const Eigen::Vector2d p = T_palm_tip * Eigen::Vector2d(0.0381, 0.00794 + 0.00317);
  return {0.0455 - p.y(), 0.0574 + p.x()};
}

TEST(FingerLinkage, TipsFollowThePublishedPhalanges) {
  const Eigen::Vector2d open = published_pad({0.0495, 0.0, -0.0495});
  EXPECT_NEAR(open.x(), 0.0775, 0.0002);
  EXPECT_NEAR(open.y(), 0.223, 0.0001) << "as the published mesh of the open gripper";
  double highest = 0.0;
  for (double theta = 0.0495; published_pad({theta, 0.0, -theta}).x() > 0.0; theta += 0.01) {
    const Eigen::Vector2d pad = published_pad({theta, 0.0, -theta});
    EXPECT_NEAR(finger_linkage(pad.x()).tip, pad.y(), 0.0001) << pad.x();
    EXPECT_NEAR(finger_linkage(pad.x()).theta_1, theta, 0.001) << pad.x();
    highest = std::max(highest, pad.y());
  }
  EXPECT_NEAR(finger_linkage(0.0775).tip, 0.2230, 0.0002) << "fully open";
  EXPECT_NEAR(finger_linkage(0.0).tip, 0.2268, 0.0002) << "pads together";
  EXPECT_NEAR(highest, 0.2332, 0.0002) << "opened by 69 mm";
  EXPECT_NEAR(finger_linkage(0.0345).tip, highest, 0.0001);
  EXPECT_EQ(finger_linkage(0.2).tip, finger_linkage(0.0776).tip) << "the joint's stop";
}

/// Foremost in the fist, which fingers make that close on nothing, is the knuckle: the mesh of the closed
/// gripper ends there, 173 mm from the mount. No pinch gets near that.
TEST(FingerLinkage, APinchDoesNotSinkAsAFistDoes) {
  constexpr double kKnuckleRadius = 0.0279;  // of the second phalanx about its joint, from the mesh
  const double theta = 1.1345;               // 65 deg, where the first phalanx stops
  const double fist = 0.0574 + 0.0414 +
                      std::hypot(0.050, 0.028) * std::cos(theta - std::atan2(0.028, 0.050)) + kKnuckleRadius;
  EXPECT_NEAR(fist, 0.173, 0.001);
  for (double place = 0.0; place <= 0.0775; place += 0.0025)
    EXPECT_GT(finger_linkage(place).tip, fist + 0.045);
}

TEST(FingerLinkage, ThePlannersModelIsAnotherOneWithinHalfAMillimetre) {
  double most = 0.0;
  for (double opening = 0.0; opening <= 0.155; opening += 0.001) {
    const double difference = std::abs(motion::tip_advance(kThreeFingers, opening) -
                                       (finger_linkage(0.5 * opening).tip - kOpenTip));
    EXPECT_LT(difference, 0.0006) << opening;
    most = std::max(most, difference);
  }
  EXPECT_GT(most, 0.0002) << "a table is not the linkage";
}

GripperPose opened(double opening) {
  GripperPose pose;
  pose.finger.fill(0.5 * opening);
  return pose;
}

TEST(FingerLinkage, PadsAndPhalangesMoveTogether) {
  const GripperBody body = make_gripper_body(kFlatJaws, "three_finger");
  const GripperBody flat = make_gripper_body(kFlatJaws);
  for (const double opening : {0.155, 0.12, 0.07, 0.03, 0.0}) {
    const GripperPose pose = opened(opening);
    const double tip = finger_linkage(0.5 * opening).tip - kOpenTip;
    for (int f = 0; f < kFingers; ++f) {
      const Eigen::Vector3d pad = pad_pose(body, f, pose).translation(),
                            still = pad_pose(flat, f, pose).translation();
      EXPECT_NEAR(pad.z(), tip - 0.5 * body.gripper.pad_length, 1e-12);
      EXPECT_NEAR(still.z(), -0.5 * body.gripper.pad_length, 1e-12);
      EXPECT_NEAR(pad.x(), still.x(), 1e-12);
      EXPECT_NEAR(pad.y(), still.y(), 1e-12);
    }
    double highest = -1.0;
    for (const GripperPart& part : body.boxes) {
      if (part.finger < 0) continue;
      for (int corner = 0; corner < 8; ++corner) {
        const Eigen::Vector3d sign(corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5, corner & 4 ? 0.5 : -0.5);
        const Eigen::Vector3d p = box_pose(body, part, pose) * sign.cwiseProduct(part.size);
        highest = std::max(highest, p.z());
        if (p.z() > tip - body.gripper.pad_length) {
          EXPECT_GE(part.side * p.x(), 0.5 * opening + body.pad.thickness - 1e-9)
              << "bone stands in the rubber";
        }
      }
    }
    EXPECT_NEAR(highest, tip, 1e-9);
  }
  EXPECT_THROW((void)make_gripper_body(kFlatJaws, "scissor"), InvalidArgument);
}

/// Plans keep other objects clear of what the fingers take outwards, too: the knuckles.
TEST(FingerLinkage, ThePlannersBoxesEncloseTheTrueKnuckles) {
  const GripperBody body = make_gripper_body(kFlatJaws, "three_finger");
  for (double opening = 0.02; opening <= 0.12; opening += 0.01) {
    const GripperPose pose = opened(opening);
    for (const GripperPart& part : body.boxes) {
      if (part.finger < 0) continue;
      for (double along = -0.5; along <= 0.5; along += 0.05) {
        const Eigen::Vector3d outside(0.5 * part.side * part.size.x(), 0.0, along * part.size.z());
        const Eigen::Vector3d p = box_pose(body, part, pose) * outside;
        if (p.z() < -0.112) continue;  // beside the palm
        double nearest = 1.0;
        for (const motion::GripperBox& box : kThreeFingers.boxes) {
          const Eigen::Vector3d d = p - motion::box_centre(kThreeFingers, box, opening);
          nearest = std::min(nearest, (d.cwiseAbs() - 0.5 * box.size).cwiseMax(0.0).norm());
        }
        EXPECT_LT(nearest, 0.0025) << "finger " << part.finger << " at " << p.transpose() << ", opened by "
                                   << opening;
      }
    }
  }
}

/// A pebble on the table below the open gripper.
struct PinchBench {
  TrueWorld world;
  CellKeeper nowhere;
  SimulatedGripper gripper{world, nowhere};

  PinchBench(double mass, const std::string& linkage)
      : world({make_pebble("pebble", mass)}, {0_stone}, make_robotiq_3f(), with(linkage)) {
    double lowest = 0.0;
    for (const auto& p : world.shapes()[0]->scan.vertices) lowest = std::min(lowest, p.z());
    GripperPose pose = opened(0.155);
    pose.T_W_T = tool_down({0, 0, 0.5});
    world.set_gripper_pose(pose);
    world.place(0_stone, make_pose(Eigen::Vector3d(0, 0, 0.0005 - lowest)));
    (void)world.wait(6.0);
  }
  static SimulationOptions with(const std::string& linkage) {
    SimulationOptions options = options_of_cell("ideal");
    options.linkage = linkage;
    return options;
  }
  /// Straight to T_W_T.
  Progress carry(const Pose& T_W_T, double seconds) {
    const GripperPose from = world.gripper_pose();
    return world.advance(seconds, [&](double t) {
      const double s = t / seconds;
      GripperPose pose = from;
      pose.T_W_T = interpolate(from.T_W_T, T_W_T, s * s * (3 - 2 * s));
      return pose;
    });
  }
};

TEST(FingerLinkage, TruePadsFollowItWhileTheyCloseOnAStoneAndHoldIt) {
  PinchBench bench(1.2, "three_finger");
  const double low = 0.014;
  ASSERT_EQ(bench.carry(tool_down({0, 0, low}), 1.5).stopped, "");
  double last = 0.155, highest = 0.0;
  for (double target = 0.15; target > 0.0; target -= 0.01) {
    const GripperState state = bench.gripper.move(target, 0.05, 60.0);
    for (int f = 0; f < kFingers; ++f) {
      const double place = bench.world.gripper_pose().finger[static_cast<std::size_t>(f)];
      const Pose T_W_P = pad_pose(bench.world.gripper_body(), f, bench.world.gripper_pose());
      const double below =
          low - (T_W_P.translation().z() - 0.5 * bench.world.gripper_body().gripper.pad_length);
      EXPECT_NEAR(below, finger_linkage(place).tip - 0.223, 1e-6) << "finger " << f << " at " << place;
      highest = std::max(highest, below);
    }
    last = state.opening;
    if (state.object) break;
  }
  EXPECT_GT(last, 0.05);
  EXPECT_GT(highest, 0.006) << "the tips came towards the table";
  EXPECT_GT(lowest_corner(bench.world.gripper_body(), bench.world.gripper_pose()).z(), 0.0);
  (void)bench.gripper.move(0.0, 0.05, 60.0);
  ASSERT_EQ(bench.carry(tool_down({0, 0, 0.25}), 1.5).stopped, "");
  ASSERT_EQ(bench.world.wait(5.0).stopped, "");
  EXPECT_GT(bench.world.centre_of_mass(0_stone).z(), 0.2) << "it hangs in the gripper";
}

/// With the flat jaws' clearance over the table the true fingers reach it.
TEST(FingerLinkage, FingersThatCloseOverTheTablePressOnIt) {
  for (const std::string linkage : {"parallel", "three_finger"}) {
    PinchBench bench(1.2, linkage);
    ASSERT_EQ(bench.carry(tool_down({0, 0, 0.004}), 1.5).stopped, "");
    EXPECT_LT(bench.world.load().force.norm(), 1.0) << "fully open they stand 4 mm over the table";
    if (linkage == "parallel") {
      EXPECT_TRUE(bench.gripper.move(0.0, 0.05, 60.0).object);
    } else {
      EXPECT_THROW((void)bench.gripper.move(0.0, 0.05, 60.0), DeviceError);
    }
  }
}

/// A pick and place of a flat pebble in the ideal cell, by plans that count on one linkage in a world with
/// another.
struct LinkageTrial : CellBench {
  PlanningScene scene;
  motion::PickAndPlaceTask task;
  motion::PickAndPlacePlan plan;
  bool met_table = false, held = false;

  LinkageTrial(Linkage planned, const std::string& linkage)
      : CellBench({flat_pebble()}, PinchBench::with(linkage)) {
    const Pose T_W_O = simulated.truth().T_W_O[0];
    scene.robot = robot;
    scene.gripper = make_robotiq_3f(planned);
    scene.T_W_R = layout.T_W_R;
    scene.T_F_T = layout.T_F_T;
    scene.objects = {{"pebble", stones[0].pieces, T_W_O}};
    task.stone = &stones[0];
    task.object = 0;
    task.T_W_O_pick = task.T_W_O_place = T_W_O;
    task.T_W_O_place.translation().head<2>() += Eigen::Vector2d(0.70, 0.28) - T_W_O.translation().head<2>();
    task.q_start = cell.arm.state().q;
    plan = motion::plan_pick_and_place(scene, task);
  }
  static Stone flat_pebble() {
    Stone stone = make_pebble("pebble", 0.3);
    stone.pieces = {stone.scan};
    return stone;
  }
  [[nodiscard]] const motion::PlanStep& step(Kind kind) const {
    return *std::find_if(plan.steps.begin(), plan.steps.end(), [&](const auto& s) { return s.kind == kind; });
  }
  /// Height of the lowest corner that the plan expects of the open gripper at the grasp [m].
  [[nodiscard]] double planned_height() const {
    const Pose T_W_T_grasp = T_W_T(step(Kind::kApproach).trajectory.q.back());
    const GripperModel gripper = with_spacing(scene.gripper, plan.spacing);
    double lowest = 1.0;
    for (const motion::GripperBox& box : gripper.boxes)
      for (int corner = 0; corner < 8; ++corner) {
        const Eigen::Vector3d sign(corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5, corner & 4 ? 0.5 : -0.5);
        const Eigen::Vector3d p = motion::box_centre(gripper, box, step(Kind::kOpen).opening);
        lowest = std::min(lowest, (T_W_T_grasp * (p + sign.cwiseProduct(box.size))).z());
      }
    return lowest;
  }
  /// Height of the lowest corner of the true gripper there [m].
  [[nodiscard]] double true_height() const {
    GripperPose pose = opened(step(Kind::kOpen).opening);
    pose.T_W_T = T_W_T(step(Kind::kApproach).trajectory.q.back());
    pose.narrowed = scene.gripper.finger_spacing - plan.spacing;
    return lowest_corner(simulated.world().gripper_body(), pose).z();
  }
  /// Executes the plan; ends where a finger meets something on the approach.
  void execute() {
    for (const motion::PlanStep& s : plan.steps) {
      switch (s.kind) {
        case Kind::kOpen:
          if (s.spacing > 0) cell.gripper.spread(s.spacing);
          [[fallthrough]];
        case Kind::kRelease:
          (void)cell.gripper.move(s.opening, s.finger_speed, 60.0);
          break;
        case Kind::kGrasp:
          held = cell.gripper.move(0.0, s.finger_speed, s.force).object;
          break;
        case Kind::kTransit:
        case Kind::kLift:
          ASSERT_EQ(cell.arm.follow(s.trajectory).status, MotionResult::Status::kDone) << s.name;
          break;
        case Kind::kApproach:
        case Kind::kDescent: {
          cell.force_torque.zero();
          const auto status =
              cell.arm.follow_guarded({s.trajectory, -Eigen::Vector3d::UnitZ(), s.threshold}).status;
          met_table = !held && status == MotionResult::Status::kContact;
          if (met_table) return;
          break;
        }
        case Kind::kRetreat: {
          const auto back = motion::plan_retreat(scene, cell.arm.state().q, step(Kind::kOpen).opening, 0);
          ASSERT_TRUE(back.has_value());
          ASSERT_EQ(cell.arm.follow(*back).status, MotionResult::Status::kDone);
          break;
        }
      }
    }
  }
};

TEST(FingerLinkage, AFlatStoneIsPickedAndPlacedNearTheTable) {
  LinkageTrial trial(Linkage::kThreeFinger, "three_finger");
  ASSERT_EQ(trial.plan.status, motion::PickAndPlacePlan::Status::kPlanned) << trial.plan.reason;
  EXPECT_NEAR(trial.true_height(), trial.planned_height(), 0.0015);
  EXPECT_GT(trial.true_height(), 0.0);
  EXPECT_LT(trial.true_height(), 0.020) << "a stone this flat is gripped near the table";
  trial.execute();
  EXPECT_FALSE(trial.met_table);
  EXPECT_TRUE(trial.held);
  trial.simulated.wait(2.0);
  const Eigen::Vector3d expected = trial.task.T_W_O_place * trial.stones[0].mass.p_O_M;
  EXPECT_LT((trial.centre(0_stone) - expected).norm(), 0.008);
}

/// True fingers come as much lower than planned for flat jaws as they stand further out.
TEST(FingerLinkage, APlanForFlatJawsBringsTheTrueFingersTooLow) {
  LinkageTrial trial(Linkage::kParallel, "three_finger");
  ASSERT_EQ(trial.plan.status, motion::PickAndPlacePlan::Status::kPlanned) << trial.plan.reason;
  const double error = trial.planned_height() - trial.true_height();
  EXPECT_NEAR(error, finger_linkage(0.5 * trial.step(Kind::kOpen).opening).tip - 0.223, 0.002);
  EXPECT_GT(error, 0.006);
  trial.execute();
  EXPECT_EQ(trial.met_table, trial.true_height() < 0.0);
  LinkageTrial flat(Linkage::kParallel, "parallel");
  EXPECT_NEAR(flat.true_height(), flat.planned_height(), 0.0001);
}

}  // namespace
}  // namespace stonestack::simulation
