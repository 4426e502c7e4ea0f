#include "report/link_shapes.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace stonestack::report {
namespace {

constexpr double kOnAxis = 0.02;      // m, of a capsule's end from the axis of a joint
constexpr double kParallel = 0.1;     // sine of the angle between the two
constexpr double kPoint = 1e-3;       // m: a shorter capsule is a ball
constexpr double kNextPart = 0.2;     // m: what is further away on the axis does not follow
constexpr double kTubeWaist = 0.8;    // of the capsule's radius
constexpr double kTubeFlare = 0.05;   // m, at either end of a tube
constexpr double kRound = 0.006;      // m, of edges
constexpr double kLidHeight = 0.022;  // m
constexpr double kGroove = 0.003;     // m, between housing and lid
constexpr int kSides = 40, kBallRings = 8;

struct Line {
  Eigen::Vector3d p, n;
  [[nodiscard]] double distance(const Eigen::Vector3d& q) const { return (q - p).cross(n).norm(); }
};

/// Axes of the joints before and behind a link, in its frame; empty where there is none.
std::optional<Line> axis_before(int link) {
  if (link == 0) return std::nullopt;
  return Line{Eigen::Vector3d::Zero(), Eigen::Vector3d::UnitZ()};
}
std::optional<Line> axis_behind(const RobotModel& robot, int link) {
  if (link == 6) return std::nullopt;
  const Pose& T = robot.T_parent_joint[static_cast<std::size_t>(link)];
  return Line{T.translation(), T.linear().col(2)};
}

/// The next link on that side in the frame of `link`, all joints at zero.
Pose T_link_next(const RobotModel& robot, int link, bool before) {
  if (!before) return robot.T_parent_joint[static_cast<std::size_t>(link)];
  return robot.T_parent_joint[static_cast<std::size_t>(link - 1)].inverse();
}

bool lies_along(const LinkCapsule& c, const std::optional<Line>& axis) {
  const Eigen::Vector3d along = c.b - c.a;
  return axis && along.norm() > kPoint && along.normalized().cross(axis->n).norm() < kParallel &&
         axis->distance(c.a) < kOnAxis && axis->distance(c.b) < kOnAxis;
}

/// How far a housing that ends at `p` goes on towards `n` until it meets the next link.
std::optional<double> to_next_link(const RobotModel& robot, int link, bool before, const Eigen::Vector3d& p,
                                   const Eigen::Vector3d& n) {
  const Pose T = T_link_next(robot, link, before);
  const int next = before ? link - 1 : link + 1;
  const auto axis = before ? axis_before(link) : axis_behind(robot, link);
  std::optional<double> nearest;
  for (const LinkCapsule& c : robot.capsules) {
    if (c.link != next) continue;
    LinkCapsule there = c;
    there.a = T * c.a;
    there.b = T * c.b;
    const double share = lies_along(there, axis) ? 0.5 : 1.0;  // both go half of the way
    for (const Eigen::Vector3d& q : {there.a, there.b}) {
      const double way = (q - p).dot(n);
      if (axis->distance(q) > kOnAxis || way < -kPoint || way > kNextPart) continue;
      if (!nearest || share * way < *nearest) nearest = std::max(0.0, share * way);
    }
  }
  return nearest;
}

void add_ball(std::vector<Eigen::Vector2d>& profile, double at, double radius, bool opens) {
  for (int k = 0; k <= kBallRings; ++k) {
    const double angle = 0.5 * std::numbers::pi * k / kBallRings;
    if (opens)
      profile.emplace_back(at - radius * std::cos(angle), radius * std::sin(angle));
    else
      profile.emplace_back(at + radius * std::sin(angle), radius * std::cos(angle));
  }
}

/// Collects the shapes of one robot.
class ShapeMaker {
 public:
  explicit ShapeMaker(const RobotModel& robot) : robot_(robot) {}

  std::vector<LinkShape> make() {
    for (int link = 0; link <= 6; ++link) {
      std::vector<LinkCapsule> before, behind, others;
      for (const LinkCapsule& c : robot_.capsules) {
        if (c.link != link) continue;
        if (lies_along(c, axis_before(link)))
          before.push_back(c);
        else if (lies_along(c, axis_behind(robot_, link)))
          behind.push_back(c);
        else
          others.push_back(c);
      }
      add_knuckle(link, others, behind);
      for (const LinkCapsule& c : before) add_housing(c, true, {});
      for (const LinkCapsule& c : behind) add_housing(c, false, before);
      before.insert(before.end(), behind.begin(), behind.end());
      for (const LinkCapsule& c : others) add_tube(c, before);
    }
    return std::move(shapes_);
  }

 private:
  /// A tube that ends on the axis of the next joint carries that joint's housing.
  void add_knuckle(int link, const std::vector<LinkCapsule>& others, std::vector<LinkCapsule>& behind) const {
    const auto axis = axis_behind(robot_, link);
    if (!axis || !behind.empty()) return;
    for (const LinkCapsule& c : others)
      for (const Eigen::Vector3d& end : {c.a, c.b})
        if ((c.b - c.a).norm() > 0.25 && axis->distance(end) < kOnAxis) {
          LinkCapsule knuckle = c;
          knuckle.a = knuckle.b = end;
          behind.push_back(knuckle);
          return;
        }
  }

