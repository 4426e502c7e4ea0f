#include "detection/hypotheses/depth_scale.hpp"

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "detection/hypotheses/refine.hpp"

namespace stonestack::detection {
namespace {

constexpr int kIterations = 12;
constexpr int kMaxPoints = 800;        // of a stone
constexpr int kFewestPoints = 150;     // that fit: fewer carry no information
constexpr double kGateFirst = 0.012;   // m, as far as a scale of 1.15 takes the rim of a stone
constexpr double kGateLast = 0.005;    // m
constexpr double kRobust = 0.0015;     // m, residual at which a point counts half
constexpr double kMinCosine = 0.5;     // between seen and model normal
constexpr double kPointSigma = 0.004;  // m: errors of depth and mesh are smooth, neighbours err alike (bench)
constexpr double kNoisySigma = 7.0;    // the same of the image's noise: a D435 rounds edges off (bench: d435)
constexpr double kPriorSigma = 0.15;   // of the scale: units are off by factors, lenses by a few per cent

using Vector7 = Eigen::Matrix<double, 7, 1>;
using Matrix7 = Eigen::Matrix<double, 7, 7>;

/// A stone and its estimate of the logarithm of the scale.
struct Fit {
  Pose T_O_C;
  double shrink = 0.0;  ///< logarithm of what seen points must be multiplied by
  Matrix7 H = Matrix7::Zero();
  Vector7 g = Vector7::Zero();
  int points = 0;
};

void accumulate(Fit& fit, const DetectionModel& model, const DetectionScene& scene,
                const std::vector<int>& points, double gate) {
  fit.H.setZero(), fit.g.setZero(), fit.points = 0;
  const double factor = std::exp(fit.shrink), sigma = std::max(kPointSigma, kNoisySigma * scene.noise);
  for (const int i : points) {
    const auto at = static_cast<std::size_t>(i);
    const Eigen::Vector3d eye = scene.views[static_cast<std::size_t>(scene.view_of[at])].T_C_V.translation();
    const Eigen::Vector3d ray = factor * (scene.surface.points[at].cast<double>() - eye);
    const Eigen::Vector3d q = fit.T_O_C * (eye + ray);
    const int k = model.field.nearest(q.cast<float>());
    if (k < 0) continue;
    const Eigen::Vector3d n = model.surface.normals[static_cast<std::size_t>(k)].cast<double>();
    const Eigen::Vector3d off = q - model.surface.points[static_cast<std::size_t>(k)].cast<double>();
    if (off.norm() > gate) continue;
    if (n.dot(fit.T_O_C.linear() * scene.surface.normals[at].cast<double>()) < kMinCosine) continue;
    const double r = n.dot(off), robust = std::max(kRobust, gate / 4.0);
    Vector7 J;
    J << n, (q - model.centre).cross(n), n.dot(fit.T_O_C.linear() * ray);
    const double of_model = model.sigma.samples[static_cast<std::size_t>(k)];
    const double w =
        1.0 / (1.0 + r * r / (robust * robust)) / (sigma * sigma + kAlikePoints * of_model * of_model);
    fit.H += w * J * J.transpose();
    fit.g += w * r * J;
    ++fit.points;
  }
  fit.H(6, 6) += 1.0 / (kPriorSigma * kPriorSigma);
  fit.g(6) += fit.shrink / (kPriorSigma * kPriorSigma);
  fit.H.diagonal().head<3>().array() += 1e-9 * fit.H.diagonal().head<3>().sum();
  fit.H.diagonal().segment<3>(3).array() += 1e-9 * fit.H.diagonal().segment<3>(3).sum();
}

void step(Fit& fit, const DetectionModel& model) {
  const Vector7 x = -fit.H.ldlt().solve(fit.g);
  if (!x.allFinite()) return;
  const Eigen::Vector3d turn = x.segment<3>(3);
  Pose motion = Pose::Identity();
  if (turn.norm() > 1e-12)
    motion.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
  motion.translation() = model.centre - motion.linear() * model.centre + x.head<3>();
  fit.T_O_C = orthonormal(motion * fit.T_O_C);
  fit.shrink += x(6);
}

Fit fit_stone(const Detection& d, const DetectionModel& model, const DetectionScene& scene) {
  Fit fit;
  fit.T_O_C = d.T_C_O.inverse();
  const auto points = points_near(model, d.T_C_O, scene.surface, kGateFirst, kMaxPoints);
  for (int turn = 0; turn < kIterations; ++turn) {
    const double s = static_cast<double>(turn) / (kIterations - 1);
    accumulate(fit, model, scene, points, kGateFirst * std::pow(kGateLast / kGateFirst, s));
    if (fit.points < kFewestPoints) return {};
    step(fit, model);
  }
  return fit;
}

}  // namespace

DepthScale fit_depth_scale(const std::vector<Detection>& found, const DetectionModels::Data& data,
                           const DetectionScene& scene) {
  std::vector<Fit> fits(found.size());
  tbb::parallel_for(std::size_t{0}, found.size(), [&](std::size_t i) {
    fits[i] = fit_stone(found[i], at(data.models, found[i].stone), scene);
  });
  double sum = 0, weights = 0;
  for (const auto& fit : fits) {
    if (fit.points == 0) continue;
    const double variance = fit.H.ldlt().solve(Vector7::Unit(6))(6);
    sum += fit.shrink / variance, weights += 1.0 / variance;
  }
  if (weights == 0) return {};
  const double factor = std::exp(-sum / weights);
  return {factor, factor / std::sqrt(weights)};
}

}  // namespace stonestack::detection
