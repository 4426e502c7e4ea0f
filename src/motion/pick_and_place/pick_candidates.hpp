#pragma once
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "motion/grasp/pad_press.hpp"
#include "motion/grasp_check.hpp"

namespace stonestack::motion {

/// A grasp with joint angles at both ends, and what it promises to cost.
struct PickCandidate {
  int grasp = -1;
  Joints q_pick, q_place;
  double price = 0.0;  ///< what the grasp itself is charged for [s]
  double cost = 0.0;   ///< the price and a lower bound of the motion [s]
};

/// The usable grasps of a task, each with a few inverse kinematic solutions in which the arm is free at both
/// ends, cheapest first. How firmly a grasp holds is worked out only when its turn comes, and in parts: what
/// is known of its price so far is a lower bound with which it goes back into the queue.
class PickCandidates {
 public:
  /// With these joints the arm is free at a grasp (index into the set): GraspFinder::arm_is_free.
  using ArmIsFree = std::function<bool(int, const Joints&)>;
  /// The arguments must outlive this object, but not `arm_is_free`.
  PickCandidates(const PlanningScene& scene, const PickAndPlaceTask& task, const MotionOptions& options,
                 const GraspSet& set, const GraspCheck& check, const ArmIsFree& arm_is_free);
  /// The cheapest that was not given out yet.
  [[nodiscard]] std::optional<PickCandidate> next();

 private:
  /// Looseness of a grasp: how the stone lies between the closed pads, then how it
  /// hangs where it lies, then at the target. Each part can only add to the cost.
  struct Looseness {
    std::optional<PadPress> pads;
    double pressed = 0.0;           ///< risk from how deep it presses into a pad
    double turned = 0.0;            ///< for the turn that closing brings [s]
    double risk = 0.0;              ///< that it slips, largest of the ends looked at
    std::vector<double> cost{0.0};  ///< after so many parts [s]
  };
  struct Entry {
    PickCandidate bare;      ///< without what looseness costs
    double looseness = 0.0;  ///< of the parts that are in [s]
    std::size_t parts = 0;   ///< that are in
    [[nodiscard]] double cost() const { return bare.cost + looseness; }
  };
  struct Later;
  /// A grasp's looseness from its first `parts` parts [s].
  [[nodiscard]] double looseness_cost(int grasp, std::size_t parts);
  void add_part(const Grasp& grasp, Looseness& looseness) const;
  void push(Entry entry);

  const PickAndPlaceTask& task_;
  const GripperModel& gripper_;
  const GraspSet& set_;
  std::vector<SurfaceSample> surface_;  // empty: looseness costs nothing
  std::vector<Entry> heap_;
  std::map<int, Looseness> looseness_;  // by grasp
};

}  // namespace stonestack::motion
