#include "motion/collision/collision_shapes.hpp"

#include <algorithm>
#include <cmath>

#include "motion/grasp/finger_reach.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::motion {
namespace {

void transform(std::vector<Eigen::Vector3d>& points, const Pose& T) {
  for (auto& p : points) p = T * p;
}

bool allowed(const std::vector<int>& list, int object) {
  return std::find(list.begin(), list.end(), object) != list.end();
}

bool may_touch(const CollisionRules& rules, const Mover& mover, int object) {
  if (mover.part == Mover::Part::kGripper) return allowed(rules.gripper_may_touch, object);
  if (mover.part == Mover::Part::kHeld) return allowed(rules.held_may_touch, object);
  return mover.link == 0 || (object == kTableObject && mover.link == 1);  // bolted down
}

/// Links whose capsules touch by construction, or nearly so in every pose: neighbours, the upper arm beside
/// the base, wrist 2 beside the forearm's end, wrist 3 beside wrist 1. Gripper and held stone are fixed to
/// wrist 3 and turn before wrist 2's face.
bool never_checked(const Mover& a, const Mover& b) {
  const std::size_t low = std::min(a.link, b.link);
  const std::size_t high = std::max(a.link, b.link);
  if (high - low < 2) return true;
  const bool both_arm = a.part == Mover::Part::kArm && b.part == Mover::Part::kArm;
  return both_arm && ((low == 0 && high == 2) || (low == 3 && high == 5) || (low == 4 && high == 6));
}

std::vector<Eigen::Vector3d> corners(const GripperModel& gripper, const GripperBox& box, double opening) {
  const Eigen::Vector3d centre = box_centre(gripper, box, opening);
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3d sign((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1, (i & 4) != 0 ? 1 : -1);
    points.push_back(centre + 0.5 * sign.cwiseProduct(box.size));
  }
  return points;
}

void add_mover(CollisionShapes& shapes, Mover::Part part, int link, ConvexCore core, const std::string& name,
               const Eigen::AlignedBox3d& box_T = {}) {
  Mover mover{part, static_cast<std::size_t>(link), std::move(core), 0.0, true, box_T, name};
  for (const auto& p : mover.core.points) mover.span = std::max(mover.span, p.norm());
  mover.sees_table = !may_touch(shapes.rules, mover, kTableObject);
  shapes.movers.push_back(std::move(mover));
}

/// How users call the part of a mover.
const char* part_name(Mover::Part part) {
  switch (part) {
    case Mover::Part::kGripper:
      return "hand";
    case Mover::Part::kHeld:
      return "held";
    default:
      return "arm";
  }
}

double padding_of(const PlanningScene& scene, const CollisionRules& rules, const Mover& mover,
                  const std::string& stands) {
  if (scene.paddings.empty()) return rules.padding;
  const std::string part = part_name(mover.part);
  return padding_between(scene, part, mover.part == Mover::Part::kArm ? mover.name : part, stands,
                         rules.padding);
}

/// Arm first, then gripper, then what it holds: links do not decrease.
void add_movers(const PlanningScene& scene, const HeldObject* held, CollisionShapes& shapes) {
  auto capsules = scene.robot.capsules;
  std::stable_sort(capsules.begin(), capsules.end(),
                   [](const LinkCapsule& a, const LinkCapsule& b) { return a.link < b.link; });
  for (const auto& c : capsules)
    add_mover(shapes, Mover::Part::kArm, c.link, make_core({c.a, c.b}, c.radius), link_name(c.link));
  shapes.T_6_T = scene.robot.T_6_F * scene.T_F_T;
  for (const auto& box : scene.gripper.boxes) {
    auto points = corners(scene.gripper, box, shapes.rules.opening);
    const Eigen::AlignedBox3d box_T(points.front(), points.back());
    transform(points, shapes.T_6_T);
    add_mover(shapes, Mover::Part::kGripper, 6, make_core(std::move(points), 0.0),
              box.finger_side != 0.0 ? "finger" : "gripper", box_T);
  }
  if (held == nullptr) return;
  for (const auto& piece : held->pieces) {
    auto points = piece.vertices;
    transform(points, shapes.T_6_T * held->T_T_O);
    add_mover(shapes, Mover::Part::kHeld, 6, make_core(std::move(points), 0.0), held->name);
  }
}

ObstaclePiece make_obstacle(std::vector<Eigen::Vector3d> points) {
  ObstaclePiece obstacle{make_core(std::move(points), 0.0), {}, 0.0, {}};
  Eigen::AlignedBox3d box;
  for (const auto& p : obstacle.core.points) box.extend(p);
  obstacle.box = {box.min(), box.max()};
  obstacle.centre = box.center();
  for (const auto& p : obstacle.core.points)
    obstacle.sphere = std::max(obstacle.sphere, (p - obstacle.centre).norm());
  return obstacle;
}

void add_object(const PlanningScene& scene, int index, const Pose& T_R_W, CollisionShapes& shapes) {
  const SceneObject& object = scene.objects[static_cast<std::size_t>(index)];
  ObstacleGroup group;
  group.name = object.name;
  group.first = shapes.obstacles.size();
  Eigen::AlignedBox3d box;
  for (const auto& piece : object.pieces) {
    auto points = piece.vertices;
    transform(points, T_R_W * object.T_W_object);
    shapes.obstacles.push_back(make_obstacle(std::move(points)));
    const Bounds& own = shapes.obstacles.back().box;
    box.extend(own.low).extend(own.high);
  }
  group.box = {box.min(), box.max()};
  group.last = shapes.obstacles.size();
  group.centre = box.center();
  for (std::size_t k = group.first; k < group.last; ++k) {
    const auto& piece = shapes.obstacles[k];
    group.sphere = std::max(group.sphere, (piece.centre - group.centre).norm() + piece.sphere);
  }
  for (const auto& mover : shapes.movers) {
    group.sees.push_back(may_touch(shapes.rules, mover, index) ? 0 : 1);
    group.padding.push_back(padding_of(scene, shapes.rules, mover, object.name));
    if (mover.part != Mover::Part::kArm)
      group.gripper_padding = std::max(group.gripper_padding, group.padding.back());
  }
  shapes.groups.push_back(std::move(group));
}

void add_pairs(CollisionShapes& shapes) {
  for (std::size_t i = 0; i < shapes.movers.size(); ++i)
    for (std::size_t j = i + 1; j < shapes.movers.size(); ++j)
      if (!never_checked(shapes.movers[i], shapes.movers[j])) shapes.pairs.push_back({i, j});
  for (const auto& pair : shapes.pairs) {
    if (pair.second < shapes.first_gripper)
      shapes.arm_pairs.push_back(pair);
    else if (shapes.sees_gripper.empty() || shapes.sees_gripper.back() != pair.first)
      shapes.sees_gripper.push_back(pair.first);
  }
}

void bound_gripper(CollisionShapes& shapes) {
  const auto is_gripper = [](const Mover& m) { return m.part != Mover::Part::kArm; };
  const auto first = std::find_if(shapes.movers.begin(), shapes.movers.end(), is_gripper);
  shapes.first_gripper = static_cast<std::size_t>(first - shapes.movers.begin());
  std::vector<Eigen::Vector3d> points;
  for (auto mover = first; mover != shapes.movers.end(); ++mover) {
    points.insert(points.end(), mover->core.points.begin(), mover->core.points.end());
    shapes.gripper_span = std::max(shapes.gripper_span, mover->span);
  }
  if (!points.empty()) shapes.gripper = make_core(std::move(points), 0.0);
}

void add_walls(CollisionShapes& shapes) {
  if (!shapes.robot.fence) return;
  const ArmFence& fence = *shapes.robot.fence;
  for (Eigen::Index i = 0; i < 3; ++i)
    for (const double sign : {1.0, -1.0}) {
      const Eigen::Vector3d n_W = sign * Eigen::Vector3d::Unit(i);
      const double wall = sign > 0 ? fence.box.min()[i] : -fence.box.max()[i];
      shapes.walls.push_back(
          {fence.T_W_R.linear().transpose() * n_W, n_W.dot(fence.T_W_R.translation()) - wall});
    }
}

}  // namespace

