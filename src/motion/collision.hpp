#pragma once
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "stonestack/motion/planning_scene.hpp"

namespace stonestack::motion {

/// Object between the fingers.
struct HeldObject {
  std::string name;
  std::vector<Mesh> pieces;  ///< convex, in O
  Pose T_T_O = Pose::Identity();
};

/// The table, where an index of scene.objects could stand.
inline constexpr int kTableObject = -1;

/// Permitted contacts, and the clearance of everything else.
struct CollisionRules {
  double padding = 0.010;              ///< 0.010 in transit, 0.002 on approach, 0 at contact [m]
  double self_padding = 0.005;         ///< arm against itself, the gripper and what it holds [m]
  double opening = 0.155;              ///< of the fingers [m]
  int left_out = -1;                   ///< index of an object that is not there (it is held); -1: none
  std::vector<int> held_may_touch;     ///< objects, or kTableObject: supports of the held stone
  std::vector<int> gripper_may_touch;  ///< objects, or kTableObject: what the fingers are about to grasp
};

/// The two things that are nearest to each other.
struct Clearance {
  double distance =
      std::numeric_limits<double>::infinity();  ///< between surfaces [m]; negative: overlap depth
  std::string first;                            ///< "forearm", "finger", a held stone's name
  std::string second;                           ///< "table", an object's name, a link
};

/// Arm, gripper and what it holds against table, objects and itself: capsules, boxes and convex pieces,
/// exact distances (Bullet's GJK behind tests of segments against spheres and boxes). Built once for a scene;
/// then asked from any number of threads; `collides` does not allocate. The base and shoulder do not see the
/// table, and neighbouring links do not see each other.
class CollisionChecker {
 public:
  /// Throws InvalidArgument for a piece without vertices or with numbers that are not finite.
  explicit CollisionChecker(const PlanningScene& scene, const CollisionRules& rules = {},
                            const HeldObject* held = nullptr);
  ~CollisionChecker();
  CollisionChecker(CollisionChecker&&) noexcept;
  CollisionChecker& operator=(CollisionChecker&&) noexcept;

  /// True if two things that must not touch are nearer than their padding plus `extra` (m).
  [[nodiscard]] bool collides(const Joints& q, double extra = 0.0) const;
  /// True if the straight joint motion from `a` to `b` is free everywhere, not only at samples: pieces of it
  /// are halved until nothing can reach an obstacle within a piece. A piece below `resolution` (rad, largest
  /// joint) that is still undecided counts as a collision.
  [[nodiscard]] bool motion_is_free(const Joints& a, const Joints& b, double resolution = 0.0005) const;
  /// True if samples of the straight joint motion are free, between which base and shoulder turn by at most
  /// `spacing` (rad), the wrist by more, since that moves the gripper less: a quick answer for searching, not
  /// a proof. The ends are not looked at.
  [[nodiscard]] bool samples_are_free(const Joints& a, const Joints& b, double spacing = 0.05) const;
  /// The smallest distance among all pairs that are checked, padding not regarded.
  [[nodiscard]] Clearance clearance(const Joints& q) const;

  [[nodiscard]] const RobotModel& robot() const;
  [[nodiscard]] const CollisionRules& rules() const;

 private:
  struct Shapes;
  std::unique_ptr<Shapes> shapes_;
};

/// True if nothing is in the way anywhere along a path; false for an empty one.
[[nodiscard]] bool is_free(const CollisionChecker& checker, const JointPath& path);

}  // namespace stonestack::motion
