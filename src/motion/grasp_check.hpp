#pragma once
#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "motion/grasp.hpp"
#include "stonestack/motion/pick_and_place.hpp"

namespace stonestack::motion {

/// Why a grasp does not serve; in the order of the tests.
enum class GraspFault {
  kTooWeak,      ///< the fingers cannot hold the weight in that orientation
  kTableAtPick,  ///< the gripper, or its straight approach, meets the table
  kObjectAtPick,
  kReachAtPick,  ///< no inverse kinematics, or not for approach and lift on one branch
  kArmAtPick,    ///< the arm meets the scene or itself
  kTableAtPlace,
  kObjectAtPlace,
  kReachAtPlace,
  kArmAtPlace,
};
inline constexpr std::size_t kGraspFaults = 9;
/// "hit the table at pick"
[[nodiscard]] const char* to_text(GraspFault fault);

/// How the grasps of a stone fared.
struct GraspCheck {
  std::vector<int> usable;  ///< indices into the grasp set, best score first
  int total = 0;            ///< grasps looked at
  std::array<int, kGraspFaults> refused{};
  /// True if the gripper could hold the stone where it lies, but for what stands beside it and for the arm.
  [[nodiscard]] bool can_be_held() const;
  /// "of 212 grasps 140 hit the table at pick, 12 are out of reach at place"
  [[nodiscard]] std::string text() const;
};

/// Answers for one loose stone whether it can be grasped where it lies and set down at a target: inverse
/// kinematics and collision at both ends, not the path between. The pick side is worked out once; a target
/// then costs about a millisecond. Const methods may be called from several threads.
class GraspFinder {
 public:
  /// `object`: the stone's index in scene.objects, or -1. `scene` and `stone` must outlive the finder.
  /// Throws InvalidArgument for a pose or an index that cannot be.
  GraspFinder(const PlanningScene& scene, const Stone& stone, int object, const Pose& T_W_O_pick,
              const MotionOptions& options = {});
  ~GraspFinder();
  GraspFinder(GraspFinder&&) noexcept;
  GraspFinder& operator=(GraspFinder&&) noexcept;

  /// True if some grasp serves both ends: a SearchProblem::reachable.
  [[nodiscard]] bool serves(const Pose& T_W_O_place) const;
  /// All grasps, or until `enough` are found (0: all). `meanwhile`: objects that will stand there, too, when
  /// the stone is set down; gripper and arm must not meet them.
  [[nodiscard]] GraspCheck check(const Pose& T_W_O_place, int enough = 0,
                                 std::span<const SceneObject> meanwhile = {}) const;
  /// The pick side alone.
  [[nodiscard]] const GraspCheck& at_pick() const;
  /// True if the arm meets nothing and itself nowhere with these joints, its open gripper at that grasp of
  /// the stone. Other inverse solutions of a usable grasp may well be free.
  [[nodiscard]] bool arm_is_free(int grasp, const Joints& q) const;
  /// The grasps that usable indices mean.
  [[nodiscard]] const GraspSet& set() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// For one question. A loop over targets keeps a GraspFinder.
[[nodiscard]] bool can_grasp(const PlanningScene& scene, const PickAndPlaceTask& task,
                             const MotionOptions& options = {});
[[nodiscard]] GraspCheck check_grasps(const PlanningScene& scene, const PickAndPlaceTask& task,
                                      const MotionOptions& options = {});
/// True if some grasp is clear of table and objects, and strong enough, at both ends: what the gripper alone
/// could do, carried by any arm. Where it is false no planner finds a path in one go.
[[nodiscard]] bool gripper_can_grasp(const PlanningScene& scene, const PickAndPlaceTask& task,
                                     const MotionOptions& options = {});

}  // namespace stonestack::motion
