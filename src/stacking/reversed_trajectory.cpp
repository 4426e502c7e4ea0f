#include "stacking/reversed_trajectory.hpp"

#include <algorithm>

namespace stonestack::stacking {

JointTrajectory reversed(const JointTrajectory& trajectory) {
  JointTrajectory back = trajectory;
  std::reverse(back.q.begin(), back.q.end());
  std::reverse(back.qd.begin(), back.qd.end());
  for (std::size_t k = 0; k < trajectory.time.size(); ++k) {
    back.time[k] = trajectory.duration() - trajectory.time[trajectory.time.size() - 1 - k];
    back.qd[k] = -back.qd[k];
  }
  return back;
}

}  // namespace stonestack::stacking
