#include "stone/symmetry.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "geometry/surface_tree.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::stone {
namespace {

constexpr std::size_t kFewSamples = 60;        // of a first test
constexpr std::size_t kManySamples = 600;      // of the verdict
constexpr double kSymmetryTolerance = 0.015;   // of the diagonal: dents and relief of a shape that is one
constexpr double kWorthRefining = 4.0;         // times the tolerance, before the search
constexpr double kNearlyAsLong = 0.12;         // of the larger of two variances
constexpr int kAcross = 36;                    // directions across an axis, 5 deg apart
constexpr std::size_t kLargeFaces = 6;         // directions
constexpr double kSameFace = 0.995;            // cosine: 6 deg
constexpr double kSameDirection = 0.998;       // cosine: 4 deg, well within the reach of the search
constexpr double kSameAxis = 0.985;            // cosine: 10 deg
constexpr double kSameTurn = 0.2;              // rad: axes are found within a few degrees
constexpr std::size_t kMaxTurnsOfAShape = 60;  // of an icosahedron
constexpr std::array<double, 5> kAnyAngles = {0.36, 0.83, 1.37, 2.11, 2.71};  // rad, no fractions of a turn

/// Surface of a mesh, and how far a copy of it lies from itself.
class Shape {
 public:
  explicit Shape(const Mesh& mesh) : tree_(mesh) {
    const double diagonal = bounds(mesh).diagonal().norm();
    const auto samples = sample_surface(mesh, diagonal / 60.0);
    double area = 0.0;
    for (const auto& s : samples) centre_ += s.area * s.point, area += s.area;
    centre_ /= area;
    for (const auto& s : samples) {
      const Eigen::Vector3d off = s.point - centre_;
      spread_ += s.area / area * off * off.transpose();
    }
    for (std::size_t k = 0; k < std::min(kManySamples, samples.size()); ++k)
      points_.push_back(samples[k * samples.size() / std::min(kManySamples, samples.size())].point - centre_);
    tolerance_ = kSymmetryTolerance * diagonal;
  }

  [[nodiscard]] const Eigen::Vector3d& centre() const { return centre_; }
  [[nodiscard]] const Eigen::Matrix3d& spread() const { return spread_; }
  [[nodiscard]] double tolerance() const { return tolerance_; }

  /// The 90 % quantile of the distances of about `count` points from the surface after `M` about the centre.
  [[nodiscard]] double deviation(const Eigen::Matrix3d& M, std::size_t count) const {
    std::vector<double> off;
    const std::size_t stride = std::max<std::size_t>(1, points_.size() / count);
    for (std::size_t k = 0; k < points_.size(); k += stride)
      off.push_back(std::abs(tree_.nearest(centre_ + M * points_[k]).distance));
    const auto at = off.begin() + static_cast<std::ptrdiff_t>(0.9 * static_cast<double>(off.size() - 1));
    std::nth_element(off.begin(), at, off.end());
    return *at;
  }

