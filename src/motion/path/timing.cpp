#include "motion/timing.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "motion/path/jerk_profile.hpp"
#include "motion/path/tool_speed.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::motion {
namespace {

constexpr int kBlendCells = 16;  ///< measured: 64 shorten a motion by less than 0.1 %
constexpr double kUnbounded = 1e12;
constexpr double kShortestJudged = 1e-5;  ///< [s]
constexpr double kMinJerk = 1.0;          ///< rad/s^3: with less a plan of a minute becomes one of many

/// A stretch of the path between two grid points, and the squared path speeds x = (ds/dt)^2 at its ends.
/// On it d2s/dt2 is constant; on a line it may also be a trapezoid with `acceleration` and `fastest`.
struct Cell {
  Joints q0, q1, tangent0, tangent1, curvature;
  double length = 0.0;
  double fastest = 0.0;       ///< bound of x on the whole cell
  double acceleration = 0.0;  ///< bound of |d2s/dt2|, lines only
  bool line = true;
  bool stop_after = false;
};

double fastest_squared(const Joints& tangent, const TimingLimits& limits) {
  double x = kUnbounded;
  for (int j = 0; j < 6; ++j)
    if (const double t = std::abs(tangent[j]); t > 1e-12)
      x = std::min(x, std::pow(limits.velocity[j] / t, 2));
  return x;
}

double line_acceleration(const Joints& tangent, const TimingLimits& limits) {
  double u = kUnbounded;
  for (int j = 0; j < 6; ++j)
    if (const double t = std::abs(tangent[j]); t > 1e-12) u = std::min(u, limits.acceleration[j] / t);
  return u;
}

void append_cells(std::vector<Cell>& cells, const PathPiece& piece, const TimingLimits& limits) {
  const int count = piece.is_line() ? 1 : kBlendCells;
  for (int i = 0; i < count; ++i) {
    const double s0 = piece.length * i / count, s1 = piece.length * (i + 1) / count;
    Cell c;
    c.q0 = piece.at(s0);
    c.q1 = piece.at(s1);
    c.tangent0 = piece.tangent_at(s0);
    c.tangent1 = piece.tangent_at(s1);
    c.curvature = piece.curvature;
    c.length = s1 - s0;
    c.line = piece.is_line();
    c.fastest = std::min(fastest_squared(c.tangent0, limits), fastest_squared(c.tangent1, limits));
    c.acceleration = c.line ? line_acceleration(c.tangent0, limits) : 0.0;
    c.stop_after = piece.stop_after;
    cells.push_back(c);
  }
}

/// a x + b y <= c in the plane of the squared speeds x, y at the two ends of a cell.
struct HalfPlane {
  double a, b, c;
};

/// Joint acceleration is linear in s on a parabola with constant d2s/dt2, so the two ends bound it exactly.
std::array<HalfPlane, 24> half_planes(const Cell& cell, const Joints& acceleration) {
  std::array<HalfPlane, 24> planes;
  std::size_t n = 0;
  for (int j = 0; j < 6; ++j) {
    const double t0 = cell.tangent0[j] / (2 * cell.length), t1 = cell.tangent1[j] / (2 * cell.length);
    const double k = cell.curvature[j];
    planes[n++] = {k - t0, t0, acceleration[j]};
    planes[n++] = {t0 - k, -t0, acceleration[j]};
    planes[n++] = {-t1, t1 + k, acceleration[j]};
    planes[n++] = {t1, -t1 - k, acceleration[j]};
  }
  return planes;
}

/// Largest x with a y in [0, max_y] that keeps every half plane: clips a rectangle.
double max_start(const Cell& cell, const Joints& acceleration, double max_y) {
  std::vector<Eigen::Vector2d> polygon{{0, 0}, {cell.fastest, 0}, {cell.fastest, max_y}, {0, max_y}};
  std::vector<Eigen::Vector2d> clipped;
  for (const HalfPlane& h : half_planes(cell, acceleration)) {
    clipped.clear();
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const Eigen::Vector2d &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
      const double dp = h.a * p.x() + h.b * p.y() - h.c, dq = h.a * q.x() + h.b * q.y() - h.c;
      if (dp <= 0) clipped.push_back(p);
      if ((dp < 0 && dq > 0) || (dp > 0 && dq < 0)) clipped.push_back(p + (q - p) * (dp / (dp - dq)));
    }
    polygon.swap(clipped);
  }
  double x = 0.0;
  for (const Eigen::Vector2d& p : polygon) x = std::max(x, p.x());
  return x;
}

