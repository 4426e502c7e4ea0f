#include "motion/path/shorten_path.hpp"

#include <algorithm>

#include "motion/transit.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::motion {
namespace {

constexpr double kRepeat = 1e-9;       // rad: waypoints nearer than that are one
constexpr double kMinGain = 1e-6;      // rad
constexpr double kPartialGain = 0.01;  // rad: a partial shortcut adds waypoints, so it has to be worth it
constexpr double kMinPull = 0.2;       // of the distance to the line
constexpr double kPullNoise = 0.3;     // of that distance, one sigma a joint
constexpr int kMendTries = 12;
constexpr int kRepairDepth = 2;  // a piece is halved so often
constexpr double kRepairShare =
    0.15;  // of the piece's length, by which its middle is moved (one sigma, a joint)
constexpr double kMaxRepair = 0.3;  // rad

/// Path length at every waypoint.
std::vector<double> lengths(const JointPath& path) {
  std::vector<double> at(path.size(), 0.0);
  for (std::size_t i = 1; i < path.size(); ++i) at[i] = at[i - 1] + (path[i] - path[i - 1]).norm();
  return at;
}

/// A point on a path.
struct Place {
  std::size_t piece = 0;  ///< it lies between waypoints `piece` and `piece` + 1
  Joints q;
};

Place place_at(const JointPath& path, const std::vector<double>& at, double s) {
  const auto after = std::upper_bound(at.begin() + 1, at.end() - 1, s);
  const auto piece = static_cast<std::size_t>(after - at.begin()) - 1;
  const double span = at[piece + 1] - at[piece];
  if (span <= 0.0) return {piece, path[piece]};
  return {piece, path[piece] + (path[piece + 1] - path[piece]) * ((s - at[piece]) / span)};
}

bool all_free(const JointPath& path, const MotionTest& is_free) {
  for (std::size_t i = 1; i < path.size(); ++i)
    if (!is_free(path[i - 1], path[i])) return false;
  return true;
}

/// `path` with what lies between the two places replaced by `stretch`, which begins and ends there.
JointPath spliced(const JointPath& path, const Place& a, const Place& b, const JointPath& stretch) {
  JointPath next;
  const auto add = [&](const Joints& q) {
    if (next.empty() || (q - next.back()).norm() > kRepeat) next.push_back(q);
  };
  for (std::size_t i = 0; i <= a.piece; ++i) add(path[i]);
  for (const Joints& q : stretch) add(q);
  for (std::size_t i = b.piece + 1; i < path.size(); ++i) add(path[i]);
  next.back() = path.back();  // exact, should the last waypoint have been merged
  return next;
}

void attempt(JointPath& path, const MotionTest& is_free, bool partial, Random& random) {
  const auto at = lengths(path);
  double from = random.uniform(0.0, at.back());
  double to = random.uniform(0.0, at.back());
  if (from > to) std::swap(from, to);
  const Place a = place_at(path, at, from), b = place_at(path, at, to);
  if (a.piece == b.piece) return;
  JointPath stretch{a.q};
  if (partial) {
    const auto joint = static_cast<Eigen::Index>(random.index(6));
    for (std::size_t i = a.piece + 1; i <= b.piece; ++i) {
      stretch.push_back(path[i]);
      stretch.back()[joint] = a.q[joint] + (b.q[joint] - a.q[joint]) * (at[i] - from) / (to - from);
    }
  }
  stretch.push_back(b.q);
  if (length(stretch) > to - from - (partial ? kPartialGain : kMinGain)) return;
  if (all_free(stretch, is_free)) path = spliced(path, a, b, stretch);
}

/// Moves one waypoint towards the straight line between its neighbours: some joints only, or all with some
/// noise, so that it slides along obstacles.
void pull(JointPath& path, const MotionTest& is_free, Random& random) {
  const std::size_t i = 1 + random.index(path.size() - 2);
  const Joints &a = path[i - 1], &b = path[i + 1];
  const Joints along = b - a;
  const double length2 = along.squaredNorm();
  const double t = length2 > 0.0 ? std::clamp((path[i] - a).dot(along) / length2, 0.0, 1.0) : 0.0;
  const Joints shift = a + t * along - path[i];
  const double share = random.uniform(kMinPull, 1.0), noise = kPullNoise * shift.norm();
  const bool some = random.uniform() < 0.5;
  Joints moved = path[i];
  for (Eigen::Index j = 0; j < 6; ++j) {
    if (!some)
      moved[j] += share * shift[j] + random.normal(0.0, noise);
    else if (random.uniform() < 0.5)
      moved[j] += share * shift[j];
  }
  const double before = (path[i] - a).norm() + (b - path[i]).norm();
  if ((moved - a).norm() + (b - moved).norm() > before - kMinGain) return;
  if (is_free(a, moved) && is_free(moved, b)) path[i] = moved;
}

/// Appends a free path from `a` to `b`, without `a`.
bool repair(const Joints& a, const Joints& b, const MotionTest& is_free, int depth, Random& random,
            JointPath& out) {
  if (is_free(a, b)) {
    out.push_back(b);
    return true;
  }
  if (depth == 0) return false;
  const Joints middle = 0.5 * (a + b);
  const double sigma = std::min(kMaxRepair, kRepairShare * (b - a).norm());
  for (int k = 0; k < kMendTries; ++k) {
    Joints moved = middle;
    for (auto& angle : moved) angle += random.normal(0.0, sigma);
    if (!is_free(a, moved) || !is_free(moved, b)) continue;
    out.push_back(moved);
    out.push_back(b);
    return true;
  }
  return repair(a, middle, is_free, depth - 1, random, out) &&
         repair(middle, b, is_free, depth - 1, random, out);
}

}  // namespace

JointPath without_detours(JointPath path, const MotionTest& is_free) {
  for (std::size_t i = 0; i + 2 < path.size(); ++i) {
    std::size_t next = path.size() - 1;
    while (next > i + 1 && !is_free(path[i], path[next])) --next;
    path.erase(path.begin() + static_cast<std::ptrdiff_t>(i) + 1,
               path.begin() + static_cast<std::ptrdiff_t>(next));
  }
  return path;
}

JointPath shortcut(JointPath path, const MotionTest& is_free, int attempts, Random& random) {
  for (int k = 0; k < attempts && path.size() > 2; ++k) {
    throw_if_interrupted();
    attempt(path, is_free, k % 2 == 1, random);
    if (path.size() > 2) pull(path, is_free, random);
  }
  return path;
}

JointPath repaired(const JointPath& path, const MotionTest& is_free, Random& random) {
  JointPath out{path.front()};
  for (std::size_t i = 1; i < path.size(); ++i)
    if (!repair(path[i - 1], path[i], is_free, kRepairDepth, random, out)) return {};
  return out;
}

}  // namespace stonestack::motion
