#pragma once
#include <cstddef>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "stacking/execute.hpp"
#include "stonestack/search/find_next_pose.hpp"
#include "stonestack/stacking/action.hpp"
#include "stonestack/stacking/world_estimate.hpp"

namespace stonestack::stacking {

/// The higher the likelier (design choice: dry stone has more rather than less). Throws InvalidArgument for
/// an empty list.
[[nodiscard]] FrictionEstimate first_estimate(const std::vector<double>& frictions);
/// True if the lowest friction is the likeliest.
[[nodiscard]] bool min_is_likeliest(const FrictionEstimate& estimate);
/// Bayes' rule after a placement fell, of which `success[k]` (0 to 1) was to be expected at `frictions[k]`.
/// @throws InvalidArgument when the sizes differ.
[[nodiscard]] FrictionEstimate update_estimate(FrictionEstimate estimate, const std::vector<double>& success);

/// Bayes' rule after the friction of one pair was measured: those of other pairs scatter about it.
[[nodiscard]] FrictionEstimate update_by_measurement(FrictionEstimate estimate, double measured);

/// Mean offset of placed stones from their targets, level, m: hand-eye and arm calibration err the same each
/// time, and the camera measures by how much.
[[nodiscard]] Eigen::Vector3d placing_bias(const std::vector<PlacementRecord>& records);

/// The placement that was carried out last, with how the search meant to go on.
struct FollowedPlan {
  Placement placement;
  std::size_t stack_before = 0;    ///< stones
  std::size_t friction_level = 0;  ///< of the assumed frictions, which the search had
  Route route = Route::kDirect;    ///< that the search counted on
  /// Alternatives to `placement`, best first; to what follows it: `placement.then_compared`.
  std::vector<Alternative> compared = {};
};

/// The wall as it was planned last.
struct WallPlanned {
  Pose T_W_V = Pose::Identity();     ///< frame of the wall (`WallBegun`)
  std::map<StoneIndex, int> course;  ///< course of each stone that stands or was planned, from 0
};

/// Result of the search for one world, and how far the motions to it were refused.
struct SearchOutcome {
  SearchResult found;
  std::size_t friction_level = 0;
  Route route = Route::kDirect;
  std::optional<WallPlanned> wall;    ///< of the plan that was found; empty for a tower
  std::vector<StoneIndex> graspable;  ///< stones that the gripper could hold where they lay
  int refused = 0;       ///< stages (Place, Reorient; of the highest plans, then of the others) refused
  std::string refusals;  ///< in words
  std::optional<Stop> dead_end;  ///< why none of it can be done
  /// Stones expected to stand in the end when the top k + 1 are unstacked first; made when it is asked for.
  std::optional<std::vector<double>> expected_unstacked;
};

/// Stones that are being unstacked, one an action.
struct Unstacking {
  int remaining = 0;  ///< tries
  int tried = 0;
  std::size_t down_to = 0;           ///< stones of the stack that stay
  std::optional<PlacedStone> freed;  ///< the stone that leans on the stack, if it is done to free that one
};

/// An action that was carried out and is not judged yet.
struct Attempt {
  Action action;
  ExecutionResult done;
  Placement placement;  ///< where the stone was to go
  Pose T_O_T = Pose::Identity();
  Eigen::Vector3d p_W_aim = Eigen::Vector3d::Zero();
  std::vector<PlacedStone> below;                             ///< the stack before
  int course = 0;                                             ///< of a wall, from 1; 0: of none
  std::vector<StoneEstimate> expected_stack, expected_loose;  ///< if everything up to `done` succeeded
};

/// Why no other action follows.
struct Failure {
  RunEnd end = RunEnd::kPlacementFailed;
  std::string reason;
};

/// Memory of a run, beside the world.
struct RunMemory {
  FrictionEstimate friction;
  bool friction_measured = false;  ///< since the run began, by dragging a stone over the table
  std::vector<PlacementRecord> records;
  std::optional<FollowedPlan> plan;
  std::optional<WallPlanned> wall;  ///< as of the plan that was followed last; empty before the first
  int actions = 0;                  ///< carried out
  int failures = 0;                 ///< placements that did not hold
  int unstacked = 0, reoriented = 0, cleared = 0;
  int pushed = 0;  ///< since a stone was placed last
  std::optional<Failure> failure;
  std::map<StoneIndex, std::vector<Pose>> failed_grasps;       ///< T_O_T by stone
  std::map<StoneIndex, std::vector<Eigen::Vector3d>> toppled;  ///< ups, frame O, in which it did not stay
  std::vector<PlacedStone> given_up;                ///< tops of stacks on which nothing was found to fit
  std::map<StoneIndex, Eigen::Vector3d> last_seen;  ///< centre of mass, W, m
  std::set<StoneIndex> out_of_sight;                ///< looked for in vain
  /// In a run whose stones nobody scanned: those that lie in the cell, as far as nothing else was modelled in
  /// their place
  std::set<StoneIndex> awaited;
  std::set<StoneIndex> disproved;  ///< no stones: another model takes their place, or they are too light
  std::set<StoneIndex> too_light;  ///< a pick of these brought up less than a stone weighs
  int modelled_anew = 0;           ///< stones in whose place something else was modelled, or sought
  /// Middles of what is no stone, seen from above, when all awaited stones were seen [m]
  std::vector<Eigen::Vector2d> p_W_objects;
  std::optional<Unstacking> unstacking;
  std::optional<Attempt> attempt;

  // Of the world as it is now: forgotten with the next observation after an action.
  std::optional<SearchOutcome> search;
  std::map<StoneIndex, std::vector<Pose>> no_pick;  ///< T_O_T that do not lift the stone from where it lies
  std::vector<PlacedStone> refused;                 ///< poses to which no motion was found
  std::set<StoneIndex> sought_where_it_was;         ///< stones
  int sought_beside_site = 0;                       ///< places
  bool stray_stays = false;                         ///< no motion clears the base
  bool stack_stays = false;                         ///< no motion unstacks the top stone
  std::set<StoneIndex> not_pushed;                  ///< no motion pushes it
};

}  // namespace stonestack::stacking