/// Largest y in [0, max_y] that can follow x.
double max_end(const Cell& cell, const Joints& acceleration, double x, double max_y) {
  double y = max_y;
  for (const HalfPlane& h : half_planes(cell, acceleration))
    if (h.b > 1e-12) y = std::min(y, (h.c - h.a * x) / h.b);
  return std::max(y, 0.0);
}

/// Squared path speed at every grid point: backward what can still be stopped, forward as fast as that
/// allows.
std::vector<double> squared_speeds(const std::vector<Cell>& cells, const Joints& acceleration) {
  std::vector<double> x(cells.size() + 1, 0.0);
  for (std::size_t i = cells.size(); i-- > 0;) {
    const Cell& c = cells[i];
    const double end = c.stop_after ? 0.0 : std::min(x[i + 1], c.fastest);
    x[i + 1] = end;
    x[i] =
        c.line ? std::min(c.fastest, end + 2 * c.acceleration * c.length) : max_start(c, acceleration, end);
  }
  x.front() = 0.0;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Cell& c = cells[i];
    x[i + 1] = c.line ? std::min(x[i + 1], x[i] + 2 * c.acceleration * c.length)
                      : max_end(c, acceleration, x[i], x[i + 1]);
  }
  return x;
}

void add_knot(JointTrajectory& out, double dt, const Joints& q, const Joints& qd) {
  if (dt <= 1e-12) return;
  out.time.push_back(out.time.back() + dt);
  out.q.push_back(q);
  out.qd.push_back(qd);
}

/// Accelerate, cruise, brake between squared speeds x and y; the switches are knots.
void add_line(JointTrajectory& out, const Cell& c, double x, double y) {
  const double u = c.acceleration;
  const double peak = std::max({x, y, std::min(c.fastest, (x + y) / 2 + u * c.length)});
  const double up = (peak - x) / (2 * u), down = (peak - y) / (2 * u);
  const double flat = std::max(0.0, c.length - up - down);
  const double v0 = std::sqrt(x), v = std::sqrt(peak), v1 = std::sqrt(y);
  add_knot(out, (v - v0) / u, c.q0 + up * c.tangent0, v * c.tangent0);
  add_knot(out, flat / v, c.q0 + (up + flat) * c.tangent0, v * c.tangent0);
  add_knot(out, (v - v1) / u, c.q1, v1 * c.tangent1);
}

/// Slows the whole motion by the little that cubic pieces exceed a limit between exact knots.
void stretch(JointTrajectory& out, const TimingLimits& limits) {
  double factor = 1.0;
  for (std::size_t i = 0; i + 1 < out.time.size(); ++i) {
    const double dt = out.time[i + 1] - out.time[i];
    const Joints mean = (out.q[i + 1] - out.q[i]) / dt;
    const Joints a0 = (6 * mean - 4 * out.qd[i] - 2 * out.qd[i + 1]) / dt;
    const Joints a1 = (-6 * mean + 2 * out.qd[i] + 4 * out.qd[i + 1]) / dt;
    for (int j = 0; j < 6; ++j) {
      double v = std::max(std::abs(out.qd[i][j]), std::abs(out.qd[i + 1][j]));
      if (a0[j] * a1[j] < 0)  // the speed turns inside the piece
        v = std::max(v, std::abs(out.qd[i][j] + 0.5 * a0[j] * dt * a0[j] / (a0[j] - a1[j])));
      // A shorter piece is within limits by construction; what is seen of it is rounding over dt squared.
      const double a = dt > kShortestJudged ? std::max(std::abs(a0[j]), std::abs(a1[j])) : 0.0;
      factor = std::max({factor, v / limits.velocity[j], std::sqrt(a / limits.acceleration[j])});
    }
  }
  if (factor == 1.0) return;
  factor *= 1.0 + 1e-9;
  for (double& t : out.time) t *= factor;
  for (Joints& qd : out.qd) qd /= factor;
}