 private:
  SurfaceTree tree_;
  Eigen::Vector3d centre_ = Eigen::Vector3d::Zero();
  Eigen::Matrix3d spread_ = Eigen::Matrix3d::Zero();
  std::vector<Eigen::Vector3d> points_;  ///< from the centre
  double tolerance_ = 0.0;
};

Eigen::Matrix3d turn(const Eigen::Vector3d& n, double angle) {
  return Eigen::AngleAxisd(angle, n).toRotationMatrix();
}

Eigen::Matrix3d mirror(const Eigen::Vector3d& n) {
  return Eigen::Matrix3d::Identity() - 2.0 * n * n.transpose();
}

/// Directions of the largest faces or groups of coplanar ones.
std::vector<Eigen::Vector3d> large_faces(const Mesh& mesh) {
  struct Group {
    Eigen::Vector3d n;
    double area;
  };
  std::vector<Group> groups;
  for (const auto& s : sample_surface(mesh, bounds(mesh).diagonal().norm() / 40.0)) {
    const auto same = std::find_if(groups.begin(), groups.end(),
                                   [&](const Group& g) { return std::abs(g.n.dot(s.normal)) > kSameFace; });
    if (same == groups.end())
      groups.push_back({s.normal, s.area});
    else
      same->area += s.area;
  }
  std::stable_sort(groups.begin(), groups.end(),
                   [](const Group& a, const Group& b) { return a.area > b.area; });
  std::vector<Eigen::Vector3d> normals;
  for (std::size_t k = 0; k < std::min(kLargeFaces, groups.size()); ++k) normals.push_back(groups[k].n);
  return normals;
}

std::vector<Eigen::Vector3d> candidate_directions(const Mesh& mesh, const Shape& shape) {
  std::vector<Eigen::Vector3d> all;
  const auto add = [&](const Eigen::Vector3d& n) {
    if (n.norm() < 0.1) return;
    const Eigen::Vector3d unit = n.normalized();
    if (std::none_of(all.begin(), all.end(), [&](const Eigen::Vector3d& other) {
          return std::abs(other.dot(unit)) > kSameDirection;
        }))
      all.push_back(unit);
  };
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(shape.spread());
  const Eigen::Vector3d variance = solver.eigenvalues();
  for (int k = 0; k < 3; ++k) add(solver.eigenvectors().col(k));
  const auto alike = [&](int a, int b) { return variance[b] - variance[a] < kNearlyAsLong * variance[b]; };
  const auto between = [&](int a, int b) {
    for (int k = 1; k < kAcross; ++k) {
      const double angle = std::numbers::pi * k / kAcross;
      add(std::cos(angle) * solver.eigenvectors().col(a) + std::sin(angle) * solver.eigenvectors().col(b));
    }
  };
  const auto normals = large_faces(mesh);
  if (alike(0, 1)) between(0, 1);
  if (alike(1, 2)) between(1, 2);
  if (alike(0, 1) || alike(1, 2)) {
    for (const auto& n : normals) add(n);
    for (std::size_t i = 0; i < normals.size(); ++i)
      for (std::size_t k = 0; k < i; ++k) {
        add(normals[i] + normals[k]), add(normals[i] - normals[k]), add(normals[i].cross(normals[k]));
        for (std::size_t l = 0; alike(0, 2) && l < k; ++l)
          for (const double a : {-1.0, 1.0})
            for (const double b : {-1.0, 1.0}) add(normals[i] + a * normals[k] + b * normals[l]);
      }
  }
  return all;
}

/// A direction, and how far the motion that it stands for takes the surface from itself.
struct Direction {
  Eigen::Vector3d n;
  double off;
};

/// The direction near `n` for which `motion(direction)` fits best, and how well; `n` itself if that is
/// hopeless.
template <class Motion>
Direction refined(const Shape& shape, const Eigen::Vector3d& n, const Motion& motion) {
  Direction best{n, shape.deviation(motion(n), kFewSamples)};
  if (best.off > kWorthRefining * shape.tolerance()) return best;
  for (double step = 0.07; step > 0.003; step *= 0.5)
    for (bool moved = true; moved;) {
      moved = false;
      const Eigen::Vector3d u = best.n.unitOrthogonal(), v = best.n.cross(u);
      for (const Eigen::Vector3d& side : {u, Eigen::Vector3d(-u), v, Eigen::Vector3d(-v)}) {
        const Eigen::Vector3d other = (best.n + step * side).normalized();
        const double off = shape.deviation(motion(other), kFewSamples);
        if (off < 0.98 * best.off) best = {other, off}, moved = true;
      }
    }
  best.off = shape.deviation(motion(best.n), kManySamples);
  return best;
}

bool known(const std::vector<SymmetryAxis>& axes, const Eigen::Vector3d& n) {
  return std::any_of(axes.begin(), axes.end(),
                     [&](const SymmetryAxis& a) { return std::abs(a.n_O.dot(n)) > kSameAxis; });
}

/// Largest distance by which turns by multiples of 360 deg / order about an axis take the surface from
/// itself.
double worst_turn(const Shape& shape, const Eigen::Vector3d& n, int order) {
  double worst = 0.0;
  for (int k = 1; k < order; ++k)
    worst = std::max(worst, shape.deviation(turn(n, 2.0 * std::numbers::pi * k / order), kManySamples));
  return worst;
}

/// Largest distance by which turns by any angle do so.
double worst_of_any(const Shape& shape, const Eigen::Vector3d& n) {
  double worst = 0.0;
  for (const double angle : kAnyAngles)
    worst = std::max(worst, shape.deviation(turn(n, angle), kManySamples));
  return worst;
}

/// The axis near a direction, of the highest order; order 1 for none. An order holds where its prime factors
/// do.
SymmetryAxis axis_near(const Shape& shape, const Eigen::Vector3d& n) {
  SymmetryAxis best{n, 1, 0.0};
  for (const int prime : {2, 3, 5}) {
    const double angle = 2.0 * std::numbers::pi / prime;
    const auto one = refined(shape, n, [&](const Eigen::Vector3d& a) { return turn(a, angle); });
    if (one.off > shape.tolerance()) continue;
    if (const double any = worst_of_any(shape, one.n); any < shape.tolerance()) return {one.n, 0, any};
    for (const int order : {prime, 2 * prime}) {
      const double off = worst_turn(shape, one.n, order);
      if (off < shape.tolerance() && order > best.order) best = {one.n, order, off};
    }
  }
  return best;
}

/// True if a direction follows from an axis of any angle: across it, where there is one of the kind already.
template <class List>
bool follows(const std::vector<SymmetryAxis>& axes, const List& list, const Eigen::Vector3d& n) {
  return std::any_of(axes.begin(), axes.end(), [&](const SymmetryAxis& any) {
    const auto across = [&](const Eigen::Vector3d& m) { return std::abs(m.dot(any.n_O)) < 0.17; };
    return any.order == 0 && across(n) &&
           std::any_of(list.begin(), list.end(), [&](const auto& one) { return across(one.n_O); });
  });
}

}  // namespace

