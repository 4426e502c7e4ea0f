#include "motion/path/smooth_path.hpp"

#include <algorithm>
#include <cmath>

namespace stonestack::motion {
namespace {

constexpr double kShortest = 1e-6;  ///< a micrometre at the tool [rad]; below it two waypoints are one

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
    pieces.push_back({from + tangent * (length * i / parts), tangent, Joints::Zero(), length / parts, false,
                      Joints::Zero()});
}

/// From `leave` around the corner, `turn` from one unit tangent to the other, `h` before and after it.
void add_bend(std::vector<PathPiece>& pieces, const Joints& leave, const Joints& tangent, const Joints& turn,
              double h, Corner corner) {
  const Joints zero = Joints::Zero();
  if (corner == Corner::kParabola) {
    pieces.push_back({leave, tangent, turn / (2 * h), 2 * h, false, zero});
    return;
  }
  pieces.push_back({leave, tangent, zero, h, false, turn / (h * h)});
  const PathPiece& first = pieces.back();
  pieces.push_back({first.at(h), first.tangent_at(h), turn / h, h, false, -turn / (h * h)});
}

/// How far from the corner a curve may leave its lines.
double reach(double turn, double before, double after, double blend, Corner corner) {
  // A parabola passes the corner at reach * turn / 4. Even curvature passes it nearer, and leaves a part of
  // every line for the speed to change on.
  const double passes = corner == Corner::kParabola ? 4.0 : 6.0;
  const double share = corner == Corner::kParabola ? 2.0 : 3.0;
  return std::min({passes * blend / std::max(turn, 1e-12), before / share, after / share});
}

}  // namespace

std::vector<PathPiece> smooth_pieces(const JointPath& path, double blend, double longest_line,
                                     Corner corner) {
  const JointPath points = without_repeats(path);
  std::vector<PathPiece> pieces;
  if (points.size() < 2) return pieces;
  Joints from = points.front();
  for (std::size_t i = 1; i + 1 < points.size(); ++i) {
    const Joints before = points[i] - points[i - 1], after = points[i + 1] - points[i];
    const Joints turn = after.normalized() - before.normalized();
    const double h = reach(turn.norm(), before.norm(), after.norm(), blend, corner);
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
      add_bend(pieces, leave, before.normalized(), turn, h, corner);
      from = points[i] + h * after.normalized();
    }
  }
  add_line(pieces, from, points.back(), longest_line);
  return pieces;
}

}  // namespace stonestack::motion
