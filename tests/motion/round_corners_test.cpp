#include "motion/path/round_corners.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/constants.hpp"
#include "kinematics/inverse.hpp"
#include "motion/hard_scene.hpp"
#include "motion/transit.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/hardware/cell.hpp"

namespace stonestack::motion {
namespace {

constexpr double kChord = 3e-5;  // m: chords of the curves are certified, the curves lie within 0.01 mrad

/// A gripper between two walls and two towers, a post and bars on its path.
PlanningScene slot_scene(double x, double gap, double height) {
  PlanningScene scene = test::hard_scene();
  const auto box = [&](const char* name, const Eigen::Vector3d& size, const Eigen::Vector3d& p) {
    scene.objects.push_back({name, {make_box(size)}, make_pose(p)});
  };
  box("left wall", {0.3, 0.02, height}, {x, -0.3 + gap + 0.01, height / 2});
  box("right wall", {0.3, 0.02, height}, {x, -0.3 - gap - 0.01, height / 2});
  return scene;
}

CollisionChecker checker_at(const PlanningScene& scene, double padding) {
  CollisionRules rules;
  rules.padding = padding;
  rules.self_padding = std::min(rules.self_padding, padding);
  return CollisionChecker(scene, rules);
}

/// Where only the padding of an approach leaves a path, corners were cut by 8 mm all the same.
TEST(RoundCorners, ATightTransitKeepsItsPadding) {
  int found = 0;
  for (std::uint64_t k = 0; k < 60; ++k) {
    Random random = Random::stream(5, k);
    const double gap = random.uniform(0.055, 0.061), height = random.uniform(0.08, 0.145);
    const double x = random.uniform(0.62, 0.85);
    const PlanningScene scene = slot_scene(x, gap, height);
    const CollisionChecker wide = checker_at(scene, 0.010), tight = checker_at(scene, 0.002);
    const auto starts = test::tool_down_at(scene, {x, -0.3, 0.05}, static_cast<double>(k % 2) * kPi);
    const auto goals = test::tool_down_at(scene, {0.8, 0.35, 0.2}, 0.0);
    const auto start = std::find_if(starts.begin(), starts.end(),
                                    [&](const Joints& q) { return wide.collides(q) && !tight.collides(q); });
    if (start == starts.end() || goals.empty()) continue;
    MotionOptions options;
    options.seed = static_cast<int>(k) + 1;
    const auto motion = plan_transit(scene, *start, goals.front(), options);
    if (!motion) continue;
    ++found;
    const CollisionChecker promised = checker_at(scene, 0.002 - kChord);
    for (double t = 0.0; t < motion->duration(); t += 0.002)
      ASSERT_FALSE(promised.collides(sample(*motion, t).q)) << "scene " << k << " at " << t;
  }
  EXPECT_GE(found, 10);
}

/// The path that is certified is the one that is timed, whatever the corners and with and without jerk limit.
TEST(RoundCorners, CutCornersStayFree) {
  const PlanningScene scene = slot_scene(0.8, 0.061, 0.1);
  const CollisionChecker checker = checker_at(scene, 0.010), promised = checker_at(scene, 0.010 - kChord);
  const auto starts = test::tool_down_at(scene, {0.8, -0.3, 0.25}, 0.0);
  const auto goals = test::tool_down_at(scene, {0.8, 0.35, 0.2}, 0.0);
  const auto start =
      std::find_if(starts.begin(), starts.end(), [&](const Joints& q) { return !checker.collides(q); });
  ASSERT_TRUE(start != starts.end());
  int cut = 0;
  for (int seed = 1; seed <= 8; ++seed) {
    MotionOptions options;
    options.seed = seed;
    const auto path = find_path(checker, *start, goals, options);
    ASSERT_TRUE(path.has_value());
    for (const double jerk : {0.0, 5.0}) {
      options.jerk = jerk;
      TimingLimits limits = timing_limits(scene.robot, options);
      limits.blend = 0.2;
      limits.blend = free_blend(checker, *path, limits);
      cut += limits.blend > 0.0 ? 1 : 0;
      const JointTrajectory motion = time_path(*path, limits);
      for (double t = 0.0; t < motion.duration(); t += 0.002)
        ASSERT_FALSE(promised.collides(sample(motion, t).q)) << seed << ", jerk " << jerk << " at " << t;
    }
  }
  EXPECT_GT(cut, 0) << "or nothing was tested";
}

}  // namespace
}  // namespace stonestack::motion
