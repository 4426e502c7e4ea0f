#pragma once
#include <optional>
#include <string>

#include "stacking/journal.hpp"
#include "stonestack/hardware/cell.hpp"
#include "stonestack/motion/pick_and_place.hpp"

namespace stonestack::stacking {

/// How carrying out a plan ended.
struct ExecutionResult {
  /// kNotPicked: it did not come up with the gripper. kLost: it came up and fell out of the gripper on the
  /// way. kUnknown: the program ended meanwhile, and the next view decides. kTakenBack: likewise, and then
  /// the stone was set down where it had been picked.
  enum class Status { kReleased, kNotPicked, kLost, kStopped, kUnknown, kTakenBack };
  Status status = Status::kReleased;
  double contact_force = 0.0;  ///< at the end of the guarded descent [N]
  std::string reason;          ///< when it was not released
  /// Friction between the stone and the table, where it was measured before the release.
  std::optional<double> friction = std::nullopt;
  /// Weight of the stone once it was lifted and held, as the wrist measured it right after taring [N].
  std::optional<double> weight = std::nullopt;
};

/// How a stone is let go of at the end of a plan.
enum class LetGo {
  kResting,    ///< it rests; nothing may be left in the fingers before they leave it
  kDragged,    ///< likewise, once it was dragged over the table, to measure the friction
  kTippedOver  ///< it falls over on the table, onto the fingers perhaps; nothing may be left in them
               ///< afterwards. Its mass is a guess: what is lifted is weighed, not compared
};

/// Carries out a plan step by step: every step is in the journal before it begins. Payload follows the grasp.
/// Before the gripper is lowered, and before the guarded descent, wrist and gripper check whether the stone
/// is still there; if not, the gripper returns along the same path and opens where the carry began. What
/// touches while it is lowered, before the guarded descent, is released there: the stone is held otherwise
/// than planned, and the next view shows how it lies. After contact the retreat is planned anew from the
/// arm's measured joints. A stop of the arm ends it at once, with the stone held.
[[nodiscard]] ExecutionResult execute(const PickAndPlacePlan& plan, const Stone& stone,
                                      const PlanningScene& scene, Cell& cell, const MotionOptions& options,
                                      Journal* journal, LetGo how = LetGo::kResting);

/// Carries out a `plan_push`. What is met on the way down, or resists more than a sliding stone does, ends
/// the push: the gripper returns along the path that it came on. kReleased if it pushed to the end or until
/// that; kNotPicked if it met something before.
[[nodiscard]] ExecutionResult execute_push(const PickAndPlacePlan& plan, const Stone& stone,
                                           const PlanningScene& scene, Cell& cell,
                                           const MotionOptions& options, Journal* journal);

}  // namespace stonestack::stacking
