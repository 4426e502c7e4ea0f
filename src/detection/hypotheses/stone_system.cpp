#include "detection/hypotheses/stone_system.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>

namespace stonestack::detection {
namespace {

constexpr double kGate = 0.004;           // m: further off is another surface
constexpr double kSystemRobust = 0.0015;  // m, residual at which a point counts half
constexpr float kSystemMinCosine = 0.6F;  // between seen and model normal
constexpr double kSlantNoise = 1.6;       // variance over that of the table: stone is seen at more of a slant
constexpr double kMeshSigma =
    0.0017;                       // m, of a point: 500 faces are 0.3 mm off, times the root of these points
constexpr int kMaxPatches = 150;  // of the stone itself: more are joined
constexpr int kFurthestRing = 4;  // patches beside the stone
constexpr double kPlaceSize = 0.006;  // m: a place on the model, of about four samples

using Vector12 = Eigen::Matrix<double, 12, 1>;

std::array<int, 3> place_of(const Eigen::Vector3d& p_O) {
  const Eigen::Array3i cell = (p_O.array() / kPlaceSize).floor().cast<int>();
  return {cell.x(), cell.y(), cell.z()};
}

}  // namespace

StoneInView::StoneInView(const SeenView& view, std::vector<StoneSample> samples)
    : samples_(std::move(samples)), noise_(view.error.pixel_noise * view.error.pixel_noise) {
  lay_patches(view);
}

/// The cells under the stone and around it, numbered; several in one patch if a stone fills the image.
void StoneInView::lay_patches(const SeenView& view) {
  const DepthError& error = view.error;
  std::map<int, int> own;  // cells of the stone
  for (auto& s : samples_) {
    const Eigen::Vector2d pixel = project(view.depth.camera, s.p_V.cast<double>());
    own[s.patch = error.cell_at(pixel.x(), pixel.y())] = 0;
  }
  const int join = 1 + static_cast<int>(std::sqrt(static_cast<double>(own.size()) / kMaxPatches));
  const int columns = (error.columns + join - 1) / join, rows = (error.rows + join - 1) / join;
  const auto patch_of = [&](int cell) {
    return cell / error.columns / join * columns + cell % error.columns / join;
  };
  const int ring =
      std::clamp(static_cast<int>(std::ceil(error.length / (error.cell * join))), 1, kFurthestRing);
  std::map<int, int> number;  // of a patch
  for (const auto& [cell, unused] : own) {
    const int patch = patch_of(cell), row = patch / columns, column = patch % columns;
    for (int y = std::max(0, row - ring); y <= std::min(rows - 1, row + ring); ++y)
      for (int x = std::max(0, column - ring); x <= std::min(columns - 1, column + ring); ++x)
        number[y * columns + x] = 0;
  }
  int count = 0;
  std::vector<Eigen::Vector2d> centres;
  for (auto& [patch, k] : number) {
    k = count++;
    centres.emplace_back(join * (patch % columns + 0.5), join * (patch / columns + 0.5));
  }
  table_ = weight_ = error_ = Eigen::VectorXd::Zero(count);
  for (int cell = 0; cell < error.columns * error.rows; ++cell) {
    const auto at = number.find(patch_of(cell));
    const auto i = static_cast<std::size_t>(cell);
    if (at == number.end() || error.count[i] == 0) continue;
    weight_(at->second) += error.count[i];
    table_(at->second) += static_cast<double>(error.count[i]) * error.offset[i];
  }
  for (int k = 0; k < count; ++k)
    if (weight_(k) > 0) table_(k) /= weight_(k), weight_(k) /= noise_;
  prior_.resize(count, count);
  for (int a = 0; a < count; ++a)
    for (int b = 0; b <= a; ++b)
      prior_(a, b) = prior_(b, a) = error.covariance(
          error.cell * (centres[static_cast<std::size_t>(a)] - centres[static_cast<std::size_t>(b)]).norm());
  for (auto& s : samples_) s.patch = number.at(patch_of(s.patch));
}

LinearSystem StoneInView::normal_equations(const DetectionModel& model, const Pose& T_O_V) {
  LinearSystem out{Eigen::MatrixXd::Zero(12, 12), Eigen::VectorXd::Zero(12), 0};
  weighed_.clear();
  if (samples_.empty()) return out;
  const Eigen::Index count = weight_.size();
  Eigen::VectorXd D = weight_;
  gradient_ = -weight_.cwiseProduct(table_);
  cross_ = Eigen::MatrixXd::Zero(count, 12);
  for (auto& s : samples_) {
    const Eigen::Vector3d p_V = s.p_V.cast<double>(), q = T_O_V * p_V;
    const SurfacePoint near = model.tree.nearest(q, 2.0 * kGate, s.face);
    s.face = near.face;
    if (near.face < 0) continue;
    const Eigen::Vector3d n_V = T_O_V.linear().transpose() * near.normal;
    if (n_V.cast<float>().dot(s.normal_V) < kSystemMinCosine) continue;
    const double slope = n_V.dot(p_V) / p_V.z(), r = near.normal.dot(q - near.point);
    const double left = r - slope * error_(s.patch);
    const double sigma =
        sigma_of_face(model.sigma.mesh, model.mesh.faces[static_cast<std::size_t>(near.face)]);
    if (std::abs(left) > widened(kGate, sigma)) continue;
    // Off the surface, not along the ray: what a slant takes off the noise, depth cameras add at a slant.
    const double variance =
        kSlantNoise * noise_ / s.pixels + kMeshSigma * kMeshSigma + kAlikePoints * sigma * sigma;
    const double robust2 = kSystemRobust * kSystemRobust + sigma * sigma;
    const double w = 1.0 / (1.0 + left * left / robust2) / variance;
    Vector12 J;
    J << near.normal, (q - model.centre).cross(near.normal), n_V, p_V.cross(n_V);
    out.H.selfadjointView<Eigen::Lower>().rankUpdate(J, w);
    out.g += (w * r) * J;
    D(s.patch) += w * slope * slope;
    gradient_(s.patch) -= w * slope * r;
    cross_.row(s.patch) -= (w * slope) * J.transpose();
    const double of_model = kMeshSigma * kMeshSigma + kAlikePoints * sigma * sigma;
    weighed_.push_back({w * J, w * slope, of_model, place_of(near.point), s.patch});
    ++out.points;
  }
  out.H = Eigen::MatrixXd(out.H.selfadjointView<Eigen::Lower>());
  // (D + prior^-1)^-1 = prior - prior (prior + D^-1)^-1 prior, without inverting either: D may have zeros.
  const Eigen::VectorXd root = D.cwiseSqrt();
  Eigen::MatrixXd M = root.asDiagonal() * prior_ * root.asDiagonal();
  M.diagonal().array() += 1.0;
  const Eigen::MatrixXd half = root.asDiagonal() * prior_;
  gain_ = prior_ - half.transpose() * M.llt().solve(half);
  out.H -= cross_.transpose() * gain_ * cross_;
  out.g -= cross_.transpose() * (gain_ * gradient_);
  return out;
}

ModelScores StoneInView::model_scores() const {
  ModelScores scores;
  if (weighed_.empty()) return scores;
  const Eigen::MatrixXd through_error = cross_.transpose() * gain_;  // the smooth error takes part of it up
  for (const Weighed& one : weighed_) {
    ModelScore& score = scores[one.place];
    score.sum += one.weighted_J + one.weighted_slope * through_error.col(one.patch);
    score.variance += one.model_variance;
    ++score.points;
  }
  return scores;
}

void StoneInView::update_error(const Eigen::VectorXd& step) {
  if (!samples_.empty()) error_ = -gain_ * (gradient_ + cross_ * step);
}

}  // namespace stonestack::detection
