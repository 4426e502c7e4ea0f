#include "motion/path/min_time.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace stonestack::motion {

double min_time(const JointPath& path, const TimingLimits& limits) {
  constexpr double kStep = 0.0005;  // rad
  const JointPath p = rounded(path, limits, kStep);
  const std::size_t n = p.size();
  std::vector<double> ds(n, 0.0);
  std::vector<Joints> tangent(n, Joints::Zero()), curvature(n, Joints::Zero());
  for (std::size_t i = 0; i + 1 < n; ++i) ds[i] = (p[i + 1] - p[i]).norm();
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const Joints before = (p[i] - p[i - 1]) / ds[i - 1], after = (p[i + 1] - p[i]) / ds[i];
    tangent[i] = 0.5 * (before + after);
    curvature[i] = (after - before) / (0.5 * (ds[i - 1] + ds[i]));
  }
  tangent.front() = (p[1] - p[0]) / ds[0];
  tangent[n - 1] = (p[n - 1] - p[n - 2]) / ds[n - 2];
  // Range of d2s/dt2 at (ds/dt)^2 = x.
  const auto range = [&](std::size_t i, double x) {
    std::pair<double, double> u{-1e9, 1e9};
    for (int j = 0; j < 6; ++j) {
      const double t = tangent[i][j], c = curvature[i][j] * x, a = limits.acceleration[j];
      if (std::abs(t) < 1e-9) {
        if (std::abs(c) > a) return std::pair{1.0, -1.0};
        continue;
      }
      u.first = std::max(u.first, std::min((-a - c) / t, (a - c) / t));
      u.second = std::min(u.second, std::max((-a - c) / t, (a - c) / t));
    }
    return u;
  };
  const auto fastest = [&](std::size_t i) {
    double x = 1e6;
    for (int j = 0; j < 6; ++j)
      x = std::min(x, std::pow(limits.velocity[j] / std::max(1e-9, std::abs(tangent[i][j])), 2));
    return x;
  };
  std::vector<double> x(n, 0.0);
  for (std::size_t i = n - 1; i-- > 0;) {  // the largest from which the next set can be reached
    double low = 0.0, high = fastest(i);
    for (int k = 0; k < 50; ++k) {
      const double middle = 0.5 * (low + high);
      const auto [u0, u1] = range(i, middle);
      const bool can =
          u0 <= u1 && std::max(u0, -middle / (2 * ds[i])) <= std::min(u1, (x[i + 1] - middle) / (2 * ds[i]));
      (can ? low : high) = middle;
    }
    x[i] = low;
  }
  double time = 0.0;
  x[0] = 0.0;
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const double u = std::min(range(i, x[i]).second, (x[i + 1] - x[i]) / (2 * ds[i]));
    x[i + 1] = std::max(0.0, std::min(x[i + 1], x[i] + 2 * ds[i] * u));
    time += 2 * ds[i] / std::max(1e-9, std::sqrt(x[i]) + std::sqrt(x[i + 1]));
  }
  return time;
}

}  // namespace stonestack::motion
