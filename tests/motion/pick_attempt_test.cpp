#include "motion/pick_and_place/pick_attempt.hpp"

#include <gtest/gtest.h>

#include <tuple>

#include "kinematics/inverse.hpp"
#include "motion/cartesian.hpp"
#include "motion/grasp_check.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::motion {
namespace {

/// A block that is set on a pedestal, and a board that hangs over it in the height `board`.
struct UnderABoard {
  Stone stone;
  PlanningScene scene;
  PickAndPlaceTask task;

  UnderABoard(double stone_height, double board) {
    stone.name = "block";
    stone.scan = stone.mesh = make_box({0.10, 0.07, stone_height});
    stone.pieces = {stone.scan};
    stone.mass = mass_properties(stone.scan, 1500.0);
    scene.robot = read_robot("ur10");
    scene.T_F_T = Pose(Eigen::Translation3d(0, 0, 0.264));
    task.T_W_O_pick = Pose(Eigen::Translation3d(0.70, -0.18, 0.5 * stone_height));
    task.T_W_O_place = Pose(Eigen::Translation3d(0.70, 0.28, 0.08 + 0.5 * stone_height));
    scene.objects = {
        {"block", stone.pieces, task.T_W_O_pick},
        {"pedestal", {make_box({0.05, 0.05, 0.08})}, Pose(Eigen::Translation3d(0.70, 0.28, 0.04))},
        {"board", {make_box({0.4, 0.4, 0.02})}, Pose(Eigen::Translation3d(0.78, 0.28, board))}};
    task.stone = &stone;
    task.object = 0;
    task.support = 1;
    task.q_start << -0.8, -1.8, 1.8, -1.57, -1.57, 0.0;
  }

  [[nodiscard]] Pose tool(const Joints& q) const { return forward(scene.robot, q) * scene.T_F_T; }

