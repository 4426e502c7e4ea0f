#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/quantile.hpp"
#include "detection/scene/fit_plane.hpp"
#include "detection/scene/preprocess.hpp"
#include "detection/segment/object_surface.hpp"
#include "geometry/camera_check.hpp"
#include "geometry/small_motion.hpp"
#include "modelling/camera_error.hpp"
#include "modelling/constants.hpp"
#include "modelling/usable_options.hpp"
#include "modelling/view_normals.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/modelling/model_objects.hpp"

namespace stonestack::modelling {
namespace {

constexpr int kObjectStride = 3;        // px between samples of what stands on the table
constexpr int kTableStride = 12;        // px between those of the table
constexpr double kAboveTable = 0.006;   // m from which on surface stands on the table
constexpr double kHighest = 0.5;        // m above the table: beyond is background
constexpr double kPriorShift = 0.003;   // m by which a reported pose errs, an axis
constexpr double kPriorTurn = 0.006;    // rad likewise
constexpr double kResidual = 0.001;     // m by which two views of one surface differ
constexpr double kShared = 1.0 / 50.0;  // independent samples among those that are taken: errors are smooth
constexpr double kSameNormal = 0.7;     // cosine between the normals of one surface in two views
constexpr int kSteps = 15;
constexpr double kWidestGate = 0.020;     // m between surfaces that are taken for one, at first ...
constexpr double kNarrowestGate = 0.004;  // ... and at the end

struct Sample {
  Eigen::Vector3d p_C, n_C;
  bool on_table = false;
};

struct SampledView {
  DepthImage smooth;
  std::vector<Eigen::Vector3f> normal_C;
  std::vector<Sample> samples;
  Pose T_W_C_reported, T_W_C;
};

SampledView sample(const DepthView& view, const DetectionOptions& options) {
  SampledView out;
  out.smooth = detection::smooth_depth(view.image, options);
  out.normal_C = view_normals(out.smooth);
  out.T_W_C = out.T_W_C_reported = view.T_W_C;
  const auto table_C = detection::find_table(out.smooth, std::nullopt, options);
  const CameraIntrinsics& camera = out.smooth.camera;
  for (int v = 0; v < camera.height; v += kObjectStride)
    for (int u = 0; u < camera.width; u += kObjectStride) {
      const auto i = static_cast<std::size_t>(v * camera.width + u);
      if (!(out.smooth.z[i] > 0) || out.normal_C[i].isZero()) continue;
      const Eigen::Vector3d p_C = out.smooth.z[i] * deproject(camera, u, v);
      const double height = table_C ? table_C->distance(p_C) : kAboveTable;
      const bool on_table = std::abs(height) < kAboveTable;
      if (height < -kAboveTable || height > kHighest) continue;
      if (on_table && (u % kTableStride != 0 || v % kTableStride != 0)) continue;
      out.samples.push_back({p_C, out.normal_C[i].cast<double>(), on_table});
    }
  return out;
}

/// Sum of squares over all views, as a linear system in one small motion of each.
struct System {
  Eigen::MatrixXd H;
  Eigen::VectorXd g;
  std::vector<double> apart;  ///< of what stands on the table [m]
};

/// Surfaces of view a that view b shows, too.
void add_pair(const std::vector<SampledView>& views, std::size_t a, std::size_t b,
              const Eigen::Vector3d& middle, double gate, System& system) {
  const SampledView& from = views[a];
  const SampledView& to = views[b];
  const Pose T_b_a = to.T_W_C.inverse() * from.T_W_C;
  const CameraIntrinsics& camera = to.smooth.camera;
  const auto ia = static_cast<Eigen::Index>(6 * a), ib = static_cast<Eigen::Index>(6 * b);
  for (const Sample& sample : from.samples) {
    const Eigen::Vector3d p_b = T_b_a * sample.p_C;
    if (p_b.z() <= 0.05) continue;
    const Eigen::Vector2d pixel = project(camera, p_b);
    const auto u = std::lround(pixel.x()), v = std::lround(pixel.y());
    if (u < 0 || v < 0 || u >= camera.width || v >= camera.height) continue;
    const auto i = static_cast<std::size_t>(v * camera.width + u);
    if (!(to.smooth.z[i] > 0) || to.normal_C[i].isZero()) continue;
    const Eigen::Vector3d n_b = to.normal_C[i].cast<double>();
    if (n_b.dot(T_b_a.linear() * sample.n_C) < kSameNormal) continue;
    const Eigen::Vector3d q_b =
        to.smooth.z[i] * deproject(camera, static_cast<double>(u), static_cast<double>(v));
    const double off = n_b.dot(p_b - q_b);
    if (std::abs(off) > gate) continue;
    if (!sample.on_table) system.apart.push_back(std::abs(off));
    const double rest = 1.0 - std::pow(off / gate, 2);  // Tukey's biweight
    const double weight = kShared * rest * rest / (kResidual * kResidual);
    const Eigen::Vector3d n_W = to.T_W_C.linear() * n_b;
    Eigen::Matrix<double, 6, 1> J;
    J << n_W, (from.T_W_C * sample.p_C - middle).cross(n_W);
    const Eigen::Matrix<double, 6, 6> JJ = weight * J * J.transpose();
    system.H.block<6, 6>(ia, ia) += JJ;
    system.H.block<6, 6>(ib, ib) += JJ;
    system.H.block<6, 6>(ia, ib) -= JJ;
    system.H.block<6, 6>(ib, ia) -= JJ;
    system.g.segment<6>(ia) += weight * off * J;
    system.g.segment<6>(ib) -= weight * off * J;
  }
}

/// How far the arm's report may be from the truth.
void add_prior(const SampledView& view, std::size_t k, const Eigen::Vector3d& middle, System& system) {
  const Pose off = view.T_W_C * view.T_W_C_reported.inverse();
  Eigen::Matrix<double, 6, 1> x, precision;
  x << off * middle - middle, rotation_vector(off.linear());
  precision << Eigen::Vector3d::Constant(1.0 / (kPriorShift * kPriorShift)),
      Eigen::Vector3d::Constant(1.0 / (kPriorTurn * kPriorTurn));
  const auto at = static_cast<Eigen::Index>(6 * k);
  system.H.diagonal().segment<6>(at) += precision;
  system.g.segment<6>(at) += precision.cwiseProduct(x);
}

System system_of(const std::vector<SampledView>& views, const Eigen::Vector3d& middle, double gate) {
  const auto size = static_cast<Eigen::Index>(6 * views.size());
  const System empty{Eigen::MatrixXd::Zero(size, size), Eigen::VectorXd::Zero(size), {}};
  std::vector<System> parts(views.size(), empty);  // a view each, added in order: threads do not matter
  tbb::parallel_for(std::size_t{0}, views.size(), [&](std::size_t a) {
    for (std::size_t b = 0; b < views.size(); ++b)
      if (b != a) add_pair(views, a, b, middle, gate, parts[a]);
    add_prior(views[a], a, middle, parts[a]);
  });
  System sum = empty;
  for (const System& part : parts) {
    sum.H += part.H;
    sum.g += part.g;
    sum.apart.insert(sum.apart.end(), part.apart.begin(), part.apart.end());
  }
  return sum;
}

double median_apart(const System& system) {
  return system.apart.empty() ? 0.0 : quantile(system.apart, 0.5);
}

Pose about(const Eigen::Vector3d& middle, const Pose& motion) {
  return Eigen::Translation3d(middle) * motion * Eigen::Translation3d(-middle);
}

Eigen::Vector3d middle_of(const std::vector<SampledView>& views) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double count = 0.0;
  for (const SampledView& view : views)
    for (const Sample& sample : view.samples) sum += view.T_W_C * sample.p_C, count += 1.0;
  return count > 0 ? Eigen::Vector3d(sum / count) : sum;
}

/// Moves all views so that the table that they show is z = 0, turned as little as possible.
void level(std::vector<SampledView>& views, const Eigen::Vector3d& middle) {
  std::vector<Eigen::Vector3d> table;
  for (const SampledView& view : views)
    for (const Sample& sample : view.samples)
      if (sample.on_table) table.push_back(view.T_W_C * sample.p_C - middle);
  if (table.size() < 100) return;
  Plane plane = detection::fit_plane(table, {Eigen::Vector3d::UnitZ(), -middle.z()}, 0.02);
  if (plane.normal.z() < 0) plane = {-plane.normal, -plane.offset};
  const auto turn = Eigen::Quaterniond::FromTwoVectors(plane.normal, Eigen::Vector3d::UnitZ());
  const Pose move =
      Eigen::Translation3d(middle.x(), middle.y(), -plane.offset) * turn * Eigen::Translation3d(-middle);
  for (SampledView& view : views) view.T_W_C = move * view.T_W_C;
}

}  // namespace

