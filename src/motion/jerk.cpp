#include "stonestack/motion/jerk.hpp"

#include <algorithm>
#include <cmath>

#include "stonestack/core/error.hpp"

namespace stonestack {
namespace {

constexpr double kSpare = 1.02;         // of the window, for what cubic pieces lose against the exact average
constexpr double kShortestKnot = 1e-5;  // s: knots nearer than that are one

/// The motion before its start and after its end at rest, with its integral over time.
class Motion {
 public:
  explicit Motion(const JointTrajectory& trajectory) : trajectory_(trajectory) {
    area_.push_back(Joints::Zero());
    for (std::size_t i = 1; i < trajectory.time.size(); ++i)
      area_.push_back(area_.back() +
                      piece_area(i - 1, trajectory.time[i], trajectory.q[i], trajectory.qd[i]));
  }
  [[nodiscard]] Joints at(double t) const { return sample(trajectory_, t).q; }
  /// Integral of the joint angles, less those at the start, from 0 to `t`.
  [[nodiscard]] Joints area(double t) const {
    if (t <= 0.0) return Joints::Zero();
    const double end = trajectory_.duration();
    if (t >= end) return area_.back() + (t - end) * (trajectory_.q.back() - trajectory_.q.front());
    const auto after = std::upper_bound(trajectory_.time.begin(), trajectory_.time.end(), t);
    const auto i = static_cast<std::size_t>(after - trajectory_.time.begin()) - 1;
    const JointState state = sample(trajectory_, t);
    return area_[i] + piece_area(i, t, state.q, state.qd);
  }
  /// rad/s^2, of any joint at any time.
  [[nodiscard]] double largest_acceleration() const {
    double largest = 0.0;
    for (std::size_t i = 0; i + 1 < trajectory_.time.size(); ++i) {
      const double dt = trajectory_.time[i + 1] - trajectory_.time[i];
      if (dt <= kShortestKnot) continue;
      const Joints mean = (trajectory_.q[i + 1] - trajectory_.q[i]) / dt;
      const Joints &v0 = trajectory_.qd[i], &v1 = trajectory_.qd[i + 1];
      const Joints a0 = (6 * mean - 4 * v0 - 2 * v1) / dt, a1 = (-6 * mean + 2 * v0 + 4 * v1) / dt;
      largest = std::max({largest, a0.cwiseAbs().maxCoeff(), a1.cwiseAbs().maxCoeff()});
    }
    return largest;
  }

 private:
  /// From knot i to `t` on its piece; exact for a cubic.
  [[nodiscard]] Joints piece_area(std::size_t i, double t, const Joints& q, const Joints& qd) const {
    const double h = t - trajectory_.time[i];
    const Joints& q_start = trajectory_.q.front();
    return 0.5 * h * (trajectory_.q[i] + q - 2 * q_start) + h * h / 12.0 * (trajectory_.qd[i] - qd);
  }
  const JointTrajectory& trajectory_;
  std::vector<Joints> area_;  ///< at every knot
};

}  // namespace

JointTrajectory limit_jerk(const JointTrajectory& trajectory, double jerk) {
  require(std::isfinite(jerk) && jerk >= 0.0, "a jerk limit cannot be ", jerk, " rad/s^3");
  static_cast<void>(sample(trajectory, 0.0));  // throws for a trajectory that is none
  if (jerk == 0.0) return trajectory;
  const Motion motion(trajectory);
  const double window = kSpare * 2.0 * motion.largest_acceleration() / jerk;
  if (trajectory.time.size() < 2 || window <= kShortestKnot) return trajectory;
  // Where a piece begins or leaves the window the average changes its polynomial.
  std::vector<double> knots = trajectory.time;
  for (const double t : trajectory.time) knots.push_back(t + window);
  std::sort(knots.begin(), knots.end());
  JointTrajectory out{{0.0}, {trajectory.q.front()}, {Joints::Zero()}};
  const double end = trajectory.duration() + window;
  for (const double t : knots) {
    if (t - out.time.back() < kShortestKnot || end - t < kShortestKnot) continue;
    out.time.push_back(t);
    out.q.push_back(trajectory.q.front() + (motion.area(t) - motion.area(t - window)) / window);
    out.qd.push_back((motion.at(t) - motion.at(t - window)) / window);
  }
  out.time.push_back(end);
  out.q.push_back(trajectory.q.back());
  out.qd.push_back(Joints::Zero());
  return out;
}

}  // namespace stonestack