  /// An attempt with one of the grasps that point down, and how it ended.
  struct Tried {
    double opening = 0.0;  ///< of the open gripper [m]
    double spacing = 0.0;
    PickAttempt::Result result;
  };
  [[nodiscard]] std::vector<Tried> attempts() const {
    std::vector<Tried> all;
    const GraspFinder finder(scene, stone, task.object, task.T_W_O_pick);
    for (const int index : finder.check(task.T_W_O_place).usable) {
      const Grasp& grasp = finder.set().grasps[static_cast<std::size_t>(index)];
      if ((task.T_W_O_place * grasp.T_O_T).linear()(2, 2) > -0.99) continue;
      const auto joints = [&](const Pose& T_W_O) -> std::optional<Joints> {
        const Pose T_R_F = scene.T_W_R.inverse() * T_W_O * grasp.T_O_T * scene.T_F_T.inverse();
        for (const auto& s : inverse(scene.robot, T_R_F, task.q_start))
          if (finder.arm_is_free(index, s.q)) return s.q;
        return std::nullopt;
      };
      const auto pick = joints(task.T_W_O_pick), place = joints(task.T_W_O_place);
      if (pick && place)
        all.push_back(
            {grasp.pre_opening, grasp.spacing,
             PickAttempt(scene, task, {}, grasp).try_joints(*pick, *place, PickAttempt::Effort::kMuch)});
    }
    return all;
  }
};

TEST(PickAttempt, RetreatsLessUnderABoard) {
  const UnderABoard open(0.07, 1.2), low(0.07, 0.60);
  const double whole = MotionOptions{}.approach;
  const auto length = [&](const UnderABoard& cell, const JointPath& retreat) {
    return difference(cell.tool(retreat.front()), cell.tool(retreat.back())).translation;
  };
  for (const auto& [opening, spacing, tried] : open.attempts()) {
    if (tried.fault != PathFault::kNone) continue;
    EXPECT_NEAR(length(open, tried.paths.retreat), whole, 1e-6);
  }

  int shorter = 0, refused = 0;
  for (const auto& [opening, spacing, tried] : low.attempts()) {
    refused += tried.fault == PathFault::kRetreat ? 1 : 0;
    if (tried.fault != PathFault::kNone) continue;
    EXPECT_GE(length(low, tried.paths.retreat), 0.5 * whole - 1e-6);
    if (length(low, tried.paths.retreat) > whole - 1e-6) continue;
    ++shorter;
    PlanningScene placed = low.scene;  // and then the gripper is as far from the stone as in a transit
    placed.objects = {{"block", low.stone.pieces, low.task.T_W_O_place}};
    placed.gripper = with_spacing(placed.gripper, spacing);
    CollisionRules rules;
    rules.opening = opening;
    EXPECT_FALSE(CollisionChecker(placed, rules).collides(tried.paths.retreat.back()));
  }
  EXPECT_GT(shorter, 0);
  EXPECT_GT(refused, 0) << "of some grasps the gripper would still be around the stone";
}

/// A checker of the arm's links beside the block.
CollisionChecker links_beside_block(const UnderABoard& cell, const Pose& T_W_O, const Grasp* grasp,
                                    double padding) {
  PlanningScene alone = cell.scene;
  if (grasp != nullptr) alone.gripper = with_spacing(alone.gripper, grasp->spacing);
  alone.objects = {{"block", cell.stone.pieces, T_W_O}};
  MotionOptions options;
  options.transit_padding = padding;
  return links_beside(alone, options, grasp != nullptr ? grasp->pre_opening : 0.155);
}

TEST(PickAttempt, TheArmsLinksKeepFromTheStoneThatTheGripperTouches) {
  UnderABoard cell(0.07, 1.5);
  const Joints& q = cell.task.q_start;
  const auto hit = [&](const Eigen::Vector3d& p_W, double padding) {
    return links_beside_block(cell, Pose(Eigen::Translation3d(p_W)), nullptr, padding).collides(q);
  };
  const Eigen::Vector3d p_W_elbow = link_poses(cell.scene.robot, q)[3].translation();
  const Eigen::Vector3d p_W_above = p_W_elbow + Eigen::Vector3d(0.0, 0.0, 0.20);
  EXPECT_FALSE(hit(cell.tool(q).translation(), 0.01));
  EXPECT_TRUE(hit(p_W_elbow, 0.01));
  EXPECT_FALSE(hit(p_W_above, 0.0));
  EXPECT_TRUE(hit(p_W_above, 0.1)) << "as far as on a transit";
  cell.scene.table_z = p_W_elbow.z() - 0.1;  // the forearm is in it
  EXPECT_FALSE(hit(p_W_above, 0.0)) << "the table is another checker's";
}

/// A padding between what both ends keep: the one nearer to the base is refused.
TEST(PickAttempt, NeitherApproachNorRetreatBringsTheLinksTooNearToTheStone) {
  for (const auto& [x_pick, x_place, fault] :
       {std::tuple(0.45, 0.85, PathFault::kApproach), std::tuple(0.85, 0.45, PathFault::kRetreat)}) {
    UnderABoard cell(0.07, 1.5);
    cell.task.T_W_O_pick.translation().x() = x_pick;
    cell.task.T_W_O_place.translation().x() = x_place;
    cell.scene.objects[0].T_W_object = cell.task.T_W_O_pick;
    cell.scene.objects[1].T_W_object = Pose(Eigen::Translation3d(x_place, 0.28, 0.04));
    const GraspFinder finder(cell.scene, cell.stone, cell.task.object, cell.task.T_W_O_pick);
    bool found = false;
    for (const int index : finder.check(cell.task.T_W_O_place).usable) {
      const Grasp& grasp = finder.set().grasps[static_cast<std::size_t>(index)];
      struct End {
        Joints q;
        double keeps = 0.0;  // m: largest padding with which the straight motion is free
      };
      const auto end = [&](const Pose& T_W_O) -> std::optional<End> {
        const Pose T_R_T = cell.scene.T_W_R.inverse() * T_W_O * grasp.T_O_T;
        for (const auto& s :
             inverse(cell.scene.robot, T_R_T * cell.scene.T_F_T.inverse(), cell.task.q_start)) {
          const auto path = straight_path(cell.scene.robot, cell.scene.T_F_T, s.q,
                                          T_R_T * Eigen::Translation3d(0.0, 0.0, -MotionOptions{}.approach));
          if (!path || !finder.arm_is_free(index, s.q)) continue;
          double low = 0.0, high = 1.0;
          while (high - low > 0.001) {
            const double middle = 0.5 * (low + high);
            (is_free(links_beside_block(cell, T_W_O, &grasp, middle), *path) ? low : high) = middle;
          }
          return End{s.q, low};
        }
        return std::nullopt;
      };
      const auto pick = end(cell.task.T_W_O_pick), place = end(cell.task.T_W_O_place);
      if (!pick || !place) continue;
      const bool pick_is_nearer = fault == PathFault::kApproach;
      const double near = pick_is_nearer ? pick->keeps : place->keeps;
      const double far = pick_is_nearer ? place->keeps : pick->keeps;
      if (far - near < 0.01) continue;
      MotionOptions options;
      options.transit_padding = 0.5 * (near + far);
      const PickAttempt attempt(cell.scene, cell.task, options, grasp);
      EXPECT_EQ(attempt.try_joints(pick->q, place->q, PickAttempt::Effort::kLittle).fault, fault);
      found = true;
      break;
    }
    EXPECT_TRUE(found) << x_pick;
  }
}

TEST(PickAttempt, DescendsNoFurtherThanTheGripperHasClearance) {
  UnderABoard cell(0.07, 1.2);
  cell.scene.objects.pop_back();
  for (const double width : {0.03, 0.12}) {
    cell.scene.objects[1].pieces = {make_box({width, width, 0.08})};
    int planned = 0;
    for (const auto& [opening, spacing, tried] : cell.attempts()) {
      if (tried.fault != PathFault::kNone) continue;
      ++planned;
      const double past = cell.tool(tried.paths.retreat.front()).translation().z() -
                          cell.tool(tried.paths.descent.back()).translation().z();
      if (width < 0.05) {
        EXPECT_NEAR(past, MotionOptions{}.descent_past, 1e-6);
      } else {
        EXPECT_GT(cell.tool(tried.paths.descent.back()).translation().z(), 0.08)
            << "finger tips in the tower";
        EXPECT_GE(past, 0.0);
      }
    }
    EXPECT_GT(planned, 0) << width;
  }
}

}  // namespace
}  // namespace stonestack::motion
