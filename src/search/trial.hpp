#pragma once
#include "search/search_context.hpp"

namespace stonestack {

/// A proposal on its way through simulation.
struct Trial {
  int stone = -1;
  Pose T_W_O = Pose::Identity();  ///< proposed
  double estimate = 0.0;          ///< g, of the proposal
  double look_ahead = 0.0;        ///< g

  bool alive = true;
  std::string outcome;  ///< why it was dropped
  Placement placement;  ///< with the pose at rest
  double margin = 0.0;  ///< g, of the whole stack by equilibrium
  double score = 0.0;   ///< what to verify first: margin and look-ahead
  int tried = 0;        ///< worlds with displaced placements and centres of mass,
  int survived = 0;     ///< of which it stood in so many
};

/// Lets the stone down on the stack `below`, held fixed, and solves the equilibrium of the whole: fills the
/// pose at rest, its polygon, cost and margin, or says why not. The stack must be left at least
/// `least_margin`.
void settle_trial(const SearchContext& context, const Stack& below, Trial* trial);

/// Judges the whole stack with every stone dynamic, then k placements displaced by the placement uncertainty;
/// fills `predicted_success`. Every trial sees the same k displacements.
void judge_trial(const SearchContext& context, const Stack& below, Trial* trial);

/// Four times as many displacements for a judged trial that did not survive all: with eight, what is believed
/// to stand in a quarter of the cases stands in half of them (bench calibration).
void judge_longer(const SearchContext& context, const Stack& below, Trial* trial);

/// Chance that the finished tower stands, as far as this step can tell: success of this placement, reserve of
/// the whole stack, prospects of the next.
[[nodiscard]] double worth(const SearchContext& context, const Trial& trial);

}  // namespace stonestack
