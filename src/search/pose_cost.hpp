#pragma once
#include "stonestack/search/find_next_pose.hpp"

namespace stonestack::search {

/// Terms of eq. (2) of the paper.
struct ContactPose {
  SupportPolygon support;                                      ///< S_i
  double kinetic_energy = 0.0;                                 ///< E_kin [J]
  Eigen::Vector3d p_W_com = Eigen::Vector3d::Zero();           ///< P_i
  Eigen::Vector3d p_W_previous_com = Eigen::Vector3d::Zero();  ///< P_j; on the table: the site
  Eigen::Vector3d v_W = -Eigen::Vector3d::UnitZ();             ///< thrust line direction v_i, unit
};

/// Eq. (2) and its weighted terms `area`, `kinetic_energy`, `distance`, `normal`.
struct PoseCost {
  double total = 0.0;
  std::map<std::string, double> terms;
};
/// w1 / A + w2 E_kin + w3 |r_PjPi| + w4 (1 - |n.v|), each term over its reference. The paper prints |n.v|,
/// which is largest when normal and thrust line agree, while its text minimises their deviation; the literal
/// form, in SI and with that sign, is `si_cost`.
[[nodiscard]] PoseCost pose_cost(const ContactPose& pose, const SearchOptions& options);

}  // namespace stonestack::search
