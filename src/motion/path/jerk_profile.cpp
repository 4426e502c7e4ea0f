#include "motion/path/jerk_profile.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace stonestack::motion {
namespace {

constexpr double kSpeedStep = 1.25;  // speed bounds are rounded down to its powers, so that neighbours join
constexpr int kJerkHalvings = 60;
constexpr double kSame = 1e-12;  // rad/s

/// One line or curve, and what the path parameter s may do on it.
struct Stretch {
  PathPiece piece;
  double fastest = 0.0;       ///< ds/dt, rad/s
  double acceleration = 0.0;  ///< |d2s/dt2|, lines only; on curves it is zero
  double jerk = 0.0;          ///< |d3s/dt3|, lines only
};

/// Largest factor with which every |values[j]| keeps its limit.
double headroom(const Joints& values, const Joints& limits) {
  double factor = std::numeric_limits<double>::infinity();
  for (int j = 0; j < 6; ++j)
    if (const double v = std::abs(values[j]); v > 1e-12) factor = std::min(factor, limits[j] / v);
  return factor;
}

/// Tangent and curvature are largest at the ends of a piece, joint by joint: the one is monotone, the other
/// linear.
double fastest_on(const PathPiece& piece, const TimingLimits& limits) {
  const Joints jerk = Joints::Constant(limits.jerk);
  double v = std::cbrt(headroom(piece.third, jerk));
  for (const double s : {0.0, piece.length}) {
    v = std::min(v, headroom(piece.tangent_at(s), limits.velocity));
    v = std::min(v, std::sqrt(headroom(piece.curvature_at(s), limits.acceleration)));
  }
  return v;
}

std::vector<Stretch> stretches(const JointPath& path, const TimingLimits& limits, const ToolLimit* tool) {
  std::vector<Stretch> out;
  const double longest = tool != nullptr ? kToolLine : std::numeric_limits<double>::infinity();
  for (const PathPiece& piece : smooth_pieces(path, limits.blend, longest, Corner::kEven)) {
    Stretch next{piece, fastest_on(piece, limits), headroom(piece.tangent, limits.acceleration),
                 headroom(piece.tangent, Joints::Constant(limits.jerk))};
    if (tool != nullptr) {
      next.fastest = std::min(next.fastest, fastest_with_tool(piece, *tool));
      next.fastest = std::pow(kSpeedStep, std::floor(std::log(next.fastest) / std::log(kSpeedStep)));
    }
    Stretch* last = out.empty() ? nullptr : &out.back();
    const bool joins = last != nullptr && last->piece.is_line() && piece.is_line() &&
                       !last->piece.stop_after && last->fastest == next.fastest &&
                       (last->piece.tangent - piece.tangent).isZero(1e-12);
    if (joins) {
      last->piece.length += piece.length;
      last->piece.stop_after = piece.stop_after;
    } else {
      out.push_back(next);
    }
  }
  return out;
}

/// A change of speed on a line that begins and ends without acceleration.
struct Change {
  double ramp = 0.0;  ///< in which acceleration rises, and falls [s]
  double hold = 0.0;  ///< in which it is constant [s]
  [[nodiscard]] double seconds() const { return 2 * ramp + hold; }
};
Change change(const Stretch& s, double from, double to) {
  const double dv = std::abs(to - from);
  if (dv <= kSame) return {};
  if (dv * s.jerk < s.acceleration * s.acceleration) return {std::sqrt(dv / s.jerk), 0.0};
  return {s.acceleration / s.jerk, dv / s.acceleration - s.acceleration / s.jerk};
}
double distance(const Stretch& s, double from, double to) {
  return 0.5 * (from + to) * change(s, from, to).seconds();
}

/// The largest speed in [low, high] for which `fits`; `low` if none is.
template <class Fits>
double max_fitting(double low, double high, const Fits& fits) {
  if (fits(high)) return high;
  for (int k = 0; k < kJerkHalvings; ++k) {
    const double middle = 0.5 * (low + high);
    (fits(middle) ? low : high) = middle;
  }
  return low;
}

/// The largest speed up to `wanted` on one side of `s` that `other` on its other side allows.
double reachable(const Stretch& s, double other, double wanted) {
  if (wanted <= other || !s.piece.is_line()) return std::min(wanted, other);
  return max_fitting(other, wanted, [&](double v) { return distance(s, other, v) <= s.piece.length; });
}

/// ds/dt between stretches, zero at both ends: first what the path behind allows, then the path ahead.
std::vector<double> speeds(const std::vector<Stretch>& all) {
  std::vector<double> v(all.size() + 1, 0.0);
  for (std::size_t i = 1; i < all.size(); ++i) {
    const double max = std::min(all[i - 1].fastest, all[i].fastest);
    v[i] = all[i - 1].piece.stop_after ? 0.0 : reachable(all[i - 1], v[i - 1], max);
  }
  for (std::size_t i = all.size(); i-- > 1;) v[i] = reachable(all[i], v[i + 1], v[i]);
  return v;
}

/// Appends motion along one stretch after the other; each phase is a cubic in time, so knots are exact.
class Writer {
 public:
  explicit Writer(const Joints& start) : out_{{0.0}, {start}, {Joints::Zero()}} {}

  void curve(const Stretch& stretch, double v) {
    const PathPiece& p = stretch.piece;
    add(p.length / v, p.at(p.length), v * p.tangent_at(p.length));
  }
  void line(const Stretch& stretch, double v0, double v1) {
    const double length = stretch.piece.length;
    const double peak = max_fitting(std::max(v0, v1), stretch.fastest, [&](double v) {
      return distance(stretch, v0, v) + distance(stretch, v, v1) <= length;
    });
    double s = 0.0, v = v0;
    run(stretch, s, v, peak);
    const double cruise = length - s - distance(stretch, peak, v1);
    if (cruise > 0.0) phase(stretch, s, v, cruise / peak, 0.0, 0.0);
    run(stretch, s, v, v1);
    out_.q.back() = stretch.piece.at(length);
    out_.qd.back() = v1 * stretch.piece.tangent;
  }
  [[nodiscard]] JointTrajectory& trajectory() { return out_; }

 private:
  void add(double dt, const Joints& q, const Joints& qd) {
    if (dt <= 1e-12) return;
    out_.time.push_back(out_.time.back() + dt);
    out_.q.push_back(q);
    out_.qd.push_back(qd);
  }
  /// `dt` of constant jerk `j` from acceleration `a` on.
  void phase(const Stretch& stretch, double& s, double& v, double dt, double a, double j) {
    s += dt * (v + dt * (a / 2 + dt * j / 6));
    v += dt * (a + dt * j / 2);
    add(dt, stretch.piece.at(s), v * stretch.piece.tangent);
  }
  void run(const Stretch& stretch, double& s, double& v, double to) {
    const Change c = change(stretch, v, to);
    const double j = to > v ? stretch.jerk : -stretch.jerk, a = j * c.ramp;
    phase(stretch, s, v, c.ramp, 0.0, j);
    phase(stretch, s, v, c.hold, a, 0.0);
    phase(stretch, s, v, c.ramp, a, -j);
    v = to;
  }
  JointTrajectory out_;
};

}  // namespace

JointTrajectory time_with_jerk(const JointPath& path, const TimingLimits& limits, const ToolLimit* tool) {
  const std::vector<Stretch> all = stretches(path, limits, tool);
  const std::vector<double> v = speeds(all);
  Writer out(path.front());
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].piece.is_line())
      out.line(all[i], v[i], v[i + 1]);
    else
      out.curve(all[i], v[i]);
  }
  return std::move(out.trajectory());
}

}  // namespace stonestack::motion