AlignedScene align_scene(std::span<const DepthView> as_taken, const ModellingOptions& options) {
  require(!as_taken.empty(), "a scene needs a view");
  for (const DepthView& view : as_taken) require_usable(view.image);
  require_usable(options);
  const CameraError camera = measure_camera_error(as_taken, options.segment);
  log_debug(concat("depth error that ", as_taken.size(), " views share: ", 1e3 * camera.sigma, " mm"));
  std::vector<DepthView> views;
  views.reserve(as_taken.size());
  for (const DepthView& view : as_taken) views.push_back({without_error(view.image, camera), view.T_W_C});
  const DetectionOptions detection = detection::detection_options(options.segment);
  std::vector<SampledView> sampled(views.size());
  tbb::parallel_for(std::size_t{0}, views.size(),
                    [&](std::size_t k) { sampled[k] = sample(views[k], detection); });
  const Eigen::Vector3d middle = middle_of(sampled);
  AlignedScene scene;
  scene.apart_before = scene.apart_after = median_apart(system_of(sampled, middle, kWidestGate));
  if (options.refine_poses) {
    for (int step = 0; step < kSteps; ++step) {
      throw_if_interrupted();
      const double gate =
          kWidestGate * std::pow(kNarrowestGate / kWidestGate, static_cast<double>(step) / (kSteps - 1));
      const System system = system_of(sampled, middle, gate);
      const Eigen::VectorXd x = -system.H.ldlt().solve(system.g);
      for (std::size_t k = 0; k < sampled.size(); ++k)
        sampled[k].T_W_C = orthonormal(
            about(middle, small_motion(x.segment<6>(static_cast<Eigen::Index>(6 * k)))) * sampled[k].T_W_C);
    }
    scene.apart_after = median_apart(system_of(sampled, middle, kWidestGate));
    level(sampled, middle);
  }
  for (std::size_t k = 0; k < views.size(); ++k) scene.views.push_back({views[k].image, sampled[k].T_W_C});
  scene.segmentation = detection::segment(scene.views, options.segment);
  return scene;
}

}  // namespace stonestack::modelling
