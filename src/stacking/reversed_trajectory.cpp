#include "stacking/reversed_trajectory.hpp"

#include <algorithm>
#include <cmath>

namespace stonestack::stacking {
namespace {

constexpr double kWayStep = 0.02;  // s: at 1 rad/s a joint turns by 0.02 rad

}  // namespace

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

JointPath way_back(const JointTrajectory& trajectory, const Joints& q) {
  JointPath way;
  double nearest = 0.0;
  for (double t = 0.0; t <= trajectory.duration(); t += kWayStep) {
    way.push_back(sample(trajectory, t).q);
    if ((way.back() - q).norm() < (sample(trajectory, nearest).q - q).norm()) nearest = t;
  }
  way.resize(static_cast<std::size_t>(std::lround(nearest / kWayStep)) + 1);
  way.push_back(q);
  std::reverse(way.begin(), way.end());
  return way;
}

}  // namespace stonestack::stacking
