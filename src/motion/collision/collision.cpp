#include "motion/collision.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "motion/collision/collision_shapes.hpp"
#include "motion/collision/proof.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::motion {
namespace {

// m that the gripper moves by, about, while a joint turns by one rad.
const Joints kSwing = (Joints() << 1.0, 1.0, 0.7, 0.45, 0.4, 0.2).finished();

/// Where everything is at one configuration.
struct Placed {
  std::array<Pose, 7> pose;                               ///< T_R_link
  std::array<Segment, CollisionShapes::kMaxMovers> axes;  ///< of the movers' bounding capsules
  std::array<Bounds, CollisionShapes::kMaxMovers> boxes;  ///< of these axes
  Segment gripper;                                        ///< of the capsule around gripper and held stone
  Bounds gripper_box;

  Placed(const CollisionShapes& shapes, const Joints& q) : pose(link_poses(shapes.robot, q)) {
    for (std::size_t i = 0; i < shapes.movers.size(); ++i) {
      const auto& mover = shapes.movers[i];
      axes[i] = {pose[mover.link] * mover.core.axis.a, pose[mover.link] * mover.core.axis.b};
      boxes[i] = bounds(axes[i]);
    }
    if (shapes.first_gripper < shapes.movers.size()) {
      gripper = {pose[6] * shapes.gripper.axis.a, pose[6] * shapes.gripper.axis.b};
      gripper_box = bounds(gripper);
    }
  }
  [[nodiscard]] btTransform T_R(const Mover& mover) const { return to_bullet(pose[mover.link]); }
};

double height(const CollisionShapes& shapes, const Mover& mover, const Placed& placed) {
  return height_above(shapes.n_R_table, shapes.table_offset, mover, placed.pose[mover.link]);
}

bool leaves_fence(const CollisionShapes& shapes, const Placed& placed, double extra) {
  const double away = kWorkspaceMargin + extra;
  for (const FenceWall& wall : shapes.walls)
    for (std::size_t i = 0; i < shapes.movers.size(); ++i) {
      const Mover& mover = shapes.movers[i];
      if (mover.link < kFirstFencedLink) continue;
      const double axis = std::min(wall.n_R.dot(placed.axes[i].a), wall.n_R.dot(placed.axes[i].b));
      if (axis + wall.offset - mover.core.reach < away &&
          height_above(wall.n_R, wall.offset, mover, placed.pose[mover.link]) <= away)
        return true;
    }
  return false;
}

bool hits_table(const CollisionShapes& shapes, const Placed& placed, double extra) {
  const auto axis_height = [&](const Segment& axis) {
    return std::min(shapes.n_R_table.dot(axis.a), shapes.n_R_table.dot(axis.b)) + shapes.table_offset;
  };
  const bool gripper_is_high =
      shapes.first_gripper < shapes.movers.size() &&
      axis_height(placed.gripper) > shapes.gripper.reach + shapes.gripper_table_padding + extra;
  const std::size_t last = gripper_is_high ? shapes.first_gripper : shapes.movers.size();
  for (std::size_t i = 0; i < last; ++i) {
    const auto& mover = shapes.movers[i];
    if (!mover.sees_table) continue;
    const double away = mover.table_padding + extra;
    if (axis_height(placed.axes[i]) - mover.core.reach < away && height(shapes, mover, placed) < away)
      return true;
  }
  return false;
}

/// Computes the exact distance only where capsule against sphere and against box do not decide.
bool hits(const Placed& placed, const Mover& mover, std::size_t i, const ObstaclePiece& obstacle,
          double away) {
  const double bound = mover.core.reach + away;
  if (apart(placed.boxes[i], obstacle.box, bound)) return false;
  const double ball = bound + obstacle.sphere;
  const Segment& axis = placed.axes[i];
  if (squared_distance(axis, obstacle.centre) > ball * ball) return false;
  if (squared_distance_to_box(axis, obstacle.box.low, obstacle.box.high) > bound * bound) return false;
  // Hulls that overlap are 0 apart: without padding, too, that is a hit.
  return hull_distance(mover.core, placed.T_R(mover), obstacle.core, btTransform::getIdentity()) <=
         mover.core.radius + away;
}

bool hits_objects(const CollisionShapes& shapes, const Placed& placed, double extra) {
  const double gripper_reach = shapes.gripper.reach + extra;
  for (const auto& group : shapes.groups) {
    const double gripper_ball = gripper_reach + group.gripper_padding;
    const double ball_of_gripper = gripper_ball + group.sphere;
    const bool gripper_is_far =
        shapes.first_gripper < shapes.movers.size() &&
        (apart(placed.gripper_box, group.box, gripper_ball) ||
         squared_distance(placed.gripper, group.centre) > ball_of_gripper * ball_of_gripper);
    const std::size_t last = gripper_is_far ? shapes.first_gripper : shapes.movers.size();
    for (std::size_t i = 0; i < last; ++i) {
      if (group.sees[i] == 0) continue;
      const auto& mover = shapes.movers[i];
      const double away = group.padding[i] + extra;
      if (apart(placed.boxes[i], group.box, mover.core.reach + away)) continue;
      for (std::size_t k = group.first; k < group.last; ++k)
        if (hits(placed, mover, i, shapes.obstacles[k], away)) return true;
    }
  }
  return false;
}

bool arm_hits_arm(const CollisionShapes& shapes, const Placed& placed, double extra) {
  for (const auto& [i, j] : shapes.arm_pairs) {
    const auto &a = shapes.movers[i], &b = shapes.movers[j];
    const double bound = a.core.reach + b.core.reach + shapes.rules.self_padding + extra;
    if (apart(placed.boxes[i], placed.boxes[j], bound)) continue;
    // Between capsules the bound is the distance.
    if (squared_distance(placed.axes[i], placed.axes[j]) <= bound * bound) return true;
  }
  return false;
}

/// One capsule of the arm against gripper and held stone.
bool hits_gripper(const CollisionShapes& shapes, const Placed& placed, double extra, std::size_t i) {
  const Mover& a = shapes.movers[i];
  const Segment& axis = placed.axes[i];
  const Pose T_T_R = (placed.pose[6] * shapes.T_6_T).inverse();
  const Segment axis_T{T_T_R * axis.a, T_T_R * axis.b};
  for (std::size_t j = shapes.first_gripper; j < shapes.movers.size(); ++j) {
    const Mover& b = shapes.movers[j];
    const double away = shapes.rules.self_padding + extra;
    const double bound = a.core.reach + b.core.reach + away;
    if (apart(placed.boxes[i], placed.boxes[j], bound)) continue;
    if (squared_distance(axis, placed.axes[j]) > bound * bound) continue;
    const double min = a.core.radius + away;
    if (b.part == Mover::Part::kGripper) {
      if (squared_distance_to_box(axis_T, b.box_T.min(), b.box_T.max()) < min * min) return true;
    } else if (hull_distance(a.core, placed.T_R(a), b.core, placed.T_R(b)) < min) {
      return true;
    }
  }
  return false;
}

bool hits_itself(const CollisionShapes& shapes, const Placed& placed, double extra) {
  if (arm_hits_arm(shapes, placed, extra)) return true;
  for (const std::size_t i : shapes.sees_gripper) {
    const Mover& a = shapes.movers[i];
    const double bound = a.core.reach + shapes.gripper.reach + shapes.rules.self_padding + extra;
    if (apart(placed.boxes[i], placed.gripper_box, bound)) continue;
    if (squared_distance(placed.axes[i], placed.gripper) <= bound * bound &&
        hits_gripper(shapes, placed, extra, i))
      return true;
  }
  return false;
}

bool collides_within(const CollisionShapes& shapes, const Joints& q, double extra) {
  const Placed placed(shapes, q);
  return workspace_left(shapes, placed.pose) <= kWorkspaceMargin + extra ||
         leaves_fence(shapes, placed, extra) || hits_table(shapes, placed, extra) ||
         hits_objects(shapes, placed, extra) || hits_itself(shapes, placed, extra);
}

/// Tests the middle of ever shorter pieces, the middle of the whole first: most motions that are not free
/// are known at once.
bool samples_miss(const CollisionShapes& shapes, const Joints& a, const Joints& b, double spacing) {
  const double turn = (b - a).cwiseAbs().cwiseProduct(kSwing).maxCoeff();
  for (double pieces = 1.0; turn / pieces > spacing; pieces *= 2.0)
    for (double k = 0.5; k < pieces; k += 1.0)
      if (collides_within(shapes, a + (b - a) * (k / pieces), 0.0)) return false;
  return true;
}

}  // namespace

