#include "search/pose_cost.hpp"

#include <algorithm>
#include <cmath>

#include "search/constants.hpp"

namespace stonestack::search {

PoseCost pose_cost(const ContactPose& pose, const SearchOptions& o) {
  constexpr double kMinArea = 1e-8;  // m^2: a line of contacts costs much, not infinitely
  const double area = std::max(pose.support.area, kMinArea);
  const double distance = (pose.p_W_com - pose.p_W_previous_com).norm();
  const double aligned = std::min(1.0, std::abs(pose.support.n_W.dot(pose.v_W)));
  PoseCost cost;
  if (o.si_cost) {
    cost.terms = {{"area", o.w1 / area},
                  {"kinetic_energy", o.w2 * pose.kinetic_energy},
                  {"distance", o.w3 * distance},
                  {"normal", o.w4 * aligned}};
  } else {
    cost.terms = {{"area", o.w1 * kAreaReference / area},
                  {"kinetic_energy", o.w2 * pose.kinetic_energy / kEnergyReference},
                  {"distance", o.w3 * distance / kDistanceReference},
                  {"normal", o.w4 * (1.0 - aligned)}};
  }
  for (const auto& [name, value] : cost.terms) cost.total += value;
  return cost;
}

}  // namespace stonestack::search
