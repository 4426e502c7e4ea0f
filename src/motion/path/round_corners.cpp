#include "motion/path/round_corners.hpp"

#include <array>

namespace stonestack::motion {
namespace {

constexpr std::array kBlends{0.2, 0.08, 0.03, 0.01, 0.005, 0.002, 0.0005};  ///< widest first [rad]
constexpr double kCornerStep =
    0.1;  ///< of points on lines [rad]; on curves they are as near as the curve asks

}  // namespace

double free_blend(const CollisionChecker& checker, const JointPath& path, const TimingLimits& limits) {
  if (path.size() < 3) return limits.blend;
  TimingLimits cut = limits;
  for (const double blend : kBlends) {
    if (blend > limits.blend) continue;
    cut.blend = blend;
    const JointPath points = rounded(path, cut, kCornerStep);
    bool free = true;
    for (std::size_t i = 1; free && i < points.size(); ++i)
      free = checker.motion_is_free(points[i - 1], points[i]);
    if (free) return blend;
  }
  return 0.0;
}

}  // namespace stonestack::motion
