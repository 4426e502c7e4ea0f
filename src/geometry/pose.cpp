#include "stonestack/geometry/pose.hpp"

#include <array>
#include <charconv>
#include <cmath>

#include "stonestack/core/error.hpp"

namespace stonestack::geometry {
namespace {

/// Shortest text that reads back to the same number; -0 is written as 0.
std::string number_text(double value) {
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value + 0.0);
  return {text.data(), end.ptr};
}

}  // namespace

PoseDifference difference(const Pose& a, const Pose& b) {
  const Eigen::Quaterniond q_a(a.linear());
  const Eigen::Quaterniond q_b(b.linear());
  return {(a.translation() - b.translation()).norm(), q_a.normalized().angularDistance(q_b.normalized())};
}

Pose make_pose(const Eigen::Vector3d& translation, const Eigen::Quaterniond& rotation) {
  const double length = rotation.norm();
  require(length >= 1e-6 && std::isfinite(length), "a rotation needs a quaternion of length above 1e-6, got ",
          length);
  Pose pose = Pose::Identity();
  pose.translation() = translation;
  pose.linear() = rotation.normalized().toRotationMatrix();
  return pose;
}

Pose make_pose(const Eigen::Vector3d& translation) {
  Pose pose = Pose::Identity();
  pose.translation() = translation;
  return pose;
}

Pose interpolate(const Pose& a, const Pose& b, double s) {
  require(s >= 0.0 && s <= 1.0, "interpolation needs s in [0, 1], got ", s);
  const Eigen::Quaterniond q_a(a.linear());
  const Eigen::Quaterniond q_b(b.linear());
  return make_pose((1.0 - s) * a.translation() + s * b.translation(), q_a.slerp(s, q_b));
}

Pose orthonormal(const Pose& pose) {
  return make_pose(pose.translation(), Eigen::Quaterniond(pose.linear()));
}

bool is_valid(const Pose& pose) {
  if (!pose.matrix().allFinite()) return false;
  const Eigen::Matrix3d rotation = pose.linear();
  const Eigen::Matrix3d excess = rotation * rotation.transpose() - Eigen::Matrix3d::Identity();
  return excess.cwiseAbs().maxCoeff() < 1e-6 && std::abs(rotation.determinant() - 1.0) < 1e-6;
}

std::string to_text(const Pose& pose) {
  const Eigen::Vector3d p = pose.translation();
  Eigen::Quaterniond q(pose.linear());
  q.normalize();
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  return "{x: " + number_text(p.x()) + ", y: " + number_text(p.y()) + ", z: " + number_text(p.z()) +
         ", qx: " + number_text(q.x()) + ", qy: " + number_text(q.y()) + ", qz: " + number_text(q.z()) +
         ", qw: " + number_text(q.w()) + "}";
}

}  // namespace stonestack::geometry
