#include "kinematics/hand_eye_methods.hpp"

#include <Eigen/QR>
#include <Eigen/SVD>
#include <cmath>

namespace stonestack::kinematics {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Vector8d = Eigen::Matrix<double, 8, 1>;

Matrix3d cross_matrix(const Vector3d& v) {
  Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// The translation that fits a rotation best: (R_A - I) t = R_X t_B - t_A over all motions.
Vector3d translation_for(std::span<const HandEyeMotion> motions, const Matrix3d& R_X) {
  Eigen::MatrixXd rows(3 * static_cast<Index>(motions.size()), 3);
  Eigen::VectorXd right(rows.rows());
  for (Index k = 0; k < static_cast<Index>(motions.size()); ++k) {
    const HandEyeMotion& m = motions[static_cast<std::size_t>(k)];
    rows.middleRows<3>(3 * k) = m.A.linear() - Matrix3d::Identity();
    right.segment<3>(3 * k) = R_X * m.B.translation() - m.A.translation();
  }
  return rows.colPivHouseholderQr().solve(right);
}

Pose pose_of(const Matrix3d& R, const Vector3d& t) {
  return make_pose(t, Eigen::Quaterniond(R));
}

/// A unit dual quaternion: rotation, and half the translation times it; scalar part not negative.
struct DualQuaternion {
  Eigen::Quaterniond real, dual;
};

DualQuaternion dual_quaternion(const Pose& T) {
  Eigen::Quaterniond q(T.linear());
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const Vector3d& t = T.translation();
  Eigen::Quaterniond half = Eigen::Quaterniond(0, t.x(), t.y(), t.z()) * q;
  half.coeffs() *= 0.5;
  return {q, half};
}

/// Of all combinations of the two null vectors, the one that is a unit dual quaternion (scalar first).
Vector8d unit_combination(const Vector8d& a, const Vector8d& b) {
  const auto real = [](const Vector8d& v) { return v.head<4>(); };
  const auto dual = [](const Vector8d& v) { return v.tail<4>(); };
  const double square = real(a).dot(dual(a)), mixed = real(a).dot(dual(b)) + real(b).dot(dual(a)),
               last = real(b).dot(dual(b));
  std::vector<Vector8d> candidates;
  if (std::abs(square) < 1e-14) {
    candidates = {a, std::abs(mixed) > 1e-14 ? Vector8d(-last / mixed * a + b) : b};
  } else {
    const double root = std::sqrt(std::max(0.0, mixed * mixed - 4.0 * square * last));
    for (const double sign : {-1.0, 1.0})
      candidates.emplace_back((-mixed + sign * root) / (2.0 * square) * a + b);
  }
  const Vector8d& best =
      real(candidates[0]).norm() > real(candidates[1]).norm() ? candidates[0] : candidates[1];
  return best / real(best).norm();
}

}  // namespace

Pose solve_tsai_lenz(std::span<const HandEyeMotion> motions) {
  Eigen::MatrixXd rows(3 * static_cast<Index>(motions.size()), 3);
  Eigen::VectorXd right(rows.rows());
  const auto modified = [](const Pose& T) -> Vector3d {  // 2 sin(angle / 2) times the axis
    const Eigen::AngleAxisd turn(T.linear());
    return 2.0 * std::sin(0.5 * turn.angle()) * turn.axis();
  };
  for (Index k = 0; k < static_cast<Index>(motions.size()); ++k) {
    const HandEyeMotion& m = motions[static_cast<std::size_t>(k)];
    const Vector3d a = modified(m.A), b = modified(m.B);
    rows.middleRows<3>(3 * k) = cross_matrix(a + b);
    right.segment<3>(3 * k) = b - a;
  }
  const Vector3d gibbs = rows.colPivHouseholderQr().solve(right);  // tan(angle / 2) times the axis of X
  const Eigen::Quaterniond q(1.0, gibbs.x(), gibbs.y(), gibbs.z());
  const Matrix3d R_X = q.normalized().toRotationMatrix();
  return pose_of(R_X, translation_for(motions, R_X));
}

Pose solve_park_martin(std::span<const HandEyeMotion> motions) {
  const auto logarithm = [](const Pose& T) -> Vector3d {
    const Eigen::AngleAxisd turn(T.linear());
    return turn.angle() * turn.axis();
  };
  Matrix3d sum = Matrix3d::Zero();
  for (const HandEyeMotion& m : motions) sum += logarithm(m.A) * logarithm(m.B).transpose();
  const Eigen::JacobiSVD<Matrix3d> svd(sum, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double handed = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1.0 : 1.0;
  const Matrix3d R_X = svd.matrixU() * Vector3d(1.0, 1.0, handed).asDiagonal() * svd.matrixV().transpose();
  return pose_of(R_X, translation_for(motions, R_X));
}

Pose solve_daniilidis(std::span<const HandEyeMotion> motions) {
  Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(6 * static_cast<Index>(motions.size()), 8);
  for (Index k = 0; k < static_cast<Index>(motions.size()); ++k) {
    const HandEyeMotion& m = motions[static_cast<std::size_t>(k)];
    const DualQuaternion a = dual_quaternion(m.A), b = dual_quaternion(m.B);
    auto block = rows.middleRows<6>(6 * k);
    for (const Index at : {Index{0}, Index{4}}) {  // the real part stands twice
      const Index row = at == 0 ? 0 : 3;
      block.block<3, 1>(row, at) = a.real.vec() - b.real.vec();
      block.block<3, 3>(row, at + 1) = cross_matrix(a.real.vec() + b.real.vec());
    }
    block.block<3, 1>(3, 0) = a.dual.vec() - b.dual.vec();
    block.block<3, 3>(3, 1) = cross_matrix(a.dual.vec() + b.dual.vec());
  }
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(rows, Eigen::ComputeThinU | Eigen::ComputeFullV);
  const Vector8d x = unit_combination(svd.matrixV().col(6), svd.matrixV().col(7));
  const Eigen::Quaterniond real(x(0), x(1), x(2), x(3)), dual(x(4), x(5), x(6), x(7));
  return make_pose(2.0 * (dual * real.conjugate()).vec(), real);
}

}  // namespace stonestack::kinematics
