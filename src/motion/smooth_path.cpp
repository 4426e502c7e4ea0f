#include "motion/smooth_path.hpp"

#include <algorithm>
#include <cmath>

namespace stonestack {
namespace {

constexpr double kShortest = 1e-6;  ///< rad, a micrometre at the tool; below it two way points are one

JointPath without_repeats(const JointPath& path) {
  JointPath kept;
  for (const Joints& q : path)
    if (kept.empty() || (q - kept.back()).norm() > kShortest) kept.push_back(q);
  if (kept.size() > 1) kept.back() = path.back();  // the end is exact; what was merged lies before it
  return kept;
}

void add_line(std::vector<PathPiece>& pieces, const Joints& from, const Joints& to, double longest_line) {
  const double length = (to - from).norm();
  if (length <= kShortest) return;
  const int parts = std::max(1, static_cast<int>(std::ceil(length / longest_line)));
  const Joints tangent = (to - from) / length;
  for (int i = 0; i < parts; ++i)
    pieces.push_back({from + tangent * (length * i / parts), tangent, Joints::Zero(), length / parts, false});
}

}  // namespace

std::vector<PathPiece> smooth_pieces(const JointPath& path, double blend, double longest_line) {
  const JointPath points = without_repeats(path);
  std::vector<PathPiece> pieces;
  if (points.size() < 2) return pieces;
  Joints from = points.front();
  for (std::size_t i = 1; i + 1 < points.size(); ++i) {
    const Joints before = points[i] - points[i - 1], after = points[i + 1] - points[i];
    const Joints turn = after.normalized() - before.normalized();
    // A parabola that leaves and meets the lines at distance h from the corner passes it at h |turn| / 4.
    const double h =
        std::min({4.0 * blend / std::max(turn.norm(), 1e-12), before.norm() / 2, after.norm() / 2});
    if (turn.norm() < 1e-9) {
      add_line(pieces, from, points[i], longest_line);
      from = points[i];
    } else if (h <= kShortest) {
      add_line(pieces, from, points[i], longest_line);
      if (!pieces.empty()) pieces.back().stop_after = true;
      from = points[i];
    } else {
      const Joints leave = points[i] - h * before.normalized();
      add_line(pieces, from, leave, longest_line);
      pieces.push_back({leave, before.normalized(), turn / (2 * h), 2 * h, false});
      from = points[i] + h * after.normalized();
    }
  }
  add_line(pieces, from, points.back(), longest_line);
  return pieces;
}

}  // namespace stonestack