struct CollisionChecker::Shapes : CollisionShapes {};

CollisionChecker::CollisionChecker(const PlanningScene& scene, const CollisionRules& rules,
                                   const HeldObject* held)
    : shapes_(std::make_unique<Shapes>(Shapes{make_collision_shapes(scene, rules, held)})) {}
CollisionChecker::~CollisionChecker() = default;
CollisionChecker::CollisionChecker(CollisionChecker&&) noexcept = default;
CollisionChecker& CollisionChecker::operator=(CollisionChecker&&) noexcept = default;

bool CollisionChecker::collides(const Joints& q, double extra) const {
  return collides_within(*shapes_, q, extra);
}

bool CollisionChecker::motion_is_free(const Joints& a, const Joints& b, double resolution) const {
  require(a.allFinite() && b.allFinite(), "a motion needs finite joint angles");
  require(resolution > 0.0, "the resolution must be positive, got ", resolution, " rad");
  constexpr double kCoarseResolution = 0.05;  // rad
  return samples_miss(*shapes_, a, b, kCoarseResolution) && is_free_continuously(*shapes_, a, b, resolution);
}

bool CollisionChecker::samples_are_free(const Joints& a, const Joints& b, double spacing) const {
  require(a.allFinite() && b.allFinite(), "a motion needs finite joint angles");
  require(spacing > 0.0, "the spacing must be positive, got ", spacing, " rad");
  return samples_miss(*shapes_, a, b, spacing);
}

