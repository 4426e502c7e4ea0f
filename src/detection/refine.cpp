#include "detection/refine.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace stonestack {
namespace {

constexpr int kFewest = 20;  // correspondences: fewer do not hold six degrees of freedom

/// One linearised step in O: rotation and translation of the seen points onto the model.
struct Normal {
  Eigen::Matrix<double, 6, 6> H = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> g = Eigen::Matrix<double, 6, 1>::Zero();
  int count = 0;
  double squares = 0.0, weights = 0.0;
};

/// The surface nearest to a point: point and outward normal. False if there is none within the gate.
bool nearest_surface(const RefineTarget& target, const Eigen::Vector3f& q, double gate,
                     Eigen::Vector3f& point, Eigen::Vector3f& normal) {
  if (target.tree != nullptr) {
    const SurfacePoint found = target.tree->nearest({q.x(), q.y(), q.z()}, gate);
    const auto narrow = [](const Eigen::Vector3d& v) {
      return Eigen::Vector3f(static_cast<float>(v.x()), static_cast<float>(v.y()), static_cast<float>(v.z()));
    };
    point = narrow(found.point), normal = narrow(found.normal);
    return found.face >= 0;
  }
  const int k = target.field.nearest(q);
  if (k < 0) return false;
  point = target.surface.points[static_cast<std::size_t>(k)];
  normal = target.surface.normals[static_cast<std::size_t>(k)];
  return (q - point).squaredNorm() <= static_cast<float>(gate * gate);
}

Normal accumulate(const RefineTarget& model, const Pose& T_O_C, const SurfacePoints& seen,
                  std::span<const int> indices, double gate, double robust, double least_cosine) {
  Normal sum;
  const Eigen::Isometry3f T = T_O_C.cast<float>();
  const Eigen::Vector3f centre = model.centre.cast<float>();
  const auto inverse = static_cast<float>(1.0 / (robust * robust));
  Eigen::Vector3f s, n;
  Eigen::Matrix<float, 6, 6> H = Eigen::Matrix<float, 6, 6>::Zero();
  Eigen::Matrix<float, 6, 1> g = Eigen::Matrix<float, 6, 1>::Zero();
  for (const int i : indices) {
    const Eigen::Vector3f q = T * seen.points[static_cast<std::size_t>(i)];
    if (!nearest_surface(model, q, gate, s, n)) continue;
    if (n.dot(T.linear() * seen.normals[static_cast<std::size_t>(i)]) < static_cast<float>(least_cosine))
      continue;
    const float r = n.dot(q - s);
    const float w = 1.0F / (1.0F + r * r * inverse);
    Eigen::Matrix<float, 6, 1> J;
    J.head<3>() = n;  // not by commas: GCC 12 sees a load past the end there
    J.tail<3>() = (q - centre).cross(n);
    H.selfadjointView<Eigen::Lower>().rankUpdate(J, w);
    g += (w * r) * J;
    ++sum.count;
    sum.squares += w * r * r;
    sum.weights += w;
  }
  sum.H = Eigen::Matrix<float, 6, 6>(H.selfadjointView<Eigen::Lower>()).cast<double>();
  sum.g = g.cast<double>();
  return sum;
}

/// The motion exp(x) about `centre`.
Pose motion(const Eigen::Matrix<double, 6, 1>& x, const Eigen::Vector3d& centre) {
  const Eigen::Vector3d w = x.tail<3>();
  const double angle = w.norm();
  Pose T = Pose::Identity();
  if (angle > 1e-12) T.linear() = Eigen::AngleAxisd(angle, w / angle).toRotationMatrix();
  T.translation() = centre - T.linear() * centre + x.head<3>();
  return T;
}

/// From (translation, rotation) about the centre in O, of the seen points, to (translation of the stone's
/// origin, rotation) in C, of the stone. Signs drop out of a quadratic form.
Eigen::Matrix<double, 6, 6> information_C(const Eigen::Matrix<double, 6, 6>& H_O, const Pose& T_C_O,
                                          const Eigen::Vector3d& centre) {
  // A motion (t, w) of the origin moves the centre by t + w x c: columns of the change of variables.
  Eigen::Matrix<double, 6, 6> A = Eigen::Matrix<double, 6, 6>::Zero();
  const Eigen::Matrix3d R = T_C_O.linear().transpose();
  Eigen::Matrix3d cross;
  const Eigen::Vector3d c = T_C_O.linear() * centre;
  cross << 0, -c.z(), c.y(), c.z(), 0, -c.x(), -c.y(), c.x(), 0;
  A.topLeftCorner<3, 3>() = R;
  A.topRightCorner<3, 3>() = -R * cross;
  A.bottomRightCorner<3, 3>() = R;
  return A.transpose() * H_O * A;
}

}  // namespace

Refined refine_pose(const DetectionModel& model, const Pose& T_C_O, const SurfacePoints& seen,
                    std::span<const int> indices, const RefineOptions& options) {
  return refine_pose(RefineTarget{model.surface, model.field, model.centre}, T_C_O, seen, indices, options);
}

Refined refine_pose(const RefineTarget& model, const Pose& T_C_O, const SurfacePoints& seen,
                    std::span<const int> indices, const RefineOptions& options) {
  Refined out{T_C_O};
  Pose T_O_C = T_C_O.inverse();
  for (int turn = 0; turn < options.iterations; ++turn) {
    const double s = options.iterations > 1 ? static_cast<double>(turn) / (options.iterations - 1) : 1.0;
    const double gate = options.gate_first * std::pow(options.gate_last / options.gate_first, s);
    const double robust = std::max(options.robust, gate / 5.0);
    const Normal sum =
        accumulate(model, T_O_C, seen, indices, gate, robust, s < 0.5 ? 0.0 : options.least_cosine);
    out.correspondences = sum.count;
    if (sum.count < kFewest) break;
    out.rms = std::sqrt(sum.squares / std::max(sum.weights, 1e-9));
    out.information = information_C(sum.H, T_O_C.inverse(), model.centre);
    // A little damping (1e-6 of the trace) keeps directions that the view does not fix where they are.
    Eigen::Matrix<double, 6, 6> H = sum.H;
    H.diagonal().head<3>().array() += 1e-4 * sum.H.topLeftCorner<3, 3>().trace();
    H.diagonal().tail<3>().array() += 1e-4 * sum.H.bottomRightCorner<3, 3>().trace();
    const Eigen::Matrix<double, 6, 1> x = -H.ldlt().solve(sum.g);
    if (!x.allFinite()) break;
    T_O_C = orthonormal(motion(x, model.centre) * T_O_C);
    if (s > 0.6 && x.head<3>().norm() < 1e-5 && x.tail<3>().norm() < 1e-4) break;
  }
  out.T_C_O = T_O_C.inverse();
  return out;
}

std::vector<int> points_near(const DetectionModel& model, const Pose& T_C_O, const SurfacePoints& seen,
                             double margin, int most) {
  std::vector<int> all;
  const Eigen::Vector3f centre = (T_C_O * model.centre).cast<float>();
  const auto radius = static_cast<float>(model.radius + margin);
  for (std::size_t i = 0; i < seen.points.size(); ++i)
    if ((seen.points[i] - centre).squaredNorm() < radius * radius) all.push_back(static_cast<int>(i));
  const auto count = static_cast<int>(all.size());
  if (count <= most) return all;
  std::vector<int> some(static_cast<std::size_t>(most));
  for (int i = 0; i < most; ++i)
    some[static_cast<std::size_t>(i)] = all[static_cast<std::size_t>(static_cast<long>(i) * count / most)];
  return some;
}

}  // namespace stonestack