  /// `inner`: housings of the same link in which an end may be hidden.
  void add_housing(const LinkCapsule& c, bool before, const std::vector<LinkCapsule>& inner) {
    const auto axis = before ? axis_before(c.link) : axis_behind(robot_, c.link);
    const double length = (c.b - c.a).norm();
    const Eigen::Vector3d n = length > kPoint ? Eigen::Vector3d((c.b - c.a) / length) : axis->n;
    const End low = end_of(c, before, c.a, -n, inner), high = end_of(c, before, c.b, n, inner);
    LinkShape housing{c.link, c.a - low.way * n, n, {}, false};
    const double total = low.way + length + high.way, r = c.radius;
    housing.profile = {{0.0, 0.0},          {0.0, r - kRound},   {kRound, r},
                       {total - kRound, r}, {total, r - kRound}, {total, 0.0}};
    if (c.link == 0) housing.profile = foot(total, r);
    if (total > 2 * kRound) shapes_.push_back(housing);
    if (low.lid) add_lid(c, housing.p, -n);
    if (high.lid) add_lid(c, housing.p + total * n, n);
  }

  struct End {
    double way = 0.0;  ///< beyond the capsule's end [m]
    bool lid = false;
  };
  [[nodiscard]] End end_of(const LinkCapsule& c, bool before, const Eigen::Vector3d& p,
                           const Eigen::Vector3d& n, const std::vector<LinkCapsule>& inner) const {
    if (const auto way = to_next_link(robot_, c.link, before, p, n)) return {*way, false};
    for (const LinkCapsule& other : inner)
      if (std::min((p - other.a).norm(), (p - other.b).norm()) < 0.5 * other.radius) return {0.0, false};
    if (c.link == 0) return {0.0, false};
    if (c.link == 6) return {c.radius, false};
    return {std::max(0.0, c.radius - kLidHeight - kGroove), true};
  }

  void add_lid(const LinkCapsule& c, const Eigen::Vector3d& p, const Eigen::Vector3d& n) {
    const double r = c.radius;
    shapes_.push_back({c.link,
                       p,
                       n,
                       {{0.0, 0.9 * r},
                        {kGroove, 0.9 * r},
                        {kGroove, 0.97 * r},
                        {kGroove + 0.4 * kLidHeight, 0.94 * r},
                        {kGroove + 0.8 * kLidHeight, 0.78 * r},
                        {kGroove + kLidHeight, 0.5 * r},
                        {kGroove + kLidHeight, 0.0}},
                       true});
  }

  static std::vector<Eigen::Vector2d> foot(double height, double r) {
    constexpr double kPlate = 0.012, kColumn = 0.84;  // m, of the plate; of the radius
    return {{0.0, 0.0},   {0.0, r}, {kPlate, r}, {kPlate + 2 * kRound, kColumn * r}, {height, kColumn * r},
            {height, 0.0}};
  }

  void add_tube(const LinkCapsule& c, const std::vector<LinkCapsule>& housings) {
    const double length = (c.b - c.a).norm(), r = c.radius;
    const auto hidden = [&](const Eigen::Vector3d& p) {
      return std::any_of(housings.begin(), housings.end(), [&](const LinkCapsule& h) {
        const Eigen::Vector3d along = h.b - h.a;
        const double at = std::clamp(along.dot(p - h.a) / std::max(along.squaredNorm(), 1e-12), 0.0, 1.0);
        return (h.a + at * along - p).norm() < h.radius;
      });
    };
    const bool a = hidden(c.a), b = hidden(c.b);
    if (length < kPoint && a) return;
    LinkShape tube{c.link, c.a, Eigen::Vector3d::UnitZ(), {}, false};
    if (length > kPoint) tube.n_axis = (c.b - c.a) / length;
    if (!a) add_ball(tube.profile, 0.0, r, true);
    if (a && b && length > 6 * kTubeFlare)
      tube.profile = {{0.0, r},
                      {r, r},
                      {r + kTubeFlare, kTubeWaist * r},
                      {length - r - kTubeFlare, kTubeWaist * r},
                      {length - r, r},
                      {length, r}};
    else if (a)
      tube.profile = {{0.0, r}, {length, r}};
    if (!b) add_ball(tube.profile, length, r, false);
    shapes_.push_back(std::move(tube));
  }

  const RobotModel& robot_;
  std::vector<LinkShape> shapes_;
};

}  // namespace

std::vector<LinkShape> link_shapes(const RobotModel& robot) {
  return ShapeMaker(robot).make();
}

Mesh mesh_of(const LinkShape& shape) {
  Mesh mesh;
  const Eigen::Vector3d u = shape.n_axis.unitOrthogonal(), v = shape.n_axis.cross(u);
  for (const Eigen::Vector2d& at : shape.profile)
    for (int k = 0; k < kSides; ++k) {
      const double angle = 2.0 * std::numbers::pi * k / kSides;
      mesh.vertices.emplace_back(shape.p + at.x() * shape.n_axis +
                                 at.y() * (std::cos(angle) * u + std::sin(angle) * v));
    }
  for (int ring = 0; ring + 1 < static_cast<int>(shape.profile.size()); ++ring)
    for (int k = 0; k < kSides; ++k) {
      const int a = ring * kSides + k, b = ring * kSides + (k + 1) % kSides;
      mesh.faces.emplace_back(a, b, b + kSides);
      mesh.faces.emplace_back(a, b + kSides, a + kSides);
    }
  return mesh;
}

}  // namespace stonestack::report