Clearance CollisionChecker::clearance(const Joints& q) const {
  const CollisionShapes& shapes = *shapes_;
  const Placed placed(shapes, q);
  Clearance best;
  const auto offer = [&](double distance, const std::string& first, const std::string& second) {
    if (distance < best.distance) best = {distance, first, second};
  };
  for (std::size_t i = 0; i < shapes.movers.size(); ++i) {
    const auto& mover = shapes.movers[i];
    if (mover.sees_table) offer(height(shapes, mover, placed), mover.name, "table");
    for (const auto& group : shapes.groups) {
      for (std::size_t k = group.sees[i] != 0 ? group.first : group.last; k < group.last; ++k) {
        const auto& obstacle = shapes.obstacles[k];
        const double apart = std::sqrt(squared_distance(placed.axes[i], obstacle.centre));
        if (apart - mover.core.reach - obstacle.sphere >= best.distance) continue;
        const double hulls =
            hull_distance(mover.core, placed.T_R(mover), obstacle.core, btTransform::getIdentity(), true);
        offer(hulls - mover.core.radius, mover.name, group.name);
      }
    }
  }
  for (const auto& [i, j] : shapes.pairs) {
    const auto &a = shapes.movers[i], &b = shapes.movers[j];
    const double apart = std::sqrt(squared_distance(placed.axes[i], placed.axes[j]));
    if (apart - a.core.reach - b.core.reach >= best.distance) continue;
    const double hulls = hull_distance(a.core, placed.T_R(a), b.core, placed.T_R(b), true);
    offer(hulls - a.core.radius - b.core.radius, a.name, b.name);
  }
  return best;
}

const RobotModel& CollisionChecker::robot() const {
  return shapes_->robot;
}
const CollisionRules& CollisionChecker::rules() const {
  return shapes_->rules;
}

bool is_free(const CollisionChecker& checker, const JointPath& path) {
  for (std::size_t i = 0; i + 1 < path.size(); ++i)
    if (!checker.motion_is_free(path[i], path[i + 1])) return false;
  return !path.empty();
}

}  // namespace stonestack::motion
