#pragma once
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "motion/pad_press.hpp"
#include "stonestack/motion/grasp_check.hpp"

namespace stonestack {

/// A grasp with joint angles at both ends, and what it promises to cost.
struct PickCandidate {
  int grasp = -1;
  Joints q_pick, q_place;
  double price = 0.0;  ///< s, what the grasp itself is charged for
  double cost = 0.0;   ///< s, the price and a lower bound of the motion
};

/// The usable grasps of a task, each with a few inverse kinematic solutions in which the arm is free at both
/// ends, cheapest first. How firmly a
/// grasp holds is worked out only when its turn comes; a loose one goes back into the queue at its price.
class PickCandidates {
 public:
  /// With these joints the arm is free at a grasp (index into the set): GraspFinder::arm_is_free.
  using ArmIsFree = std::function<bool(int, const Joints&)>;
  /// What is passed must outlive this, but not `arm_is_free`.
  PickCandidates(const PlanningScene& scene, const PickAndPlaceTask& task, const MotionOptions& options,
                 const GraspSet& set, const GraspCheck& check, const ArmIsFree& arm_is_free);
  /// The cheapest that was not given out yet.
  [[nodiscard]] std::optional<PickCandidate> next();

 private:
  struct Entry {
    PickCandidate candidate;
    bool pressed = false;  // the price of looseness is in
  };
  struct Later;
  [[nodiscard]] double looseness_cost(int grasp);
  void push(Entry entry);

  const PickAndPlaceTask& task_;
  const GripperModel& gripper_;
  const GraspSet& set_;
  std::vector<SurfaceSample> surface_;  // empty: looseness costs nothing
  std::vector<Entry> heap_;
  std::map<int, double> looseness_;  // s, by grasp
};

}  // namespace stonestack
