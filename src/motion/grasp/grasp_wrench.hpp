#pragma once
#include <array>
#include <optional>

#include "motion/grasp.hpp"

namespace stonestack::motion {

/// Contacts in frame T, torques about the stone's centre of mass.
struct GraspContacts {
  std::array<Eigen::Vector3d, 4> p_T;  ///< finger A's first, as in Grasp
  std::array<Eigen::Vector3d, 4> n_T;  ///< outward from the stone
  int count = 3;                       ///< of these four
  int on_a = 1;                        ///< of these, on finger A
  Eigen::Vector3d p_T_M = Eigen::Vector3d::Zero();
};

/// True if the fingers can squeeze along x with all forces inside cones of `friction` and nothing moves.
[[nodiscard]] bool squeeze_holds(const GraspContacts& contacts, double friction);

/// Force at finger A per N of weight along +x, -x, +y, -y, +z, -z of T; empty if some direction cannot be
/// held.
[[nodiscard]] std::optional<std::array<double, 6>> force_per_weight(const GraspContacts& contacts,
                                                                    double friction);

/// Contacts of a grasp, with the stone's centre of mass.
[[nodiscard]] GraspContacts contacts_in_T(const Grasp& grasp, const Eigen::Vector3d& p_O_M);

/// Like `holding_force`, but for this direction instead of a bound from the axes. Infinite if it slips.
[[nodiscard]] double exact_holding_force(const Grasp& grasp, const Eigen::Vector3d& p_O_M, double friction,
                                         double weight, const Eigen::Vector3d& n_T_down);

}  // namespace stonestack::motion
