#include "stonestack/kinematics/hand_eye.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "kinematics/constants.hpp"
#include "kinematics/hand_eye_methods.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::kinematics {
namespace {

using Eigen::Vector3d;
using Stations = std::vector<HandEyePair>;
using Vector12d = Eigen::Matrix<double, 12, 1>;
using Matrix12d = Eigen::Matrix<double, 12, 12>;

constexpr double kMaxTurn = 3.0;    // rad, of a motion: near 180 deg the axis' sign is a matter of noise
constexpr int kHandEyeRounds = 40;  // of the joint refinement; it ends after 5 to 10
constexpr double kStep = 1e-6;      // of the difference quotients

/// Stations as if the camera were on the gripper: with kOnBase, the base moves about in the flange's frame.
Stations on_hand(std::span<const HandEyePair> pairs, CameraMount mount) {
  Stations out(pairs.begin(), pairs.end());
  if (mount == CameraMount::kOnBase)
    for (auto& p : out) p.T_R_F = p.T_R_F.inverse();
  return out;
}

Vector3d logarithm(const Eigen::Matrix3d& R) {
  const Eigen::AngleAxisd turn(R);
  return turn.angle() * turn.axis();
}

std::vector<HandEyeMotion> motions_of(const Stations& stations) {
  std::vector<HandEyeMotion> motions;
  for (std::size_t i = 0; i < stations.size(); ++i)
    for (std::size_t j = i + 1; j < stations.size(); ++j) {
      const HandEyeMotion m{stations[j].T_R_F.inverse() * stations[i].T_R_F,
                            stations[j].T_C_B * stations[i].T_C_B.inverse()};
      const double min = std::min(logarithm(m.A.linear()).norm(), logarithm(m.B.linear()).norm());
      const double max = std::max(logarithm(m.A.linear()).norm(), logarithm(m.B.linear()).norm());
      if (min >= kMinTurn && max <= kMaxTurn) motions.push_back(m);
    }
  return motions;
}

/// How much the axes of the motions differ: 1 for evenly spread ones, 0 if all are parallel.
double spread(const std::vector<HandEyeMotion>& motions) {
  Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
  for (const auto& m : motions) {
    const Vector3d axis = logarithm(m.A.linear()).normalized();
    sum += axis * axis.transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(sum / static_cast<double>(motions.size()));
  return std::min(1.0, 3.0 * solver.eigenvalues()(1));
}

/// Where the target seems to be, from all stations.
Pose mean_target(const Stations& stations, const Pose& T_F_C) {
  Vector3d sum = Vector3d::Zero();
  Eigen::Matrix4d outer = Eigen::Matrix4d::Zero();
  for (const auto& s : stations) {
    const Pose T_R_B = s.T_R_F * T_F_C * s.T_C_B;
    sum += T_R_B.translation();
    const Eigen::Quaterniond q(T_R_B.linear());
    outer += q.coeffs() * q.coeffs().transpose();
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(outer);
  return make_pose(sum / static_cast<double>(stations.size()),
                   Eigen::Quaterniond(Eigen::Vector4d(solver.eigenvectors().col(3))));
}

HandEyeResidual residual_of(const Stations& stations, const Pose& T_F_C) {
  const Pose T_B_R = mean_target(stations, T_F_C).inverse();
  HandEyeResidual sum;
  for (const auto& s : stations) {
    const Pose off = T_B_R * s.T_R_F * T_F_C * s.T_C_B;
    sum.translation += off.translation().squaredNorm();
    sum.rotation += logarithm(off.linear()).squaredNorm();
  }
  const auto count = static_cast<double>(stations.size());
  return {std::sqrt(sum.translation / count), std::sqrt(sum.rotation / count)};
}

/// In standard deviations, translation and rotation together.
double size_of(const HandEyeResidual& r) {
  return std::hypot(r.translation / kStationTranslation, r.rotation / kStationRotation);
}

Pose moved(const Pose& T, const Eigen::Matrix<double, 6, 1>& x) {
  const Vector3d w = x.tail<3>();
  const double angle = w.norm();
  Pose step = make_pose(x.head<3>());
  if (angle > 1e-15) step.rotate(Eigen::AngleAxisd(angle, w / angle));
  return orthonormal(T * step);
}

/// Camera and target pose, improved together.
struct Joint {
  Pose T_F_C, T_R_B;

  [[nodiscard]] Joint stepped(const Vector12d& x) const {
    return {moved(T_F_C, x.head<6>()), moved(T_R_B, x.tail<6>())};
  }
  [[nodiscard]] Eigen::Matrix<double, 6, 1> error(const HandEyePair& s) const {
    const Pose off = T_R_B.inverse() * s.T_R_F * T_F_C * s.T_C_B;
    Eigen::Matrix<double, 6, 1> e;
    e << off.translation() / kStationTranslation, logarithm(off.linear()) / kStationRotation;
    return e;
  }
};

/// Gauss-Newton with Cauchy weights, so that one bad station does not spoil the others.
Pose refine_jointly(const Stations& stations, const Pose& T_F_C) {
  Joint joint{T_F_C, mean_target(stations, T_F_C)};
  for (int round = 0; round < kHandEyeRounds; ++round) {
    Matrix12d H = 1e-9 * Matrix12d::Identity();
    Vector12d g = Vector12d::Zero();
    for (const auto& s : stations) {
      const Eigen::Matrix<double, 6, 1> e = joint.error(s);
      Eigen::Matrix<double, 6, 12> J;
      for (int k = 0; k < 12; ++k) {
        const Vector12d d = kStep * Vector12d::Unit(k);
        J.col(k) = (joint.stepped(d).error(s) - joint.stepped(-d).error(s)) / (2.0 * kStep);
      }
      const double weight = 1.0 / (1.0 + e.squaredNorm() / 25.0);
      H += weight * J.transpose() * J;
      g += weight * J.transpose() * e;
    }
    const Vector12d x = -H.ldlt().solve(g);
    if (!x.allFinite()) break;
    joint = joint.stepped(x);
    if (x.norm() < 1e-10) break;
  }
  return joint.T_F_C;
}

/// Which reading of the stations fits much better than the one that was given; empty if none does.
std::string inverted_reading(const Stations& stations, double as_given) {
  const auto fit = [&](const Stations& other) {
    const auto motions = motions_of(other);
    if (motions.size() < 2) return as_given;
    return size_of(residual_of(other, solve_park_martin(motions)));
  };
  Stations arm = stations, target = stations;
  for (auto& s : arm) s.T_R_F = s.T_R_F.inverse();
  for (auto& s : target) s.T_C_B = s.T_C_B.inverse();
  const double arm_fit = fit(arm), target_fit = fit(target);
  if (std::min(arm_fit, target_fit) * kInvertedRatio > as_given) return {};
  return arm_fit < target_fit ? "the arm's poses look inverted (T_F_R in place of T_R_F), or the camera is "
                                "mounted the other way"
                              : "the target's poses look inverted (T_B_C in place of T_C_B)";
}

}  // namespace

std::string to_text(CameraMount mount) {
  return mount == CameraMount::kOnHand ? "on_hand" : "on_base";
}

HandEyeResult calibrate_hand_eye(std::span<const HandEyePair> pairs, CameraMount mount) {
  require(pairs.size() >= 3, "a hand-eye calibration takes three stations at least, 15 are good, got ",
          pairs.size());
  for (const auto& p : pairs)
    require(is_valid(p.T_R_F) && is_valid(p.T_C_B), "a station is not a pose: ", geometry::to_text(p.T_R_F),
            ", ", geometry::to_text(p.T_C_B));
  const Stations stations = on_hand(pairs, mount);
  const auto motions = motions_of(stations);
  require(motions.size() >= 2, "of ", pairs.size(), " stations no three differ by ", kMinTurn,
          " rad; turn the gripper more between them");
  require(spread(motions) >= kMinSpread, "the gripper turned about one axis only (spread ", spread(motions),
          " of at least ", kMinSpread, "); tilt it two ways");
  HandEyeResult result;
  for (const auto& [name, solve] :
       {std::pair{"tsai_lenz", &solve_tsai_lenz}, std::pair{"park_martin", &solve_park_martin},
        std::pair{"daniilidis", &solve_daniilidis}}) {
    const Pose T_F_C = solve(motions);
    if (is_valid(T_F_C)) result.solutions.push_back({name, T_F_C, residual_of(stations, T_F_C)});
  }
  const auto best = std::min_element(result.solutions.begin(), result.solutions.end(), [&](auto& a, auto& b) {
    return size_of(a.residual) < size_of(b.residual);
  });
  require(best != result.solutions.end(), "no method has a finite result for these stations");
  const Pose joint = refine_jointly(stations, best->T_A_C);
  result.solutions.insert(result.solutions.begin(), {"joint", joint, residual_of(stations, joint)});
  result.warning = inverted_reading(stations, size_of(result.solutions.front().residual));
  return result;
}

HandEyeResidual hand_eye_residual(std::span<const HandEyePair> pairs, CameraMount mount, const Pose& T_A_C) {
  require(!pairs.empty(), "a residual needs stations");
  return residual_of(on_hand(pairs, mount), T_A_C);
}

bool looks_inverted(std::span<const HandEyePair> pairs, CameraMount mount, const Pose& T_A_C) {
  const double given = size_of(hand_eye_residual(pairs, mount, T_A_C));
  return size_of(hand_eye_residual(pairs, mount, T_A_C.inverse())) * kInvertedRatio < given;
}

}  // namespace stonestack::kinematics
