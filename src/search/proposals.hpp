#pragma once
#include "search/landing.hpp"
#include "stonestack/search/find_next_pose.hpp"

namespace stonestack {

/// A pose that the gap field holds for good, before any simulation.
struct Proposal {
  int stone = -1;  ///< index into SearchProblem::shapes
  BodyPose body;
  Landing landing;
  double robust = 0.0;      ///< g: mean estimate over the placement uncertainty
  double look_ahead = 0.0;  ///< g: what the stones that are left could bear on top of it
  double score = 0.0;
};

/// A loose stone and the orientations that it may take.
struct LooseStone {
  int stone = -1;
  const StoneGeometry* geometry = nullptr;
  std::vector<Eigen::Matrix3d> orientations;  ///< R_W_O, each stands for all yaws
};

/// Cells from the middle to the rim of a raster that any of the stones fits over, wherever its centre of mass
/// is set down.
[[nodiscard]] int half_width(std::span<const StoneGeometry> stones, double cell);
[[nodiscard]] StackField stack_field(std::span<const BodyPose> stack, const SurfaceGrid& grid,
                                     const SearchOptions& options);

/// What the top of `stack` and the undersides of the stones offer each other: every orientation and yaw over
/// a grid of offsets, then the best refined on a finer raster. Sorted by stone, best first, at most `keep` a
/// stone and distinct (8 deg or 10 mm). `evaluated` counts landings.
[[nodiscard]] std::vector<Proposal> propose(std::span<const BodyPose> stack,
                                            std::span<const LooseStone> stones, const Eigen::Vector2d& site,
                                            int keep, const SearchOptions& options, long* evaluated);

}  // namespace stonestack
