#include "pose_error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "stonestack/core/error.hpp"
#include "stonestack/geometry/convex_pieces.hpp"

namespace stonestack::bench {
namespace {

constexpr double kSymmetryStep = 0.01;  // of the diameter: the toolkit's max_sym_disc_step
constexpr std::size_t kNearestPoints =
    2000;  // of the estimate, for which the nearest true point is looked up

double max_distance(const std::vector<Eigen::Vector3d>& points) {
  double max = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) max = std::max(max, (points[i] - points[j]).squaredNorm());
  return std::sqrt(max);
}

/// The turns about one axis, the identity first.
std::vector<Pose> turns(const AxisOfSymmetry& axis) {
  const int count = static_cast<int>(std::ceil(std::numbers::pi / kSymmetryStep));
  std::vector<Pose> list;
  for (int i = 0; i < count; ++i) {
    Pose turn = Pose::Identity();
    turn.rotate(Eigen::AngleAxisd(2.0 * std::numbers::pi * i / count, axis.n_O));
    turn.translation() = axis.p_O - turn.linear() * axis.p_O;
    list.push_back(turn);
  }
  return list;
}

/// The smallest over the symmetries of the largest over the points of `distance(p_C, p_C_true)`. A symmetry
/// is left as soon as it is worse than the best.
template <class Distance>
double min_of_max_distances(const std::vector<Eigen::Vector3d>& points, const ScoredObject& object,
                            const Pose& T_C_O, const Pose& T_C_O_true, const Distance& distance) {
  require(!object.symmetries.empty(), "the symmetries of the object are unknown");
  double best = std::numeric_limits<double>::infinity();
  for (const Pose& symmetry : object.symmetries) {
    const Pose T_C_O_same = T_C_O_true * symmetry;
    double max = 0.0;
    for (const Eigen::Vector3d& p_O : points) {
      max = std::max(max, distance(T_C_O * p_O, T_C_O_same * p_O));
      if (max >= best) break;
    }
    best = std::min(best, max);
  }
  return best;
}

}  // namespace

std::vector<Pose> symmetries(const std::vector<Pose>& discrete, const std::vector<AxisOfSymmetry>& axes) {
  std::vector<Pose> all{Pose::Identity()};
  all.insert(all.end(), discrete.begin(), discrete.end());
  if (axes.empty()) return all;
  std::vector<Pose> turned;
  for (const AxisOfSymmetry& axis : axes)
    for (const Pose& turn : turns(axis))
      for (const Pose& symmetry : all) turned.push_back(turn * symmetry);
  return turned;
}

ScoredObject make_scored_object(const Mesh& mesh, std::optional<std::vector<Pose>> symmetries,
                                std::optional<double> diameter) {
  ScoredObject object;
  object.mesh = mesh;
  object.hull = convex_hull(mesh).vertices;
  object.diameter = diameter ? *diameter : max_distance(object.hull);
  if (symmetries) object.symmetries = std::move(*symmetries);
  return object;
}

double mssd(const ScoredObject& object, const Pose& T_C_O, const Pose& T_C_O_true) {
  // The distance is a convex function of the point: it is largest at a vertex of the hull.
  return min_of_max_distances(
      object.hull, object, T_C_O, T_C_O_true,
      [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return (a - b).norm(); });
}

double mspd(const ScoredObject& object, const Pose& T_C_O, const Pose& T_C_O_true,
            const CameraIntrinsics& camera) {
  return min_of_max_distances(object.mesh.vertices, object, T_C_O, T_C_O_true,
                              [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
                                if (a.z() <= 0.0 || b.z() <= 0.0)
                                  return std::numeric_limits<double>::infinity();
                                return (project(camera, a) - project(camera, b)).norm();
                              });
}

double add_s(const ScoredObject& object, const Pose& T_C_O, const Pose& T_C_O_true) {
  const auto& points = object.mesh.vertices;
  require(!points.empty(), "the object has no points");
  const Pose T_true_O = T_C_O_true.inverse() * T_C_O;
  const std::size_t stride = 1 + (points.size() - 1) / kNearestPoints;
  double sum = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < points.size(); i += stride) {
    const Eigen::Vector3d p = T_true_O * points[i];
    double nearest = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3d& q : points) nearest = std::min(nearest, (p - q).squaredNorm());
    sum += std::sqrt(nearest);
    ++count;
  }
  return sum / count;
}

PoseDifference symmetric_difference(const ScoredObject& object, const Pose& T_C_O, const Pose& T_C_O_true) {
  require(!object.symmetries.empty(), "the symmetries of the object are unknown");
  PoseDifference best{0.0, std::numeric_limits<double>::infinity()};
  for (const Pose& symmetry : object.symmetries) {
    const PoseDifference off = difference(T_C_O, T_C_O_true * symmetry);
    if (off.angle < best.angle) best = off;
  }
  return best;
}

}  // namespace stonestack::bench