void check(const JointPath& path, const TimingLimits& limits) {
  require(!path.empty(), "a path to time has no waypoints");
  for (const Joints& q : path) require(q.allFinite(), "a waypoint is not finite: ", q.transpose());
  require((limits.velocity.array() > 0).all() && limits.velocity.allFinite(),
          "joint velocity limits must be positive, got ", limits.velocity.transpose(), " rad/s");
  require((limits.acceleration.array() > 0).all() && limits.acceleration.allFinite(),
          "joint acceleration limits must be positive, got ", limits.acceleration.transpose(), " rad/s^2");
  require(std::isfinite(limits.jerk) && limits.jerk >= 0, "a jerk limit cannot be ", limits.jerk, " rad/s^3");
  require(limits.blend >= 0 && limits.tool_speed >= 0, "blend and tool speed must not be negative, got ",
          limits.blend, " rad and ", limits.tool_speed, " m/s");
}

JointTrajectory run(const JointPath& path, const std::vector<Cell>& cells, const TimingLimits& limits) {
  JointTrajectory out{{0.0}, {path.front()}, {Joints::Zero()}};
  const std::vector<double> x = squared_speeds(cells, limits.acceleration);
  for (std::size_t i = 0; i < cells.size(); ++i) {
    const Cell& c = cells[i];
    if (c.line)
      add_line(out, c, x[i], x[i + 1]);
    else
      add_knot(out, 2 * c.length / (std::sqrt(x[i]) + std::sqrt(x[i + 1])), c.q1,
               std::sqrt(x[i + 1]) * c.tangent1);
  }
  stretch(out, limits);
  return out;
}

/// `tool` may be null.
JointTrajectory timed(const JointPath& path, const TimingLimits& limits, const ToolLimit* tool) {
  check(path, limits);
  if (limits.jerk > 0) return time_with_jerk(path, limits, tool);
  std::vector<Cell> cells;
  for (const PathPiece& piece : smooth_pieces(path, limits.blend, tool != nullptr ? kToolLine : kUnbounded))
    append_cells(cells, piece, limits);
  if (tool != nullptr)
    for (Cell& c : cells)
      c.fastest = std::min(
          c.fastest,
          std::pow(fastest_with_tool({c.q0, c.tangent0, c.curvature, c.length, false, Joints::Zero()}, *tool),
                   2));
  return run(path, cells, limits);
}

}  // namespace

TimingLimits timing_limits(const RobotModel& robot, const MotionOptions& options) {
  TimingLimits limits;
  limits.velocity = options.speed_scale * robot.velocity;
  limits.acceleration = robot.acceleration.cwiseMin(options.acceleration);
  require(options.jerk == 0 || options.jerk >= kMinJerk, "motion.jerk must be 0 (no limit) or at least ",
          kMinJerk, " rad/s^3, got ", options.jerk);
  limits.jerk = options.jerk;
  return limits;
}

JointTrajectory time_path(const JointPath& path, const TimingLimits& limits) {
  require(limits.tool_speed == 0, "a tool speed limit needs the robot, got ", limits.tool_speed, " m/s");
  return timed(path, limits, nullptr);
}

JointTrajectory time_path(const JointPath& path, const TimingLimits& limits, const RobotModel& robot,
                          const Pose& T_F_T, const ToolSpeed& tool_speed) {
  const double max = limits.tool_speed > 0 ? std::min(limits.tool_speed, robot.tool_speed) : robot.tool_speed;
  if (std::isinf(max) && !tool_speed) return timed(path, limits, nullptr);
  const ToolLimit tool{robot, T_F_T,
                       [&](const Joints& q) { return tool_speed ? std::min(max, tool_speed(q)) : max; }};
  return timed(path, limits, &tool);
}

JointPath rounded(const JointPath& path, const TimingLimits& limits, double step) {
  constexpr double kSag = 1e-5;  // rad
  require(!path.empty() && limits.blend >= 0 && step > 0,
          "rounding needs waypoints, blend >= 0 and step > 0, got ", path.size(), " waypoints, ",
          limits.blend, " and ", step, " rad");
  JointPath points{path.front()};
  const Corner corner = limits.jerk > 0 ? Corner::kEven : Corner::kParabola;
  for (const PathPiece& piece : smooth_pieces(path, limits.blend, kUnbounded, corner)) {
    // A chord of length c leaves a curve of curvature k by k c^2 / 8.
    const double bend = std::max(piece.curvature.norm(), piece.curvature_at(piece.length).norm());
    const double chord = std::min(step, std::sqrt(8 * kSag / std::max(bend, 1e-12)));
    const int count = std::max(1, static_cast<int>(std::ceil(piece.length / chord)));
    for (int i = 1; i <= count; ++i) points.push_back(piece.at(piece.length * i / count));
  }
  return points;
}

}  // namespace stonestack::motion
