#pragma once
#include <functional>
#include <limits>
#include <map>
#include <memory>

#include "search/trial.hpp"
#include "search/wall/wall_sides.hpp"
#include "stonestack/search/plan_wall.hpp"

namespace stonestack::search {

/// A stone that stands in a wall, in the wall's frame: x along it, y across, z = 0 the table.
struct WallStonePlaced {
  StoneIndex stone = kNoStone;
  Pose T_W_O = Pose::Identity();
  int course = 0;
  Extents reach;         ///< from where to where it goes along and across the wall [m]
  double top = 0.0;      ///< height of a plate on top [m]
  double level = 1.0;    ///< cosine of the plate's tilt
  double breadth = 0.0;  ///< centre of mass to the rim of what carries the plate [m]
  double square = 0.0;   ///< share of the rectangle along and across the wall that its outline covers
};

/// A wall that is partly built.
struct WallState {
  std::vector<WallStonePlaced> stones;  ///< in the order in which they were placed
  std::vector<Trial> trials;            ///< of each
  /// Alternatives to each, in the wall's frame; null where there were none.
  std::vector<std::shared_ptr<const std::vector<Alternative>>> compared;
  int closed = 0;  ///< courses from the bottom in which no more stone fits
  [[nodiscard]] Stack stack() const;
  [[nodiscard]] bool holds(StoneIndex stone) const;
  /// Indices of a course's stones, from the left.
  [[nodiscard]] std::vector<int> course(int k) const;
};

/// The place of the next stone.
struct WallSlot {
  int course = 0;
  double from = -std::numeric_limits<double>::infinity();  ///< x where the last stone of the course ends [m]
  std::optional<double>
      centre;                ///< x that the stone's middle is wanted at; empty: as near to `from` as it goes
  double top = 0.0;          ///< height at which its top is wanted [m]
  bool carries = true;       ///< another course comes on top
  double joint_gap = 0.004;  ///< [m] to neighbours of the course, at least
  std::vector<double> joints;  ///< x of the joints of the course below [m]
};

/// The worth of a stone in a slot: how firmly it lies, what its top offers, how well it fits. Larger is
/// better.
/// @param firmness horizontal acceleration that it bears [g]
[[nodiscard]] double worth_in_slot(const WallSlot& slot, const WallStonePlaced& placed, double firmness,
                                   double friction);
/// Figures of a stone in a slot, for reports: `course` (from 1), `joint_cover` [m] from its ends to the
/// nearest joint below, at most 30 mm, `fill` (share of the rectangle along and across the wall that it
/// covers), `off_height` [m] of its top where a course comes on top, `off_axis` [m], `worth`.
[[nodiscard]] std::map<std::string, double> terms_in_slot(const WallSlot& slot, const WallStonePlaced& placed,
                                                          double worth);
/// A stone in the wall's frame.
[[nodiscard]] WallStonePlaced placed_in_wall(const WallStone& stone, const WallSide& side,
                                             const Eigen::Matrix3d& R_W_O, const Eigen::Vector3d& p_W_com,
                                             int course);

/// Number of stones that a target asks for; 0: as many as its length takes.
[[nodiscard]] int stones_asked(const WallTarget& target);
/// The slot after the stones of a state; empty where the wall is finished.
/// @param thickness of a course of which no stone stands yet [m]; asked only then
[[nodiscard]] std::optional<WallSlot> next_slot(const WallTarget& target, const WallState& state,
                                                const std::function<double()>& thickness);
/// Height [m] over the course below in which most stones of `stones` have a level side.
[[nodiscard]] double common_thickness(const std::vector<WallStone>& stones, const WallState& state);

/// Proposals for a slot, best first: stones on the table side by side, or on what stands.
struct WallProposal {
  const WallStone* stone = nullptr;
  const WallSide* side = nullptr;
  Proposal proposal;
  double worth = 0.0;
};
struct WallProposals {
  std::vector<WallProposal> list;
  long evaluated = 0;
};
/// Where a stone may go, and what it is worth there.
struct WallPlace {
  int course = 0;
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();     ///< of what `field` covers [m]
  std::function<StackField(const SurfaceGrid&)> field;  ///< the surface that a stone is laid over
  /// Where the centre of mass of a side goes before it is moved about [m].
  std::function<Eigen::Vector2d(const WallStone&, const WallSide&)> wanted;
  /// Larger is better; the second argument is the horizontal acceleration that the stone bears [g].
  std::function<double(const WallStonePlaced&, double)> worth;
};
/// Stones on what stands, best first, coarse and then refined.
[[nodiscard]] WallProposals proposals_at(const SearchContext& context, const WallPlace& place,
                                         const std::vector<const WallStone*>& stones);
/// Stones on the free table, where they are wanted, best first. `field` is not used.
[[nodiscard]] WallProposals table_proposals(const SearchContext& context, const WallPlace& place,
                                            const std::vector<const WallStone*>& stones);
/// The stones that a state does not hold.
[[nodiscard]] std::vector<const WallStone*> stones_left(const std::vector<WallStone>& stones,
                                                        const WallState& state);
[[nodiscard]] WallProposals wall_proposals(const SearchContext& context, const WallState& state,
                                           const WallSlot& slot, const std::vector<WallStone>& stones);

/// Horizontal acceleration that all stones together bear in the weakest of 16 directions [g].
[[nodiscard]] double margin_of_all(const SearchContext& context, const WallState& state);
/// Figures of what stands.
[[nodiscard]] WallMetrics wall_metrics(const SearchContext& context, const WallState& state);

}  // namespace stonestack::search