Symmetries find_symmetries(const Mesh& mesh) {
  require(!mesh.faces.empty(), "a mesh without faces has no symmetries");
  const Shape shape(mesh);
  Symmetries found;
  found.p_O = shape.centre();
  const auto directions = candidate_directions(mesh, shape);
  for (const auto& n : directions) {
    if (known(found.axes, n) || follows(found.axes, found.axes, n)) continue;
    const SymmetryAxis axis = axis_near(shape, n);
    if (axis.order == 1 || known(found.axes, axis.n_O)) continue;
    found.axes.push_back(axis);
    std::stable_sort(found.axes.begin(), found.axes.end(), [](const SymmetryAxis& a, const SymmetryAxis& b) {
      return a.order == 0 && b.order != 0;
    });
  }
  // Twofold axes across one of any angle may have been found before it.
  std::vector<SymmetryAxis> axes;
  for (const auto& axis : found.axes)
    if (!follows(axes, axes, axis.n_O)) axes.push_back(axis);
  found.axes = axes;
  for (const auto& n : directions) {
    const auto same = [&](const Eigen::Vector3d& m) {
      return std::any_of(found.planes.begin(), found.planes.end(),
                         [&](const SymmetryPlane& plane) { return std::abs(plane.n_O.dot(m)) > kSameAxis; });
    };
    if (same(n) || follows(found.axes, found.planes, n)) continue;
    const auto plane = refined(shape, n, mirror);
    if (same(plane.n) || follows(found.axes, found.planes, plane.n)) continue;
    if (plane.off < shape.tolerance()) found.planes.push_back({plane.n, plane.off});
  }
  return found;
}

std::vector<Pose> discrete_turns(const Symmetries& symmetries) {
  std::vector<Eigen::Matrix3d> turns{Eigen::Matrix3d::Identity()};
  const auto add = [&](const Eigen::Matrix3d& R) {
    const bool is_new = std::none_of(turns.begin(), turns.end(), [&](const Eigen::Matrix3d& other) {
      return Eigen::AngleAxisd(other.transpose() * R).angle() < kSameTurn;
    });
    if (is_new && turns.size() <= kMaxTurnsOfAShape) turns.push_back(R);
  };
  for (const auto& axis : symmetries.axes)
    for (int k = 1; k < axis.order; ++k) add(turn(axis.n_O, 2.0 * std::numbers::pi * k / axis.order));
  for (std::size_t i = 1; i < turns.size(); ++i)
    for (std::size_t k = 1; k <= i; ++k) add(turns[i] * turns[k]), add(turns[k] * turns[i]);
  std::vector<Pose> poses;
  for (std::size_t i = 1; i < turns.size(); ++i) {
    Pose T = Pose::Identity();
    T.linear() = turns[i];
    T.translation() = symmetries.p_O - T.linear() * symmetries.p_O;
    poses.push_back(T);
  }
  return poses;
}

}  // namespace stonestack::stone
