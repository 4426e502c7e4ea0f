#include "detection/hypotheses/joint_refine.hpp"

#include <tbb/parallel_for.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "detection/hypotheses/refine.hpp"
#include "detection/hypotheses/stone_system.hpp"
#include "detection/scene/align_views.hpp"

namespace stonestack::detection {
namespace {

constexpr int kJointIterations = 5;
constexpr int kMaxSamples = 2500;      // of a stone, in all views
constexpr double kNearby = 0.006;      // m: points further from a stone are not its own
constexpr double kPriorShift = 0.005;  // m, rad: how right the poses are that come in
constexpr double kPriorTurn = 0.10;
constexpr double kFurthest = 0.020;  // m, rad: a pose that runs away stays as it came
constexpr double kFurthestTurn = 0.25;
constexpr double kStill = 2e-5;  // m, rad: a step below this is the last

using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// One stone and the evidence of each view.
struct Part {
  const DetectionModel& model;
  Pose T_O_C;
  std::vector<StoneInView> views;
};

/// Distance of a point from a model's surface samples; large if far.
float distance(const DetectionModel& model, const Eigen::Vector3f& p_O) {
  const int k = model.field.nearest(p_O);
  if (k < 0) return 1.0F;
  const auto i = static_cast<std::size_t>(k);
  return std::abs(model.surface.normals[i].dot(p_O - model.surface.points[i]));
}

/// The stone that each point of the scene is nearest to, or -1.
std::vector<int> owners(const DetectionScene& scene, const std::vector<Part>& parts) {
  std::vector<int> owner(scene.surface.points.size(), -1);
  std::vector<float> min(owner.size(), static_cast<float>(kNearby));
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const DetectionModel& model = parts[k].model;
    const Eigen::Isometry3f T = parts[k].T_O_C.cast<float>();
    const Eigen::Vector3f centre = model.centre.cast<float>();
    const auto reach = static_cast<float>(model.radius + kNearby);
    for (std::size_t i = 0; i < owner.size(); ++i) {
      const Eigen::Vector3f q = T * scene.surface.points[i];
      if ((q - centre).squaredNorm() > reach * reach) continue;
      const float d = distance(model, q);
      if (d < min[i]) min[i] = d, owner[i] = static_cast<int>(k);
    }
  }
  return owner;
}

void fill_views(std::vector<Part>& parts, const DetectionScene& scene) {
  const std::vector<int> owner = owners(scene, parts);
  std::vector<std::vector<int>> own(parts.size());
  for (std::size_t i = 0; i < owner.size(); ++i)
    if (owner[i] >= 0) own[static_cast<std::size_t>(owner[i])].push_back(static_cast<int>(i));
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t k) {
    const std::size_t count = own[k].size(), max = std::min<std::size_t>(count, kMaxSamples);
    std::vector<std::vector<StoneSample>> samples(scene.views.size());
    for (std::size_t j = 0; j < max; ++j) {
      const auto i = static_cast<std::size_t>(own[k][j * count / max]);
      const auto view = static_cast<std::size_t>(scene.view_of[i]);
      const Eigen::Isometry3f T_V_C = scene.views[view].T_C_V.inverse().cast<float>();
      StoneSample s{T_V_C * scene.surface.points[i], T_V_C.linear() * scene.surface.normals[i]};
      const CameraIntrinsics& camera = scene.views[view].depth.camera;
      const double pixel = s.p_V.z() * s.p_V.z() / (camera.fx * camera.fy);
      s.pixels = std::max(1.0F, static_cast<float>(scene.surface.areas[i] / pixel));
      if (s.p_V.z() > 0) samples[view].push_back(s);
    }
    for (std::size_t v = 0; v < samples.size(); ++v)
      parts[k].views.emplace_back(scene.views[v], std::move(samples[v]));
  });
}

/// The motion exp(x) about `centre`.
Pose motion(const Eigen::VectorXd& x, const Eigen::Vector3d& centre) {
  const Eigen::Vector3d w = x.tail<3>();
  Pose T = Pose::Identity();
  if (w.norm() > 1e-15) T.linear() = Eigen::AngleAxisd(w.norm(), w.normalized()).toRotationMatrix();
  T.translation() = centre - T.linear() * centre + x.head<3>();
  return T;
}

