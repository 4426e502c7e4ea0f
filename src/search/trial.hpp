#pragma once
#include <map>
#include <span>

#include "search/search_context.hpp"

namespace stonestack::search {

/// A proposal while it passes through simulation.
struct Trial {
  StoneIndex stone = kNoStone;
  Pose T_W_O = Pose::Identity();  ///< proposed
  double estimate = 0.0;          ///< of the proposal [g]
  double look_ahead = 0.0;        ///< [g]

  /// Stones may move a little and turn as the stack takes the load of this one. For walls that are measured
  /// after each stone.
  bool may_rock = false;
  /// Poses of all stones of the stack, this one last, after they did; empty where they may not.
  std::vector<Pose> T_W_O_loaded = {};

  bool alive = true;
  std::string outcome;      ///< why it was dropped
  Placement placement;      ///< with the pose at rest
  double margin = 0.0;      ///< of the whole stack by equilibrium [g]
  double turn_sigma = 0.0;  ///< how far it may turn as surface is unknown, rad: `rest_uncertainty`
  double score = 0.0;       ///< what to verify first: margin and look-ahead
  int worlds = 0;           ///< with displaced placements and centres of mass that it was tried in;
  int tried = 0;            ///< of these carry information,
  int survived = 0;         ///< and in so many it stood
  int shaken = 0;           ///< and outlasted a shake; asked of finished towers with the objective "firm"
};

/// Lets the stone down on the stack `below`, held fixed, and solves the equilibrium of the whole. The stack
/// must be left at least `min_margin` by its contacts; what held stones bear, whose contacts are not known,
/// only limits the margin that is reported, and is drawn in the displaced worlds.
/// @return the trial with its pose at rest, polygon, cost and margin, or dropped with the reason.
[[nodiscard]] Trial settled_trial(const SearchContext& context, const Stack& below, Trial trial);

/// Judges the whole stack with every stone dynamic. Where stones may rock, the stack must be left at least
/// `min_margin` afterwards.
/// @return the trial, dropped with the reason if the stack does not stand.
[[nodiscard]] Trial judged_trial(const SearchContext& context, const Stack& below, Trial trial);

/// A trial that was not taken, for reports.
[[nodiscard]] Alternative alternative_of(const Trial& trial);

/// A trial that was judged, and the stack it is put on.
struct Candidate {
  const Stack* below = nullptr;
  const Trial* trial = nullptr;
  bool shake = false;  ///< the tower is finished and to outlast a shake
  /// Worlds in which the stack was judged without the trial, and whether it stood. Read and added to; null:
  /// judged anew.
  std::map<int, bool>* below_stands = nullptr;
};
/// Tries each in worlds 0 to `worlds` - 1 (those it was not tried in yet), all at once: placements displaced
/// by the placement uncertainty, centres of mass by theirs, the placed stone with a shape that it may have.
/// Every trial meets the same worlds.
/// @return the trials in the same order, with `predicted_success`; dropped if they stand too seldom.
[[nodiscard]] std::vector<Trial> predicted_trials(const SearchContext& context,
                                                  std::span<const Candidate> candidates, int worlds);

/// Chance that the finished tower stands, estimated at this step: success of this placement, reserve of
/// the whole stack, prospects of the next.
[[nodiscard]] double worth(const SearchContext& context, const Trial& trial);

}  // namespace stonestack::search
