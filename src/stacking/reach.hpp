#pragma once
#include <map>
#include <set>
#include <vector>

#include "core/export.hpp"
#include "motion/grasp_check.hpp"
#include "motion/regrasp.hpp"
#include "stonestack/stacking/observe.hpp"

/// Private to stacking/ and the commands: what a search may ask of arm and gripper.
namespace stonestack::stacking {

/// Reach of arm and gripper for the stones of one arrangement. What does not depend on the target is
/// computed once for each stone, when it is first asked about; so not to be shared by threads.
class STONESTACK_EXPORT Reach {
 public:
  /// `catalogue` and `options` must outlive it. Stones are asked about by their index in the catalogue, and
  /// must be among the loose ones (InvalidArgument else).
  Reach(Arrangement arrangement, PlanningScene scene, const Catalogue& catalogue,
        const MotionOptions& options);

  /// How grasps of the stone fare where it lies.
  [[nodiscard]] const GraspCheck& at_pick(int stone) { return direct(stone).at_pick(); }

  /// How a plan with the stone is to be made: as the options say or, where no grasp holds it as it lies but
  /// some do with finger tips nearer to the table, as these ask for.
  [[nodiscard]] const MotionOptions& options_for(int stone) {
    (void)direct(stone);
    return low_.contains(stone) ? near_table_ : options_;
  }
  [[nodiscard]] bool is_low(int stone) { return &options_for(stone) == &near_table_; }

  /// Can the gripper bring the stone there without the grasps near `avoid`, in one go? `below`: the stack
  /// then.
  [[nodiscard]] bool in_one_go(int stone, const Pose& T_W_O, const Stack& below,
                               const std::vector<Pose>& avoid = {});

  /// Likewise, if the stone is set down on the table in between.
  [[nodiscard]] bool by_reorienting(int stone, const Pose& T_W_O, const Stack& below,
                                    const std::vector<Pose>& avoid, const RegraspOptions& regrasp);

 private:
  const GraspFinder& direct(int stone);
  [[nodiscard]] PickAndPlaceTask lying(int stone) const;
  /// Stones of `below` that do not stand yet.
  [[nodiscard]] std::vector<SceneObject> planned(const Stack& below) const;

  Arrangement arrangement_;
  PlanningScene scene_;
  const Catalogue& catalogue_;
  const MotionOptions& options_;
  MotionOptions near_table_;
  std::set<int> low_;  ///< stones that only such grasps hold
  std::map<int, GraspFinder> direct_;
  std::map<int, RegraspFinder> turning_;
};

}  // namespace stonestack::stacking