/// All unknowns: six a stone, then six a further view.
LinearSystem joint_system(std::vector<Part>& parts, const std::vector<Pose>& T_C_V,
                          const DetectionScene& scene) {
  const auto stones = static_cast<Eigen::Index>(parts.size()),
             views = static_cast<Eigen::Index>(T_C_V.size());
  const Eigen::Index size = 6 * (stones + views - 1);
  LinearSystem all{Eigen::MatrixXd::Zero(size, size), Eigen::VectorXd::Zero(size), 0};
  std::vector<std::vector<LinearSystem>> evidence(parts.size());
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t k) {
    for (std::size_t v = 0; v < T_C_V.size(); ++v)
      evidence[k].push_back(parts[k].views[v].normal_equations(parts[k].model, parts[k].T_O_C * T_C_V[v]));
  });
  for (Eigen::Index k = 0; k < stones; ++k)
    for (Eigen::Index v = 0; v < views; ++v) {
      const LinearSystem& one = evidence[static_cast<std::size_t>(k)][static_cast<std::size_t>(v)];
      const Eigen::Index s = 6 * k, w = 6 * (stones + v - 1);
      all.H.block<6, 6>(s, s) += one.H.topLeftCorner<6, 6>();
      all.g.segment<6>(s) += one.g.head<6>();
      all.points += one.points;
      if (v == 0) continue;
      all.H.block<6, 6>(s, w) += one.H.topRightCorner<6, 6>();
      all.H.block<6, 6>(w, s) += one.H.bottomLeftCorner<6, 6>();
      all.H.block<6, 6>(w, w) += one.H.bottomRightCorner<6, 6>();
      all.g.segment<6>(w) += one.g.tail<6>();
    }
  for (Eigen::Index v = 1; v < views; ++v) {
    const auto i = static_cast<std::size_t>(v);
    const ViewConstraint held = view_constraint(seen_table(scene), scene.views[i], T_C_V[i]);
    const Eigen::Index w = 6 * (stones + v - 1);
    all.H.block<6, 6>(w, w) += held.H;
    all.g.segment<6>(w) += held.g;
  }
  for (Eigen::Index s = 0; s < 6 * stones; s += 6) {
    all.H.diagonal().segment<3>(s).array() += 1.0 / (kPriorShift * kPriorShift);
    all.H.diagonal().segment<3>(s + 3).array() += 1.0 / (kPriorTurn * kPriorTurn);
  }
  return all;
}

/// Covariance of the gradient that the equations leave out: the error of a stone's model at one place is the
/// same in all views that show the place.
Eigen::MatrixXd shared_model_error(const std::vector<Part>& parts, std::size_t views) {
  const std::size_t stones = parts.size();
  const auto size = static_cast<Eigen::Index>(6 * (stones + views - 1));
  Eigen::MatrixXd half = Eigen::MatrixXd::Zero(size, size);
  for (std::size_t k = 0; k < stones; ++k) {
    std::vector<ModelScores> scores;
    for (const StoneInView& view : parts[k].views) scores.push_back(view.model_scores());
    const auto s = static_cast<Eigen::Index>(6 * k);
    for (std::size_t v = 1; v < views; ++v)
      for (std::size_t w = 0; w < v; ++w) {
        Eigen::Matrix<double, 12, 12> both = Eigen::Matrix<double, 12, 12>::Zero();
        for (const auto& [place, one] : scores[v])
          if (const auto other = scores[w].find(place); other != scores[w].end())
            both += std::sqrt(one.variance * other->second.variance) / (one.points * other->second.points) *
                    one.sum * other->second.sum.transpose();
        const auto a = static_cast<Eigen::Index>(6 * (stones + v - 1));
        half.block<6, 6>(s, s) += both.topLeftCorner<6, 6>();
        half.block<6, 6>(a, s) += both.bottomLeftCorner<6, 6>();
        if (w == 0) continue;  // the first view does not move
        const auto b = static_cast<Eigen::Index>(6 * (stones + w - 1));
        half.block<6, 6>(s, b) += both.topRightCorner<6, 6>();
        half.block<6, 6>(a, b) += both.bottomRightCorner<6, 6>();
      }
  }
  return half + half.transpose();
}

