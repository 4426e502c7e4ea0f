#pragma once
#include <functional>
#include <optional>
#include <string>
#include <utility>

#include "motion/collision.hpp"
#include "motion/grasp.hpp"
#include "stonestack/motion/pick_and_place.hpp"

namespace stonestack::motion {

/// Part of the path that failed; reasons count by it.
enum class PathFault { kNone, kApproach, kLift, kLower, kRetreat, kTransit, kCarry };
[[nodiscard]] const char* to_text(PathFault fault);

/// A path between straight motions, and how far its corners may be cut.
struct Transit {
  JointPath path;
  double blend = 0.0;  ///< [rad]
};

/// The joint paths of one pick and place, all free of collision.
struct PickPaths {
  Transit to_pick;     ///< q_start to where the approach begins
  JointPath approach;  ///< to the grasp
  JointPath lift;      ///< grasp, straight up
  Transit carry;       ///< to above the target
  JointPath lower;     ///< straight down to where the guarded part begins
  JointPath
      descent;  ///< guarded, through the target to `descent_past` below or where the gripper has no clearance
  JointPath retreat;  ///< from the target straight back, as far as there is clearance
};

/// A checker that is made when it is first asked for: most attempts fail before they need more than one.
class LazyChecker {
 public:
  explicit LazyChecker(std::function<CollisionChecker()> make) : make_(std::move(make)) {}
  [[nodiscard]] const CollisionChecker& get() const {
    if (!made_) made_.emplace(make_());
    return *made_;
  }

 private:
  std::function<CollisionChecker()> make_;
  mutable std::optional<CollisionChecker> made_;
};

/// One grasp of one task, for one thread: checkers made once, then tried with several inverse kinematic
/// solutions.
class PickAttempt {
 public:
  PickAttempt(const PlanningScene& scene, const PickAndPlaceTask& task, const MotionOptions& options,
              const Grasp& grasp);
  PickAttempt(const PickAttempt&) = delete;  // its checkers refer to it
  PickAttempt& operator=(const PickAttempt&) = delete;
  /// The whole path with these joint angles at the grasp and at the target; `fault` says what failed.
  struct Result {
    PathFault fault = PathFault::kNone;
    PickPaths paths;
  };
  /// `effort`: how long the search for a path lasts where there seems to be none.
  enum class Effort { kLittle, kMuch };
  [[nodiscard]] Result try_joints(const Joints& q_pick, const Joints& q_place, Effort effort) const;

 private:
  [[nodiscard]] CollisionChecker empty_gripper(double padding) const;
  [[nodiscard]] CollisionChecker loaded_gripper(double padding) const;
  [[nodiscard]] std::optional<JointPath> straight(const Joints& q, const Pose& T_W_T) const;
  /// From where the stone lies up, or first aslant where straight up is not free.
  [[nodiscard]] std::optional<JointPath> lifted(const Joints& q_pick) const;
  /// Out of a gap or a lean to the side where there is most clearance, then up.
  [[nodiscard]] std::optional<JointPath> lifted_aslant(const Joints& q_pick) const;
  /// From there up with the stone, as far as it is lifted, or half of that where the arm has no more
  /// clearance.
  [[nodiscard]] std::optional<JointPath> raised_straight(const Joints& q, const Pose& T_W_T) const;
  /// From the target on down, as far as a stone that has not touched is looked for with the gripper clear.
  [[nodiscard]] std::optional<JointPath> descend_past(const Joints& q) const;
  /// From the target straight back, or a part of that where the arm has no more clearance and the open
  /// gripper is far enough from the stone for a transit all the same.
  [[nodiscard]] std::optional<JointPath> retreat(const Joints& q) const;
  /// The stone there and nothing else.
  [[nodiscard]] PlanningScene alone(const Pose& T_W_O) const;
  [[nodiscard]] PathFault straight_parts(const Joints& q_pick, const Joints& q_place, PickPaths& paths) const;
  [[nodiscard]] std::optional<Transit> transit(const LazyChecker& wide, const LazyChecker& tight,
                                               const Joints& a, const Joints& b, Effort effort) const;

  PlanningScene scene_;  ///< with the fingers as the grasp wants them
  const PickAndPlaceTask& task_;
  const MotionOptions& options_;
  Pose T_W_T_pick_, T_W_T_place_, T_T_O_;
  double opening_, holding_;  ///< of the gripper before and after it holds the stone, and meanwhile [m]
  CollisionChecker open_;     ///< gripper open, the stone not there: approach, retreat
  LazyChecker beside_picked_, beside_placed_;  ///< the arm's links and the stone: approach, retreat
  LazyChecker open_wide_;                      ///< gripper open, the stone there: transit
  LazyChecker open_tight_;                     ///< the same with the padding of an approach
  LazyChecker held_;                           ///< stone in the gripper, padding of an approach
  LazyChecker held_wide_;                      ///< stone in the gripper, transit
};

/// The arm's links and the one stone of a scene, without the table: on approach and retreat they keep from it
/// as on a transit. The gripper is about to touch it, or just has, and may.
[[nodiscard]] CollisionChecker links_beside(PlanningScene alone, const MotionOptions& options,
                                            double opening);
/// Rules of a checker with that clearance [m] and opening [m], one object left out.
[[nodiscard]] CollisionRules rules(double padding, double opening, int left_out);
/// Times the paths. `pick` is the opening with the stone between the pads.
[[nodiscard]] std::vector<PlanStep> timed_steps(const PlanningScene& scene, const PickAndPlaceTask& task,
                                                const MotionOptions& options, const Grasp& grasp,
                                                const PickPaths& paths);

}  // namespace stonestack::motion
