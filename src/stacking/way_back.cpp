#include "stacking/way_back.hpp"

#include <algorithm>

namespace stonestack::stacking {

JointTrajectory reversed(const JointTrajectory& way) {
  JointTrajectory back = way;
  std::reverse(back.q.begin(), back.q.end());
  std::reverse(back.qd.begin(), back.qd.end());
  for (std::size_t k = 0; k < way.time.size(); ++k) {
    back.time[k] = way.duration() - way.time[way.time.size() - 1 - k];
    back.qd[k] = -back.qd[k];
  }
  return back;
}

}  // namespace stonestack::stacking