/// From (translation, rotation) of the seen points about the centre, in O, to (translation of the stone's
/// origin, rotation) of the stone, in C.
Matrix6 covariance_C(const Matrix6& P_O, const Pose& T_C_O, const Eigen::Vector3d& centre) {
  const Eigen::Matrix3d R = T_C_O.linear();
  const Eigen::Vector3d c = R * centre;
  Eigen::Matrix3d cross;
  cross << 0, -c.z(), c.y(), c.z(), 0, -c.x(), -c.y(), c.x(), 0;
  Matrix6 B = Matrix6::Zero();  // the origin moves by t + c x w when the centre moves by t
  B.topLeftCorner<3, 3>() = R;
  B.topRightCorner<3, 3>() = cross * R;
  B.bottomRightCorner<3, 3>() = R;
  return B * P_O * B.transpose();
}

/// Covariance of a pose that the evidence does not hold: as far off as a pose may move, along and about each
/// axis.
Matrix6 not_held(const Pose& T_C_O, const Eigen::Vector3d& centre) {
  Matrix6 P_O = Matrix6::Zero();
  P_O.diagonal().head<3>().setConstant(kFurthest * kFurthest);
  P_O.diagonal().tail<3>().setConstant(kFurthestTurn * kFurthestTurn);
  return covariance_C(P_O, T_C_O, centre);
}

}  // namespace

std::vector<Detection> refined_together(std::vector<Detection> found, const DetectionModels::Data& data,
                                        const DetectionScene& scene) {
  if (found.empty() || scene.views.empty()) return found;
  std::vector<Part> parts;
  for (const auto& d : found) parts.push_back({at(data.models, d.stone), d.T_C_O.inverse(), {}});
  fill_views(parts, scene);
  std::vector<Pose> T_C_V;
  for (const auto& view : scene.views) T_C_V.push_back(view.T_C_V);
  LinearSystem system;
  for (int turn = 0; turn < kJointIterations; ++turn) {
    system = joint_system(parts, T_C_V, scene);
    const Eigen::VectorXd x = -system.H.ldlt().solve(system.g);
    if (!x.allFinite()) break;
    const auto stones = static_cast<Eigen::Index>(parts.size());
    for (Eigen::Index k = 0; k < stones; ++k) {
      Part& part = parts[static_cast<std::size_t>(k)];
      for (std::size_t v = 0; v < T_C_V.size(); ++v) {
        Eigen::VectorXd both = Eigen::VectorXd::Zero(12);
        both.head<6>() = x.segment<6>(6 * k);
        if (v > 0) both.tail<6>() = x.segment<6>(6 * (stones + static_cast<Eigen::Index>(v) - 1));
        part.views[v].update_error(both);
      }
      part.T_O_C = orthonormal(motion(x.segment<6>(6 * k), part.model.centre) * part.T_O_C);
    }
    for (std::size_t v = 1; v < T_C_V.size(); ++v)
      T_C_V[v] = orthonormal(T_C_V[v] * motion(x.segment<6>(6 * (stones + static_cast<Eigen::Index>(v) - 1)),
                                               Eigen::Vector3d::Zero()));
    if (x.cwiseAbs().maxCoeff() < kStill) break;
  }
  Eigen::MatrixXd P = system.H.ldlt().solve(Eigen::MatrixXd::Identity(system.H.rows(), system.H.cols()));
  if (T_C_V.size() > 1) P += P * shared_model_error(parts, T_C_V.size()) * P;
  for (std::size_t k = 0; k < found.size(); ++k) {
    const Pose T_C_O = parts[k].T_O_C.inverse();
    const PoseDifference moved = difference(found[k].T_C_O, T_C_O);
    const auto s = static_cast<Eigen::Index>(6 * k);
    const Matrix6 P_O = P.block<6, 6>(s, s);
    if (!is_valid(T_C_O) || moved.translation > kFurthest || moved.angle > kFurthestTurn ||
        !P_O.allFinite()) {
      found[k].covariance = not_held(found[k].T_C_O, parts[k].model.centre);
      continue;
    }
    found[k].T_C_O = T_C_O;
    found[k].covariance = covariance_C(P_O, T_C_O, parts[k].model.centre);
  }
  return found;
}

}  // namespace stonestack::detection
