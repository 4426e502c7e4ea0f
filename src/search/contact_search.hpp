#pragma once
#include "search/initial_pose.hpp"
#include "search/pose_cost.hpp"

namespace stonestack::search {

/// How a stone came to touch the stack.
struct ContactSearch {
  bool valid = false;
  std::string outcome;  ///< when not valid: what was missing; of a step of the descent: that it is one
  Pose T_W_O = Pose::Identity();
  ContactPose pose;
  PoseCost cost;
  std::vector<Pose> path_W_O;
};

/// Valid contact pose search (paper §3.1): the stone is drawn by the force F along the thrust line (from its
/// centre of mass to C_j) on to the fixed stack, without gravity, until there are at least three contacts,
/// the centre of mass projects into their polygon and the kinetic energy is below its threshold. Contacts are
/// then collected over further steps (§3.2). A stone that touches anything but the top stone is not valid.
[[nodiscard]] ContactSearch search_contact(const SearchContext& context, const Target& target,
                                           StoneIndex stone, const Pose& T_W_O_init);

}  // namespace stonestack::search
