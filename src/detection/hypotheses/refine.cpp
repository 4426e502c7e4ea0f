#include "detection/hypotheses/refine.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace stonestack::detection {
namespace {

constexpr int kRefineFewest = 20;  // correspondences: fewer do not hold six degrees of freedom
constexpr double kRoom = 0.03;  // m, and share of a model's radius, by which the next pose may lie elsewhere
constexpr double kRoomShare = 0.3;

/// One linearised step in O: rotation and translation of the seen points onto the model.
struct Normal {
  Eigen::Matrix<double, 6, 6> H = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> g = Eigen::Matrix<double, 6, 1>::Zero();
  int count = 0;
  double squares = 0.0, weights = 0.0;
};

Normal accumulate(const DetectionModel& model, const Pose& T_O_C, const SurfacePoints& seen,
                  std::span<const int> indices, double gate, double robust, double min_cosine) {
  Normal sum;
  const Eigen::Isometry3f T = T_O_C.cast<float>();
  const Eigen::Vector3f centre = model.centre.cast<float>();
  const auto inverse = static_cast<float>(1.0 / (robust * robust));
  Eigen::Vector3f s, n;
  using Padded = Eigen::Matrix<float, 8, 1>;  // six and two zeros: whole vector registers
  std::array<Padded, 6> columns;              // of H
  columns.fill(Padded::Zero());
  Padded J = Padded::Zero(), g = Padded::Zero();
  for (const int i : indices) {
    const Eigen::Vector3f q = T * seen.points[static_cast<std::size_t>(i)];
    const int k = model.field.nearest(q);
    if (k < 0) continue;
    const ModelSample& near = model.samples[static_cast<std::size_t>(k)];
    s = near.p;
    n = near.n;
    if ((q - s).squaredNorm() > static_cast<float>(gate * gate)) continue;
    if (n.dot(T.linear() * seen.normals[static_cast<std::size_t>(i)]) < static_cast<float>(min_cosine))
      continue;
    const float r = n.dot(q - s);
    const float of_model = 2.0F * near.sigma;
    const float w = 1.0F / (1.0F + (r * r + of_model * of_model) * inverse);
    J.head<3>() = n;
    J.segment<3>(3) = (q - centre).cross(n);
    for (std::size_t c = 0; c < columns.size(); ++c) columns[c] += (w * J[static_cast<Eigen::Index>(c)]) * J;
    g += (w * r) * J;
    ++sum.count;
    sum.squares += w * r * r;
    sum.weights += w;
  }
  for (std::size_t c = 0; c < columns.size(); ++c)
    sum.H.col(static_cast<Eigen::Index>(c)) = columns[c].head<6>().cast<double>();
  sum.H = Eigen::Matrix<double, 6, 6>(sum.H.selfadjointView<Eigen::Lower>());
  sum.g = g.head<6>().cast<double>();
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

}  // namespace

Refined refine_pose(const DetectionModel& model, const Pose& T_C_O, const SurfacePoints& seen,
                    std::span<const int> indices, const RefineOptions& options) {
  Refined out{T_C_O};
  Pose T_O_C = T_C_O.inverse();
  for (int turn = 0; turn < options.iterations; ++turn) {
    const double s = options.iterations > 1 ? static_cast<double>(turn) / (options.iterations - 1) : 1.0;
    const double gate = options.gate_first * std::pow(options.gate_last / options.gate_first, s);
    const double robust = std::max(options.robust, gate / 5.0);
    const Normal sum =
        accumulate(model, T_O_C, seen, indices, gate, robust, s < 0.5 ? 0.0 : options.min_cosine);
    out.correspondences = sum.count;
    if (sum.count < kRefineFewest) break;
    out.rms = std::sqrt(sum.squares / std::max(sum.weights, 1e-9));
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

namespace {

std::vector<int> evenly_thinned(std::vector<int> all, int max) {
  const auto count = static_cast<int>(all.size());
  if (count <= max) return all;
  for (int i = 0; i < max; ++i)
    all[static_cast<std::size_t>(i)] = all[static_cast<std::size_t>(static_cast<long>(i) * count / max)];
  all.resize(static_cast<std::size_t>(max));
  return all;
}

}  // namespace

std::vector<int> points_near(const DetectionModel& model, const Pose& T_C_O, const SurfacePoints& seen,
                             double margin, int max) {
  std::vector<int> all;
  const Eigen::Vector3f centre = (T_C_O * model.centre).cast<float>();
  const auto radius = static_cast<float>(model.radius + margin);
  for (std::size_t i = 0; i < seen.points.size(); ++i)
    if ((seen.points[i] - centre).squaredNorm() < radius * radius) all.push_back(static_cast<int>(i));
  return evenly_thinned(std::move(all), max);
}

std::vector<int> points_near(const DetectionModel& model, const Pose& T_C_O, const SurfacePoints& seen,
                             double margin, int max, std::span<const int> among) {
  std::vector<int> all;
  const Eigen::Vector3f centre = (T_C_O * model.centre).cast<float>();
  const auto radius = static_cast<float>(model.radius + margin);
  for (const int i : among)
    if ((seen.points[static_cast<std::size_t>(i)] - centre).squaredNorm() < radius * radius) all.push_back(i);
  return evenly_thinned(std::move(all), max);
}

const std::vector<int>& PointsAround::of(const Pose& T_C_O, double margin) {
  const Eigen::Vector3d centre = T_C_O * model_.centre;
  const double needed = (centre - centre_).norm() + model_.radius + margin;
  if (needed <= radius_) return points_;
  centre_ = centre;
  radius_ = model_.radius + margin + kRoom + kRoomShare * model_.radius;
  points_ = points_near(model_, T_C_O, seen_, radius_ - model_.radius, std::numeric_limits<int>::max());
  return points_;
}

}  // namespace stonestack::detection
