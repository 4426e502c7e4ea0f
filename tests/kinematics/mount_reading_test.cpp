#include "kinematics/mount_reading.hpp"

#include <gtest/gtest.h>

#include "core/constants.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::kinematics {
namespace {

using Verdict = MountCheck::Verdict;

/// A gripper over the table of which the camera sees a plane.
struct MountReadings : testing::Test {
  Pose T_F_T = make_pose({0, 0, 0.264});
  Pose T_T_C = turned({0.0, 0.11, -0.17}, 10 * kDegree);  // as it really is
  Pose T_W_T = make_pose({0.7, -0.18, 0.45}, Eigen::Quaterniond(0, 1, 0, 0));

  static Pose turned(const Eigen::Vector3d& p, double about_x) {
    return make_pose(p, Eigen::Quaterniond(Eigen::AngleAxisd(about_x, Eigen::Vector3d::UnitX())));
  }
  /// z = 0 of W as the camera really sees it, normal towards the camera.
  [[nodiscard]] Plane table() const {
    const Pose T_C_W = (T_W_T * T_T_C).inverse();
    const Eigen::Vector3d normal = T_C_W.linear().col(2);
    return {normal, normal.dot(T_C_W.translation())};
  }
  [[nodiscard]] MountCheck check(const Pose& numbers, MountReading meant = MountReading::kTip) const {
    return check_mount(numbers, meant, T_F_T, T_W_T, table());
  }
  /// The numbers that each reading needs to be right.
  [[nodiscard]] Pose numbers_for(MountReading reading) const {
    const Pose T_F_C = T_F_T * T_T_C;
    return reading == MountReading::kTip          ? T_T_C
           : reading == MountReading::kTipInverse ? T_T_C.inverse()
           : reading == MountReading::kFlange     ? T_F_C
                                                  : T_F_C.inverse();
  }
};

TEST_F(MountReadings, NumbersOfEachReadingGiveTheMount) {
  for (const MountReading reading : kMountReadings)
    EXPECT_TRUE(mount_of(reading, numbers_for(reading), T_F_T).isApprox(T_T_C, 1e-12)) << to_text(reading);
}

TEST_F(MountReadings, TheRightMountPutsTheTableAtZero) {
  const TableOffset at = table_offset(T_T_C, T_W_T, table());
  EXPECT_NEAR(at.height, 0.0, 1e-12);
  EXPECT_NEAR(at.tilt, 0.0, 1e-7);
  EXPECT_EQ(check(T_T_C).verdict, Verdict::kFits);
  // 264 mm too far down the gripper: the table seems to be as far below.
  const TableOffset below = table_offset(T_F_T * T_T_C, T_W_T, table());
  EXPECT_NEAR(below.height, -0.264, 1e-12);
  EXPECT_NEAR(below.tilt, 0.0, 1e-7);
}

TEST_F(MountReadings, IdentifiesTheFrameOfTheNumbers) {
  for (const MountReading meant : kMountReadings)
    for (const MountReading really : kMountReadings) {
      const MountCheck found = check(numbers_for(really), meant);
      if (meant == really) {
        EXPECT_EQ(found.verdict, Verdict::kFits) << to_text(really);
        continue;
      }
      ASSERT_EQ(found.verdict, Verdict::kOther) << to_text(really) << " given as " << to_text(meant);
      EXPECT_EQ(found.others.front().reading, really);
      EXPECT_TRUE(found.others.front().T_T_C.isApprox(T_T_C, 1e-12));
    }
}

/// A camera that looks straight down from halfway between flange and finger tips: T_T_C and T_C_F have the
/// same height. One view of a plane cannot distinguish them, one with the gripper tilted can.
TEST_F(MountReadings, AViewThatCannotDecideDoesNotDecide) {
  T_T_C = make_pose({0.0, 0.11, -0.132});
  const Pose inverted = (T_F_T * T_T_C).inverse();
  MountCheck found = check(inverted);
  ASSERT_EQ(found.verdict, Verdict::kAmbiguous);
  EXPECT_EQ(found.others.front().reading, MountReading::kFlangeInverse);
  EXPECT_EQ(check(T_T_C).verdict, Verdict::kAmbiguous) << "nor when it is right";
  T_W_T = T_W_T * Eigen::AngleAxisd(25 * kDegree, Eigen::Vector3d::UnitX());
  found = check(inverted);
  ASSERT_EQ(found.verdict, Verdict::kOther);
  EXPECT_EQ(found.others.front().reading, MountReading::kFlangeInverse);
  EXPECT_EQ(check(T_T_C).verdict, Verdict::kFits);
}

TEST_F(MountReadings, GradesErrorsOfTheRightReading) {
  EXPECT_EQ(check(T_T_C * Eigen::Translation3d(0, 0, 0.006)).verdict, Verdict::kFits);
  EXPECT_EQ(check(T_T_C * Eigen::Translation3d(0, 0, 0.018)).verdict, Verdict::kRough);
  EXPECT_EQ(check(T_T_C * Eigen::AngleAxisd(2.5 * kDegree, Eigen::Vector3d::UnitX())).verdict,
            Verdict::kRough);
  EXPECT_EQ(check(T_T_C * Eigen::Translation3d(0, 0, 0.166)).verdict, Verdict::kNone);
  EXPECT_EQ(check(T_T_C * Eigen::AngleAxisd(30 * kDegree, Eigen::Vector3d::UnitX())).verdict, Verdict::kNone);
}

TEST_F(MountReadings, KnowsWhichMountsAreNone) {
  EXPECT_TRUE(is_possible_mount(T_T_C));
  EXPECT_FALSE(is_possible_mount(T_T_C.inverse())) << "in front of the finger tips";
  EXPECT_FALSE(is_possible_mount(turned({0, 0.11, -0.17}, 180 * kDegree))) << "facing the arm";
}

TEST_F(MountReadings, RefusesWhatIsNoPlane) {
  EXPECT_THROW((void)table_offset(T_T_C, T_W_T, {{0, 0, -2}, -0.6}), InvalidArgument);
}

}  // namespace
}  // namespace stonestack::kinematics
