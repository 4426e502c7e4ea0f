#pragma once
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "motion/collision.hpp"
#include "motion/grasp/gripper_check.hpp"
#include "motion/grasp_check.hpp"

namespace stonestack::motion {

/// Obstruction of a grasp at one end of its path.
enum class EndFault { kTooWeak, kTable, kObject, kReach, kArm };

/// Whether grasps of a stone serve where it lies or is to lie: the straight path of the gripper, the grip's
/// strength, inverse kinematics of the grasp and of the ends of approach and lift, the arm. One scene, any
/// number of poses; const methods may be called from several threads.
class GraspEnd {
 public:
  /// `object`: the stone's index in scene.objects (it does not count), or -1. What is passed must outlive
  /// this.
  GraspEnd(const PlanningScene& scene, const Stone& stone, int object, const MotionOptions& options);

  /// Why the grasp does not serve with the stone at T_W_O; empty: it does.
  [[nodiscard]] std::optional<EndFault> fault(const Grasp& grasp, const Pose& T_W_O) const;
  /// The first tests alone: gripper against table and objects, and the grip's strength. They do not change
  /// when the stone is turned about the vertical on an empty table.
  [[nodiscard]] std::optional<EndFault> gripper_fault(const Grasp& grasp, const Pose& T_W_O) const;
  /// With these joints the arm meets nothing and itself nowhere, while the gripper is at the grasp and open.
  [[nodiscard]] bool arm_is_free(const Grasp& grasp, const Joints& q) const;
  /// Returns the check for the same robot and gripper with these objects in place of the scene's.
  [[nodiscard]] GraspEnd among(std::span<const SceneObject> objects) const;
  /// Selects the grasps with the indices `among` that serve, until `enough` are found (0: all).
  [[nodiscard]] std::vector<int> serving(std::span<const Grasp> grasps, std::span<const int> among,
                                         const Pose& T_W_O, std::size_t enough = 0) const;
  /// True if the gripper meets an object, the table not regarded, at each of the grasps that approach within
  /// `cone` (rad) of `n_O_towards`, and these are many.
  [[nodiscard]] bool all_blocked(std::span<const Grasp> grasps, const Pose& T_W_O,
                                 const Eigen::Vector3d& n_O_towards, double cone) const;

 private:
  /// The gripper at one spacing of its fingers.
  struct SpacedGripper {
    double spacing = 0.0;
    GripperCheck check;
    CollisionChecker arm;
    std::vector<CollisionChecker>
        open;  ///< arm against open fingers, kOpeningStep more each; empty: not asked
  };
  [[nodiscard]] const SpacedGripper& gripper(const Grasp& grasp) const;
  [[nodiscard]] GripperCheck::Fingers fingers(const Grasp& grasp) const;
  [[nodiscard]] bool too_weak(const Grasp& grasp, const Pose& T_W_T) const;
  [[nodiscard]] std::optional<EndFault> arm_fault(const Grasp& grasp, const Pose& T_W_T) const;

  GraspEnd(const GraspEnd& other, std::span<const SceneObject> objects);
  void make_grippers(const PlanningScene& scene, int object);

  const PlanningScene& scene_;  // its objects are not looked at again
  const Stone& stone_;
  MotionOptions options_;
  std::vector<SpacedGripper> grippers_;
};

/// The grasps of a stone to pick it up with where it lies. Where hardly any of the usual ones serves, more
/// are sampled, once (2 to 9 s of one thread): in all directions where other objects obstruct; where it
/// is the table, those from above 24 times as densely, fingers opened less. None are sampled where an object
/// obstructs all of many usual ones, whatever the table. Flat stones have few grasps as they
/// lie: of the sixteen rocks stone_154, stone_156, stone_160, stone_163, stone_177 and stone_178.
[[nodiscard]] std::shared_ptr<const GraspSet> grasps_to_pick(const GraspEnd& end, const Stone& stone,
                                                             const GripperModel& gripper,
                                                             const Pose& T_W_O_pick);

/// A stone where it is to be picked up: its grasps, and their test. What is passed must outlive this.
struct PickSide {
  PickSide(const PlanningScene& scene, const Stone& the_stone, int object, const Pose& T_W_O_pick,
           const MotionOptions& options)
      : stone(the_stone),
        end(scene, stone, object, options),
        set(grasps_to_pick(end, stone, scene.gripper, T_W_O_pick)) {}

  const Stone& stone;
  GraspEnd end;
  std::shared_ptr<const GraspSet> set;
};

}  // namespace stonestack::motion