CollisionShapes make_collision_shapes(const PlanningScene& scene, const CollisionRules& rules,
                                      const HeldObject* held) {
  require(rules.padding >= 0.0 && rules.self_padding >= 0.0, "paddings must not be negative, got ",
          rules.padding, " and ", rules.self_padding, " m");
  require(std::isfinite(rules.opening), "the opening must be finite, got ", rules.opening, " m");
  CollisionShapes shapes;
  shapes.robot = scene.robot;
  shapes.rules = rules;
  add_movers(scene, held, shapes);
  require(shapes.movers.size() <= CollisionShapes::kMaxMovers, "arm, gripper and held stone have ",
          shapes.movers.size(), " collision shapes, at most ", CollisionShapes::kMaxMovers, " are checked");
  for (Mover& mover : shapes.movers) {
    mover.table_padding = padding_of(scene, rules, mover, "table");
    if (mover.part != Mover::Part::kArm)
      shapes.gripper_table_padding = std::max(shapes.gripper_table_padding, mover.table_padding);
  }
  const Pose T_R_W = scene.T_W_R.inverse();
  for (std::size_t i = 0; i < scene.objects.size(); ++i)
    if (static_cast<int>(i) != rules.left_out && !scene.objects[i].pieces.empty())
      add_object(scene, static_cast<int>(i), T_R_W, shapes);
  bound_gripper(shapes);
  add_pairs(shapes);
  add_walls(shapes);
  shapes.n_R_table = T_R_W.linear().col(2);
  shapes.table_offset = -shapes.n_R_table.dot(T_R_W * Eigen::Vector3d(0.0, 0.0, scene.table_z));
  return shapes;
}

}  // namespace stonestack::motion
