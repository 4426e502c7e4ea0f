#include "motion/grasp_wrench.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "motion/nonnegative_least_squares.hpp"

namespace stonestack {
namespace {

constexpr int kEdges = 6;           ///< of a friction pyramid
constexpr double kLength = 0.05;    ///< m; makes torques comparable with forces for hand-sized stones
constexpr double kResidual = 0.02;  ///< share of the load that may stay unbalanced
constexpr double kRegularise = 1e-5;
constexpr double kGripWeight = 1e-4;  ///< of the grip force against the unbalanced load, squared

/// Columns: forces along the edges of the three friction pyramids. Rows: force, torque / kLength.
Eigen::MatrixXd wrench_columns(const GraspContacts& contacts, double friction) {
  Eigen::MatrixXd G(6, 3 * kEdges);
  for (std::size_t i = 0; i < 3; ++i) {
    const Eigen::Vector3d inward = -contacts.n_T[i];
    const Eigen::Vector3d t1 = inward.unitOrthogonal(), t2 = inward.cross(t1);
    for (int k = 0; k < kEdges; ++k) {
      const double angle = 2 * std::numbers::pi * k / kEdges;
      const Eigen::Vector3d f = inward + friction * (std::cos(angle) * t1 + std::sin(angle) * t2);
      const auto column = static_cast<Eigen::Index>(i) * kEdges + k;
      G.col(column) << f, (contacts.p_T[i] - contacts.p_T_M).cross(f) / kLength;
    }
  }
  return G;
}

/// Larger of finger A's and fingers B and C's push along x.
double closing_force(const Eigen::MatrixXd& G, const Eigen::VectorXd& f) {
  const double a = -G.row(0).head(kEdges).dot(f.head(kEdges));
  const double bc = G.row(0).tail(2 * kEdges).dot(f.tail(2 * kEdges));
  return std::max({a, bc, 0.0});
}

}  // namespace

bool squeeze_holds(const GraspContacts& contacts, double friction) {
  const Eigen::MatrixXd G = wrench_columns(contacts, friction);
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(7, G.cols());
  A.topRows(6) = G;
  A.row(6).head(kEdges) = -G.row(0).head(kEdges);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(7);
  b[6] = 1.0;
  return (A * nonnegative_least_squares(A, b, kRegularise) - b).norm() < kResidual;
}

std::optional<std::array<double, 6>> force_per_weight(const GraspContacts& contacts, double friction) {
  const Eigen::MatrixXd G = wrench_columns(contacts, friction);
  // All forces push, so the square of their sum along x is a weight on the grip force itself.
  Eigen::MatrixXd A(7, G.cols());
  A.topRows(6) = G;
  A.row(6) = std::sqrt(kGripWeight) * G.row(0).cwiseAbs();
  Eigen::VectorXd b = Eigen::VectorXd::Zero(7);
  std::array<double, 6> force{};
  for (std::size_t d = 0; d < 6; ++d) {
    Eigen::VectorXd load = Eigen::VectorXd::Zero(6);
    load[static_cast<Eigen::Index>(d / 2)] = d % 2 == 0 ? -1.0 : 1.0;  // balances a pull along that direction
    b.head(6) = load;
    const Eigen::VectorXd f = nonnegative_least_squares(A, b, kRegularise * kRegularise);
    if ((G * f - load).norm() > kResidual) return std::nullopt;
    force[d] = closing_force(G, f);
  }
  return force;
}

}  // namespace stonestack
