#pragma once
#include <array>
#include <string>
#include <vector>

#include "motion/collision.hpp"
#include "motion/collision/convex_core.hpp"

/// Private to motion: what CollisionChecker compares. All of it in the robot's base frame R.
namespace stonestack::motion {

/// Something that moves with a link.
struct Mover {
  enum class Part { kArm, kGripper, kHeld };
  Part part = Part::kArm;
  std::size_t link = 0;  ///< 0..6; `core` is in its frame
  ConvexCore core;
  double span = 0.0;  ///< furthest point of the hull from the link's origin [m]
  bool sees_table = true;
  Eigen::AlignedBox3d box_T;  ///< of a gripper box, in T; empty for others
  std::string name;
  double table_padding = 0.0;  ///< [m]
};

/// A convex piece of an object.
struct ObstaclePiece {
  ConvexCore core;
  Eigen::Vector3d centre;
  double sphere = 0.0;  ///< around `centre` [m]
  Bounds box;
};

/// The pieces [first, last) of one object.
struct ObstacleGroup {
  std::string name;
  std::size_t first = 0, last = 0;
  Bounds box;
  Eigen::Vector3d centre;
  double sphere = 0.0;
  std::vector<char> sees;        ///< one a mover: 0 where the two may touch
  std::vector<double> padding;   ///< one a mover [m]
  double gripper_padding = 0.0;  ///< largest of gripper and held stone [m]
};

/// Two movers that could touch; the second is on the same or a later link.
struct MoverPair {
  std::size_t first, second;
};

/// The half space that a wall of a fence leaves: n.p + offset > 0, in R.
struct FenceWall {
  Eigen::Vector3d n_R;
  double offset = 0.0;  ///< [m]
};

struct CollisionShapes {
  static constexpr std::size_t kMaxMovers = 64;

  RobotModel robot;
  CollisionRules rules;
  std::vector<Mover> movers;
  std::vector<ObstaclePiece> obstacles;
  std::vector<ObstacleGroup> groups;
  std::vector<MoverPair> pairs;  ///< all that could touch
  // Gripper and held stone are on one link: a capsule around both spares most of their tests.
  std::size_t first_gripper = 0;          ///< movers from here on
  ConvexCore gripper;                     ///< around them, in the frame of link 6
  double gripper_span = 0.0;              ///< like Mover [m]::span
  double gripper_table_padding = 0.0;     ///< largest of them [m]
  std::vector<MoverPair> arm_pairs;       ///< of `pairs`, those within the arm
  std::vector<std::size_t> sees_gripper;  ///< capsules of the arm that the gripper could touch
  Pose T_6_T = Pose::Identity();
  Eigen::Vector3d n_R_table;  ///< up
  double table_offset = 0.0;  ///< height of p above the table: n.p + offset
  std::vector<FenceWall> walls;
};
[[nodiscard]] CollisionShapes make_collision_shapes(const PlanningScene& scene, const CollisionRules& rules,
                                                    const HeldObject* held);

}  // namespace stonestack::motion
