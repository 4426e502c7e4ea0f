#include "motion/cartesian.hpp"

#include <gtest/gtest.h>

#include <numbers>

#include "kinematics/inverse.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::motion {
namespace {

const Pose kT_F_T(Eigen::Translation3d(0, 0, 0.264));

/// A tool pose in front of the robot, pointing down within 25 degrees.
Pose random_tool_pose(Random& random) {
  const double r = random.uniform(0.45, 0.95), angle = random.uniform(-1.0, 1.0);
  const Eigen::Vector3d p(r * std::cos(angle), r * std::sin(angle), random.uniform(0.02, 0.35));
  const Eigen::Vector3d axis(random.uniform(-1, 1), random.uniform(-1, 1), 0.1);
  const Eigen::Quaterniond down(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX()));
  const Eigen::Quaterniond tilt(Eigen::AngleAxisd(random.uniform(0, 0.43), axis.normalized()));
  const Eigen::Quaterniond yaw(Eigen::AngleAxisd(random.uniform(-3.1, 3.1), Eigen::Vector3d::UnitZ()));
  return make_pose(p, tilt * yaw * down);
}

double distance_to_line(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const double s = std::clamp((p - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  return (p - a - s * (b - a)).norm();
}

TEST(Cartesian, ApproachesTrackAndAreStraight) {
  const RobotModel robot = read_robot("ur10");
  Random random(21);
  int reachable = 0, tracked = 0;
  for (int trial = 0; trial < 300; ++trial) {
    const Pose goal = random_tool_pose(random);
    const auto solutions = inverse(robot, goal * kT_F_T.inverse(), Joints::Zero());
    if (solutions.empty()) continue;
    ++reachable;
    const Pose start = goal * Pose(Eigen::Translation3d(0, 0, -0.12));
    bool found = false;
    for (const IkSolution& solution : solutions) {
      const auto path = straight_path(robot, kT_F_T, solution.q, start);
      if (!path) continue;
      found = true;
      EXPECT_EQ(path->front(), solution.q);
      EXPECT_LT(difference(forward(robot, path->back()) * kT_F_T, start).translation, 1e-7);
      for (std::size_t i = 0; i + 1 < path->size(); ++i)
        for (const double s : {0.25, 0.5, 0.75}) {
          const Joints q = (1 - s) * (*path)[i] + s * (*path)[i + 1];
          const Pose T = forward(robot, q) * kT_F_T;
          ASSERT_LT(distance_to_line(T.translation(), goal.translation(), start.translation()), 0.00052);
          ASSERT_LT(difference(T, goal).angle, 0.0088);
        }
    }
    tracked += found ? 1 : 0;
  }
  EXPECT_GT(reachable, 200);
  EXPECT_GE(tracked, 0.99 * reachable);
}

TEST(Cartesian, StaysOnItsBranch) {
  const RobotModel robot = read_robot("ur10");
  Random random(22);
  for (int trial = 0; trial < 50; ++trial) {
    const Pose goal = random_tool_pose(random);
    for (const IkSolution& s : inverse(robot, goal * kT_F_T.inverse(), Joints::Zero())) {
      const auto path = straight_path(robot, kT_F_T, s.q, goal * Pose(Eigen::Translation3d(0, 0, -0.1)));
      for (const Joints& q : path.value_or(JointPath{})) {
        ASSERT_EQ(branch_of(robot, q), branch_of(robot, s.q));
      }
    }
  }
}

TEST(Cartesian, OutOfReachIsEmpty) {
  const RobotModel robot = read_robot("ur10");
  Random random(23);
  const Pose goal = random_tool_pose(random);
  const auto solutions = inverse(robot, goal * kT_F_T.inverse(), Joints::Zero());
  ASSERT_FALSE(solutions.empty());
  Pose far = goal;
  far.translation().x() += 3.0;
  EXPECT_FALSE(straight_path(robot, kT_F_T, solutions.front().q, far).has_value());
  far.translation().x() = std::nan("");
  EXPECT_THROW((void)straight_path(robot, kT_F_T, solutions.front().q, far), InvalidArgument);
}

}  // namespace
}  // namespace stonestack::motion
