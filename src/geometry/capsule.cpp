#include "geometry/capsule.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace stonestack::geometry {
namespace {

using Points = Eigen::Matrix3Xd;

constexpr int kDirections = 60;  // in which the extreme points stand for all, until the capsule is widened
constexpr double kSkin = 1e-6;   // m added to every radius: rounding never uncovers a corner

/// Points spread evenly over half of the unit sphere, one a row.
const Eigen::MatrixX3d& directions() {
  static const Eigen::MatrixX3d all = [] {
    Eigen::MatrixX3d list(kDirections, 3);
    for (int k = 0; k < kDirections; ++k) {
      const double z = (k + 0.5) / kDirections;
      const double turn = k * std::numbers::pi * (3.0 - std::sqrt(5.0));
      const double r = std::sqrt(1.0 - z * z);
      list.row(k) << r * std::cos(turn), r * std::sin(turn), z;
    }
    return list;
  }();
  return all;
}

/// The points that reach farthest, each way along each direction.
Points extremes(const Points& points) {
  if (points.cols() <= 2 * kDirections) return points;
  const Eigen::MatrixXd along = directions() * points;
  std::vector<Eigen::Index> chosen(2 * kDirections);
  for (int k = 0; k < kDirections; ++k) {
    (void)along.row(k).minCoeff(&chosen[static_cast<std::size_t>(2 * k)]);
    (void)along.row(k).maxCoeff(&chosen[static_cast<std::size_t>(2 * k + 1)]);
  }
  std::sort(chosen.begin(), chosen.end());
  chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
  return points(Eigen::all, chosen);
}

/// The point as far from all three; the middle of the first two if they lie on a line.
Eigen::Vector2d circumcentre(const Eigen::Vector2d& p, const Eigen::Vector2d& q, const Eigen::Vector2d& r) {
  const Eigen::Vector2d a = q - p, b = r - p;
  const double twice = 2.0 * (a.x() * b.y() - a.y() * b.x());
  if (std::abs(twice) < 1e-12 * a.norm() * b.norm()) return 0.5 * (p + q);
  const double a2 = a.squaredNorm(), b2 = b.squaredNorm();
  return p + Eigen::Vector2d(b.y() * a2 - a.y() * b2, a.x() * b2 - b.x() * a2) / twice;
}

/// Centre of the smallest circle that holds all points (Welzl 1991, without the shuffling).
Eigen::Vector2d middle_of(const Eigen::Matrix2Xd& points) {
  Eigen::Vector2d centre = points.col(0);
  double radius2 = 0.0;
  const auto outside = [&](Eigen::Index k) {
    return (points.col(k) - centre).squaredNorm() > radius2 * (1.0 + 1e-12);
  };
  const auto take = [&](const Eigen::Vector2d& middle, Eigen::Index rim) {
    centre = middle;
    radius2 = (points.col(rim) - middle).squaredNorm();
  };
  for (Eigen::Index i = 1; i < points.cols(); ++i) {
    if (!outside(i)) continue;
    take(points.col(i), i);
    for (Eigen::Index j = 0; j < i; ++j) {
      if (!outside(j)) continue;
      take(0.5 * (points.col(i) + points.col(j)), i);
      for (Eigen::Index k = 0; k < j; ++k)
        if (outside(k)) take(circumcentre(points.col(i), points.col(j), points.col(k)), i);
    }
  }
  return centre;
}

/// Of the capsules with this axis that hold the points: a wider one may be shorter.
Capsule along(const Eigen::Vector3d& n_axis, const Points& points) {
  Eigen::Matrix<double, 2, 3> across;
  across.row(0) = n_axis.unitOrthogonal().transpose();
  across.row(1) = n_axis.cross(across.row(0).transpose()).transpose();
  const Eigen::Matrix2Xd flat = across * points;
  const Eigen::ArrayXd height = (n_axis.transpose() * points).transpose();
  const Eigen::Vector2d centre = middle_of(flat);
  const Eigen::ArrayXd off2 = (flat.colwise() - centre).colwise().squaredNorm().transpose();
  const Eigen::Vector3d origin = across.transpose() * centre;
  Capsule best;
  double min = std::numeric_limits<double>::infinity();
  for (const double wider : {1.0, 1.02, 1.05, 1.1, 1.2, 1.35}) {
    const double radius = wider * std::sqrt(off2.maxCoeff()) + kSkin;
    const Eigen::ArrayXd half_chord = (radius * radius - off2).max(0.0).sqrt();
    double low = (height + half_chord).minCoeff(), high = (height - half_chord).maxCoeff();
    if (low > high) low = high = 0.5 * (low + high);  // a sphere: any place between holds them all
    const Capsule capsule{origin + low * n_axis, origin + high * n_axis, radius};
    if (volume(capsule) >= min) continue;
    best = capsule;
    min = volume(capsule);
  }
  return best;
}

}  // namespace

double volume(const Capsule& capsule) {
  const double r = capsule.radius;
  return std::numbers::pi * r * r * ((capsule.b - capsule.a).norm() + 4.0 / 3.0 * r);
}

double distance(const Capsule& capsule, const Eigen::Vector3d& p) {
  const Eigen::Vector3d segment = capsule.b - capsule.a;
  const double length2 = segment.squaredNorm();
  const double t = length2 > 0.0 ? std::clamp((p - capsule.a).dot(segment) / length2, 0.0, 1.0) : 0.0;
  return (p - capsule.a - t * segment).norm() - capsule.radius;
}

std::vector<Eigen::Vector3d> axes_of(const Points& points) {
  constexpr double kSame = 0.995;  // cosine (6 deg)
  const Points centred = points.colwise() - points.rowwise().mean();
  const Eigen::Matrix3d spread = centred * centred.transpose();
  const Eigen::Matrix3d own = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors();
  std::vector<Eigen::Vector3d> axes{Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitY(),
                                    Eigen::Vector3d::UnitZ()};
  for (const Eigen::Vector3d& axis : own.colwise())
    if (axis.cwiseAbs().maxCoeff() < kSame) axes.push_back(axis);
  return axes;
}

Capsule fit_capsule(const Points& all, bool carefully) {
  const Points points = extremes(all);
  Capsule best;
  Eigen::Vector3d n_best;
  double min = std::numeric_limits<double>::infinity();
  const auto consider = [&](const Eigen::Vector3d& n) {
    const Capsule capsule = along(n, points);
    if (volume(capsule) >= min) return;
    best = capsule;
    n_best = n;
    min = volume(capsule);
  };
  for (const auto& axis : axes_of(points)) consider(axis);
  for (double tilt = 0.2; carefully && tilt > 0.005; tilt *= 0.5) {
    const Eigen::Vector3d n = n_best, x = n.unitOrthogonal(), y = n.cross(x);
    for (const Eigen::Vector3d& side : {x, y})
      for (const double sign : {-1.0, 1.0}) consider((n + sign * tilt * side).normalized());
  }
  double out = 0.0;
  for (const Eigen::Vector3d& p : all.colwise()) out = std::max(out, distance(best, p));
  if (out > 0.0) best.radius += out + kSkin;
  return best;
}

}  // namespace stonestack::geometry
