#pragma once
#include <memory>
#include <optional>

#include "stacking/arrangement.hpp"
#include "stacking/choose_action.hpp"
#include "stacking/reach.hpp"

/// Private to stacking/: the search for the next placement, at one assumed friction after the other.
namespace stonestack::stacking {

/// Everything that a decision is made from.
struct Situation {
  const WorldEstimate& world;
  const Models& models;
  const BuildOptions& options;
  const Listener& listener;
  Arrangement arrangement;       ///< `at_rest(world)`
  std::shared_ptr<Reach> reach;  ///< of `arrangement`
  Basis basis = Basis::kObserved;

  void emit(const Event& event) const {
    if (listener) listener(event);
  }
};
[[nodiscard]] Situation make_situation(const WorldEstimate& world, const Models& models,
                                       const BuildOptions& options, const Listener& listener,
                                       Basis basis = Basis::kObserved);

/// The stack, the stones that the gripper can hold, and as out of reach what the arm does not reach and what
/// was given up. `memory` must outlive it.
[[nodiscard]] SearchProblem make_problem(const Situation& situation, const RunMemory& memory,
                                         const Arrangement& arrangement, const std::shared_ptr<Reach>& reach,
                                         Route route);
/// The problem with its stack as it rests at that friction, or as it is held; nothing if it does not stand
/// there.
[[nodiscard]] std::optional<SearchProblem> at_friction(const SearchProblem& problem,
                                                       const RestingStack& resting);
/// Frictions at which the stack can stand; all, if there is none.
[[nodiscard]] std::vector<bool> possible_frictions(const WorldEstimate& world);
/// Options of a search at the `level`-th of the assumed frictions.
[[nodiscard]] SearchOptions options_at(const BuildOptions& options, const FrictionEstimate& friction,
                                       std::size_t level, Route route);
/// How the structure was meant to go on, for a tower moved with where its top really came to lie; the same as
/// before if the stone was not picked; empty if something else happened.
[[nodiscard]] std::vector<PlacedStone> rest_of_plan(const Situation& situation,
                                                    const std::optional<FollowedPlan>& plan);

/// Alternatives to each stone of `rest_of_plan`, from the search that made the plan, moved as the stones.
[[nodiscard]] std::vector<std::vector<Alternative>> compared_with_rest(const Situation& situation,
                                                                       const FollowedPlan& plan);

/// Place or Reorient: what `memory.search` found, or a search now, by stages: the placements whose plans
/// reach highest in one go, then with a stone set down on the route, then the others likewise. Nothing if no
/// pose is left; `memory.search->dead_end` then gives the reason, or there is no `memory.search` where the
/// search was not finished because the world is a prediction.
[[nodiscard]] std::optional<Action> choose_placement(const Situation& situation, RunMemory& memory);

/// Stones expected to stand in the end when the top k + 1 of the stack are unstacked first, for each k that
/// may pay; 0 where no higher tower is found.
[[nodiscard]] std::vector<double> expected_unstacked(const Situation& situation, const RunMemory& memory);

/// One set-down at a time: after each the stones are observed, and what lies otherwise than meant is planned
/// anew.
[[nodiscard]] RegraspOptions regrasp_options(const RunMemory& memory, StoneIndex stone);
/// May another stone be reoriented?
[[nodiscard]] bool may_reorient(const RunMemory& memory, const BuildOptions& options);
[[nodiscard]] bool height_is_reached(const Arrangement& arrangement, const BuildOptions& options);
/// Grasps T_O_T of the stone near which two failed. Near one that failed alone another view may help.
[[nodiscard]] std::vector<Pose> failed_twice(const RunMemory& memory, StoneIndex stone);
/// Stones (loose, by index) that the gripper can hold where they lie.
[[nodiscard]] std::vector<StoneIndex> graspable_stones(const Situation& situation);

/// Stones of a plan that are expected to stand, at each friction that is `asked` about; 0 for the others.
/// `resting`: the problem's stack at these frictions, or null to let it come to rest here.
[[nodiscard]] std::vector<double> expected_by_friction(
    const SearchProblem& problem, const std::vector<PlacedStone>& plan, const std::vector<double>& frictions,
    const std::vector<bool>& asked, const std::vector<RestingStack>* resting, const SearchOptions& options);

}  // namespace stonestack::stacking
