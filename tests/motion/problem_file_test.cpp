#include "motion/problem_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "motion/transit.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/hardware/cell.hpp"

namespace stonestack::motion {
namespace {

using hardware::CellLayout;

using ::testing::HasSubstr;

constexpr const char* kGood =
    "# a post\nrobot ur5e\nhand none\npadding 0.005\ntable -0.1\nbase 0.1 0 0\n"
    "cylinder post 0.05 1.0 0.45 0 0.5\nsphere ball 0.1 0 0 2 # far\n\n"
    "capsule pill 0.1 0.3 0 2 0 0 0.7071068 0 0.7071068\nbox shelf 0.4 0.3 0.02 -0.6 0.4 0.4\n"
    "start 0.8 -1.2 1.4 -1.8 -1.57 0\ngoal -0.8 -1.2 1.4 -1.8 -1.57 0\ngoal -0.8 -1.2 1.4 -1.8 -1.57 3.1\n"
    "start 0.8 -1.2 1.4 -1.8 -1.57 0\ngoal 0.8 -1.2 1.4 -1.8 -1.57 0\n";

std::string answer(const std::string& text) {
  try {
    (void)parse_motion_problems(text, "problems.txt");
    return "read";
  } catch (const FileError& error) {
    return error.what();
  }
}

TEST(ProblemFile, ReadsSceneAndProblems) {
  const MotionProblems file = parse_motion_problems(kGood, "problems.txt");
  EXPECT_EQ(file.scene.robot.name, "ur5e");
  EXPECT_TRUE(file.scene.gripper.boxes.empty());
  EXPECT_DOUBLE_EQ(file.padding, 0.005);
  EXPECT_DOUBLE_EQ(file.scene.table_z, -0.1);
  EXPECT_DOUBLE_EQ(file.scene.T_W_R.translation().x(), 0.1);
  ASSERT_EQ(file.scene.objects.size(), 4u);
  ASSERT_EQ(file.problems.size(), 2u);
  EXPECT_EQ(file.problems[0].goals.size(), 2u);
  EXPECT_DOUBLE_EQ(file.problems[0].goals[1][5], 3.1);
}

/// Volumes of polyhedra around the shapes: never less than the shape's, at most 2 % of a length more.
TEST(ProblemFile, ShapesContainWhatTheyStandFor) {
  const MotionProblems file = parse_motion_problems(kGood, "problems.txt");
  const auto of = [&](std::size_t i) { return volume(file.scene.objects[i].pieces.front()); };
  const double pi = 3.14159265358979323846;
  const double ball = 4.0 / 3.0 * pi * 0.001;
  const double expected[] = {pi * 0.0025, ball, ball + pi * 0.01 * 0.3, 0.4 * 0.3 * 0.02};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_TRUE(is_closed(file.scene.objects[i].pieces.front())) << i;
    EXPECT_GE(of(i), expected[i] * (1 - 1e-12)) << i;
    EXPECT_LE(of(i), expected[i] * 1.06) << i;
  }
  const auto pill =
      bounds(transformed(file.scene.objects[2].pieces.front(), file.scene.objects[2].T_W_object));
  EXPECT_NEAR(pill.sizes().x(), 0.5, 0.005) << "its axis was turned from z to x";
  EXPECT_NEAR(pill.sizes().z(), 0.2, 0.005);
}

/// In every direction the hull reaches as far as the shape: the support function of a capsule is that of a
/// ball and a segment, of a cylinder that of a disc and a segment.
TEST(ProblemFile, NoHullIsInsideItsShape) {
  const MotionProblems file = parse_motion_problems(kGood, "problems.txt");
  const auto reach = [&](std::size_t i, const Eigen::Vector3d& n) {
    double max = -1.0;
    for (const auto& v : file.scene.objects[i].pieces.front().vertices) max = std::max(max, n.dot(v));
    return max;
  };
  Random random = Random::stream(1, "directions");
  for (int k = 0; k < 5000; ++k) {
    Eigen::Vector3d n = random.rotation() * Eigen::Vector3d::UnitX();
    if (k % 5 == 0) n = Eigen::Vector3d(n.x(), n.y(), 0.01 * n.z()).normalized();  // about the middle
    const double level = std::hypot(n.x(), n.y()), up = std::abs(n.z());
    EXPECT_GE(reach(0, n), 0.05 * level + 0.5 * up - 1e-9);
    EXPECT_GE(reach(1, n), 0.1 - 1e-9);
    EXPECT_GE(reach(2, n), 0.1 + 0.15 * up - 1e-9);
    EXPECT_LE(reach(2, n), 1.03 * 0.1 + 0.15 * up);
  }
}

/// The gripper of the project begins where the flange ends, unless the file changes it.
TEST(ProblemFile, TheGripperIsMountedOnTheFlange) {
  const std::string problem = "start 0 -1.57 1.57 -1.57 -1.57 0\ngoal 0.5 -1.57 1.57 -1.57 -1.57 0\n";
  const MotionProblems file = parse_motion_problems(problem, "problems.txt");
  EXPECT_DOUBLE_EQ(file.scene.T_F_T.translation().z(), CellLayout().T_F_T.translation().z());
  EXPECT_FALSE(CollisionChecker(file.scene).collides(file.problems.front().start));
  EXPECT_EQ(parse_motion_problems("hand none\n" + problem, "x").scene.T_F_T.translation().z(), 0.0);
  EXPECT_EQ(parse_motion_problems("tool 0 0 0.2\n" + problem, "x").scene.T_F_T.translation().z(), 0.2);
}

TEST(ProblemFile, PlansAroundThePost) {
  const MotionProblems file = parse_motion_problems(kGood, "problems.txt");
  CollisionRules rules;
  rules.padding = file.padding;
  const CollisionChecker checker(file.scene, rules);
  const auto& problem = file.problems.front();
  EXPECT_FALSE(checker.motion_is_free(problem.start, problem.goals.front()));
  const auto path = find_path(checker, problem.start, problem.goals);
  ASSERT_TRUE(path.has_value());
  for (std::size_t i = 1; i < path->size(); ++i)
    EXPECT_TRUE(checker.motion_is_free((*path)[i - 1], (*path)[i], 0.001));
}

TEST(ProblemFile, RefusesWithTheLine) {
  EXPECT_EQ(answer(kGood), "read");
  const std::string problem = "start 0 0 0 0 0 0\ngoal 0 0 0 0 0 0\n";
  EXPECT_THAT(answer("box a 0.1 0.1 0.1 0 0 0\nblob x\n" + problem), HasSubstr("line 2"));
  for (const char* bad :
       {"box a 0.1 0.1 0.1 0 0\n", "box a 0.1 -0.1 0.1 0 0 0\n", "box a 0.1 nan 0.1 0 0 0\n", "sphere\n",
        "sphere a 1e9 0 0 0\n", "sphere a 0.1 0 0 0 1 1 1 1\n", "cylinder a 0.1 0.1 0 0 0 0 0 1\n",
        "box a 0.1 0.1 0.1 0 0 0 0 0 0 1 7\n", "robot ../../etc/passwd\n", "robot no_such_arm\n",
        "hand claw\n", "padding -1\n", "goal 0 0 0 0 0 0\n", "start 0 0 0 0 0\n", "start 0 0 9 0 0 0\n",
        "start 0 0 x 0 0 0\n"})
    EXPECT_NE(answer(bad + problem), "read") << bad;
  EXPECT_THAT(answer(""), HasSubstr("no start"));
  EXPECT_THAT(answer("start 0 0 0 0 0 0\n"), HasSubstr("no goal"));
  EXPECT_THAT(answer(problem + "robot ur5\n"), HasSubstr("after the first start"));
}

}  // namespace
}  // namespace stonestack::motion
