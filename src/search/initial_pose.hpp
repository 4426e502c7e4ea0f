#pragma once
#include "search/search_context.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::search {

/// Target of a new stone: C_j and n_j of the last placed stone's support polygon (paper §3.1), and its
/// centre of mass P_j. On the empty table: the site and the vertical.
struct Target {
  Eigen::Vector3d p_W_centroid = Eigen::Vector3d::Zero();
  Eigen::Vector3d n_W = Eigen::Vector3d::UnitZ();
  Eigen::Vector3d p_W_previous_com = Eigen::Vector3d::Zero();
};
[[nodiscard]] Target target_of(const SearchContext& context);

/// Initial pose (paper §3.1): the detected orientation turned about a random axis by a random angle in
/// [-theta_init, theta_init].
[[nodiscard]] Eigen::Matrix3d initial_orientation(const Eigen::Matrix3d& R_W_O_detected, double theta_init,
                                                  Random& random);
/// Moves a stone along n_j, its centre of mass on the line through C_j shifted by `aside` (W), until a
/// plane across n_j just separates it from the stack.
[[nodiscard]] Pose placed_along_normal(const SearchContext& context, const Target& target, StoneIndex stone,
                                       const Eigen::Matrix3d& R_W_O, const Eigen::Vector3d& aside);

}  // namespace stonestack::search
