#pragma once
#include <string>
#include <vector>

#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/motion/planning_scene.hpp"
#include "stonestack/stone/catalogue.hpp"

namespace stonestack::experiment {

/// Stones that each run of an experiment has for itself: the catalogue of run `k` follows from seed and `k`
/// alone. A stone that gripper or arm cannot carry is passed over.
class NewStones {
 public:
  /// `count` stones a run. With a folder they are drawn from the catalogue there: the stones in an order of
  /// their own, cut into sets, so that no stone comes twice before all sets were used; then in another order.
  /// `gripper` by its name; empty: robotiq-3f. Without a folder, each is a limestone that was never there
  /// before, named limestone_SEED_NUMBER.
  /// @throws FileError InvalidArgument if the folder holds too few stones
  NewStones(int count, const std::string& folder, int seed, const RobotModel& robot,
            const std::string& gripper = "");

  /// Stones of run `k` (from 1), whose seed is `run_seed`, sorted by name.
  [[nodiscard]] Catalogue of_run(int k, int run_seed) const;

 private:
  [[nodiscard]] Catalogue drawn(int k) const;
  [[nodiscard]] Catalogue generated(int run_seed) const;

  int count_;
  int seed_;
  RobotModel robot_;
  GripperModel gripper_;
  Catalogue pool_;  ///< fit stones; empty: generated
};

}  // namespace stonestack::experiment
