#pragma once
#include <map>
#include <set>
#include <vector>

#include "motion/grasp_check.hpp"
#include "motion/regrasp.hpp"
#include "stonestack/stacking/observe.hpp"

/// Private to stacking/ and the commands: what a search may ask of arm and gripper.
namespace stonestack::stacking {

/// Reach of arm and gripper for the stones of one arrangement. What does not depend on the target is
/// computed once for each stone, when it is first asked about; so not to be shared by threads.
class Reach {
 public:
  /// `catalogue` and `options` must outlive it. Stones are asked about by their index in the catalogue, and
  /// must be among the loose ones (InvalidArgument else).
  Reach(Arrangement arrangement, PlanningScene scene, const Catalogue& catalogue,
        const MotionOptions& options);

  /// How grasps of the stone fare where it lies.
  [[nodiscard]] const GraspCheck& at_pick(StoneIndex stone) { return direct(stone).at_pick(); }

  /// Options of a plan with the stone: the given ones or, where no grasp holds it as it lies but
  /// some do with finger tips nearer to the table, as these ask for.
  [[nodiscard]] const MotionOptions& options_for(StoneIndex stone) {
    (void)direct(stone);
    return low_.contains(stone) ? near_table_ : options_;
  }
  [[nodiscard]] bool is_low(StoneIndex stone) { return &options_for(stone) == &near_table_; }

  /// Can the gripper bring the stone there without the grasps near `avoid`, in one go? `below`: the stack
  /// then.
  [[nodiscard]] bool in_one_go(StoneIndex stone, const Pose& T_W_O, const Stack& below,
                               const std::vector<Pose>& avoid = {});

  /// Likewise, if the stone is set down on the table in between.
  [[nodiscard]] bool by_reorienting(StoneIndex stone, const Pose& T_W_O, const Stack& below,
                                    const std::vector<Pose>& avoid, const RegraspOptions& regrasp);

  /// How the grasps of the stone fared at the last target that they could not serve in one go: "of 212 grasps
  /// ..."; empty: they served every one.
  [[nodiscard]] std::string refusal(StoneIndex stone) const;

 private:
  const GraspFinder& direct(StoneIndex stone);
  [[nodiscard]] PickAndPlaceTask lying(StoneIndex stone) const;
  /// Stones of `below` that do not stand yet.
  [[nodiscard]] std::vector<SceneObject> planned(const Stack& below) const;

  Arrangement arrangement_;
  PlanningScene scene_;
  const Catalogue& catalogue_;
  const MotionOptions& options_;
  MotionOptions near_table_;
  std::set<StoneIndex> low_;  ///< stones that only such grasps hold
  std::map<StoneIndex, GraspFinder> direct_;
  struct Turning {
    std::vector<Pose> avoided;  ///< grasps that the finder was made without
    RegraspFinder finder;
  };
  std::map<StoneIndex, Turning> turning_;
  std::map<StoneIndex, GraspCheck> refused_;  ///< of the last target that was refused
};

}  // namespace stonestack::stacking
