#pragma once
#include "search/landing.hpp"
#include "stonestack/search/find_next_pose.hpp"

namespace stonestack::search {

/// A pose that the gap field holds for good, before any simulation.
struct Proposal {
  StoneIndex stone = kNoStone;  ///< index into SearchProblem::shapes
  BodyPose body;
  Landing landing;
  double robust = 0.0;      ///< mean estimate over the placement uncertainty [g]
  double look_ahead = 0.0;  ///< what the stones that are left could bear on top of it [g]
  double score = 0.0;
};

/// Undersides of a stone in each of its orientations and a few turns: what every survey of a top begins with.
struct SurveySides {
  int yaws = 0;
  UndersideOptions options;
  std::vector<Underside> sides;  ///< orientation by orientation
};

/// A loose stone and the orientations that it may take.
struct LooseStone {
  StoneIndex stone = kNoStone;
  const StoneGeometry* geometry = nullptr;
  std::vector<Eigen::Matrix3d> orientations;  ///< R_W_O, each stands for all yaws
  double raster_radius = 0.0;  ///< at least the stone's own [m]: how wide the rasters of tops are
  std::shared_ptr<const SurveySides> surveyed;  ///< may be empty
};
/// The stones with their survey sides, so that a search over many tops makes them once (some 5 kB a side).
[[nodiscard]] std::vector<LooseStone> with_survey(std::vector<LooseStone> stones,
                                                  const SearchOptions& options);

inline constexpr double kOffsetReach = 0.04;  ///< offsets from the middle of the top that are tried [m]

/// The gap field of a stack for any of the stones: raster as wide as the largest.
[[nodiscard]] StackField stack_field(const StackBodies& stack, std::span<const LooseStone> stones,
                                     const Eigen::Vector2d& site, double cell, const SearchOptions& options);
[[nodiscard]] UndersideOptions underside_options(const StackField& stack);

/// The stones with those of their orientations alone in which they would come to lie on a table by a tilt of
/// at most `max_slope` (rise over run): most of what fits a top is among them.
[[nodiscard]] std::vector<LooseStone> on_resting_sides(std::span<const LooseStone> stones, double max_slope,
                                                       const SearchOptions& options);

/// Turns a body by the tilt that its landing still asks for.
[[nodiscard]] Eigen::Matrix3d levelled(const Eigen::Matrix3d& R_W_O, const Landing& landing);

/// True if the two differ by more than 8 deg or 10 mm sideways.
[[nodiscard]] bool distinct(const BodyPose& p, const BodyPose& q);
/// Best first by `value`, at most `keep`, distinct.
[[nodiscard]] std::vector<Proposal> best_distinct(std::vector<Proposal> list, std::size_t keep,
                                                  const std::function<double(const Proposal&)>& value);

/// Proposals and their cost.
struct Proposals {
  std::vector<Proposal> list;
  long evaluated = 0;  ///< landings that were tried for them
};

/// The best offset for every yaw of the orientations that promise most (few yaws and wide offsets first),
/// at most `keep` a stone.
[[nodiscard]] Proposals coarse_proposals(const StackField& stack, bool on_table,
                                         std::span<const LooseStone> stones, std::size_t keep,
                                         const SearchOptions& options);

/// A refined proposal and its cost.
struct Refined {
  Proposal proposal;
  long evaluated = 0;  ///< landings that were tried for it
};
/// Levels a proposal and walks to the best offset nearby on a finer raster, until both are at rest.
[[nodiscard]] Refined refined(const Proposal& start, const StackField& fine, bool on_table,
                              const SearchOptions& options);

/// Proposals between the top of `stack` and the undersides of the stones: coarse, refined, at most `keep`
/// a stone and distinct. Sorted by stone, best first.
[[nodiscard]] Proposals propose(const StackBodies& stack, std::span<const LooseStone> stones,
                                const Eigen::Vector2d& site, int keep, const SearchOptions& options);

}  // namespace stonestack::search
