#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "search/wall/wall_state.hpp"

namespace stonestack::search {

/// A stone that came to rest in a structure.
struct Settled {
  Trial trial;
  WallStonePlaced placed;
  double worth = 0.0;
};

/// Puts stones into a structure, as far as arm, balance and simulation allow, and counts what it refused.
/// Poses are in the structure's frame V unless stated.
class Placing {
 public:
  /// @param context must outlive it
  /// @param T_W_V required where the problem asks the arm, or where stones stand
  Placing(const SearchContext& context, const std::optional<Pose>& T_W_V)
      : context_(context), T_W_V_(T_W_V) {}

  /// The first proposals that the arm can carry out, at most `keep`.
  [[nodiscard]] std::vector<WallProposal> reachable(std::vector<WallProposal> list, const Stack& below,
                                                    std::size_t keep);
  /// The stones let down on `below`, all at once; those that come to rest in balance, in the same order.
  [[nodiscard]] std::vector<Settled> settled(const Stack& below, const std::vector<WallProposal>& list,
                                             int course);
  /// Judges a stone in place, with all that stands, and predicts it; false if it does not hold.
  [[nodiscard]] bool holds(const WallState& state, Settled& next);
  /// The state with one more stone, where the stones have rocked, and what was compared with it.
  [[nodiscard]] WallState loaded(const WallState& state, const Settled& next,
                                 std::vector<Alternative> compared = {}) const;
  /// The next stone of an earlier plan where it was meant to go; empty if it does not hold there.
  /// @param ask whether the arm is asked
  [[nodiscard]] std::optional<Settled> as_planned(const WallState& state, const WallPlacement& planned,
                                                  bool ask);
  /// Alternatives to a stone of an earlier plan, in the structure's frame.
  [[nodiscard]] std::vector<Alternative> compared_with(const WallPlacement& planned) const;

  /// Of the last proposals, those that the arm does not bring about, then those that did not come to rest in
  /// balance; at most five.
  std::vector<Alternative> refused;
  bool may_rock = false;  ///< stones, where a place does not hold without
  int judged = 0;         ///< stones
  int unreachable = 0;    ///< proposals that the arm could not bring about
  std::string reason;     ///< why the last stone was refused

 private:
  bool judge(const Stack& below, Settled& next);
  void refuse(Alternative other);
  /// Can the arm bring the stone to that pose, in W, among those stones?
  [[nodiscard]] bool is_reachable(const Placement& placement, const Stack& below) const;

  const SearchContext& context_;
  const std::optional<Pose>& T_W_V_;
};

/// A stone that stands, in the structure's frame.
[[nodiscard]] WallStonePlaced standing(const SearchContext& context, const PlacedStone& stone, int course);
/// The stack of the problem, in the frame of the structure.
[[nodiscard]] WallState standing_state(const SearchContext& context, const WallBegun& begun);
/// Stones of the state that each stone rests on.
[[nodiscard]] std::vector<std::vector<int>> rests_upon(const SearchContext& context, const WallState& state);
/// A context for stones that may touch any others.
[[nodiscard]] SearchContext wall_context(const SearchProblem& problem, const SearchOptions& options,
                                         const std::function<void(const std::string&)>& report);
/// The frame of a structure in W, where its middle is `middle` along x from the origin of the frame [m].
[[nodiscard]] Pose frame_of(const WallTarget& target, const Eigen::Vector2d& site, double middle);
/// The best of `list` but the one at `chosen`, then what was `refused`: what was compared with that one.
[[nodiscard]] std::vector<Alternative> compared_in(const std::vector<Settled>& list, std::size_t chosen,
                                                   const std::vector<Alternative>& refused);
/// A placement in the structure's frame, and what was compared with it, in W.
[[nodiscard]] WallPlacement in_world(const Pose& T_W_V, WallPlacement placement,
                                     const std::shared_ptr<const std::vector<Alternative>>& compared);
/// The state with one more stone, and what was compared with it.
[[nodiscard]] WallState with(const WallState& state, const Settled& next,
                             std::vector<Alternative> compared = {});

}  // namespace stonestack::search
