#include "motion/grasp/grasp_wrench.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "motion/grasp/nonnegative_least_squares.hpp"

namespace stonestack::motion {
namespace {

constexpr int kEdges = 6;           ///< of a friction pyramid
constexpr double kLength = 0.05;    ///< makes torques comparable with forces for stones of graspable size [m]
constexpr double kResidual = 0.02;  ///< share of the load that may stay unbalanced
constexpr double kRegularise = 1e-5;
constexpr double kGripWeight = 1e-4;  ///< of the grip force against the unbalanced load, squared

/// Columns: forces along the edges of the friction pyramids. Rows: force, torque / kLength.
Eigen::MatrixXd wrench_columns(const GraspContacts& contacts, double friction) {
  Eigen::MatrixXd G(6, contacts.count * kEdges);
  for (std::size_t i = 0; i < static_cast<std::size_t>(contacts.count); ++i) {
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

/// Larger of finger A's and the others' push along x; the first `of_a` columns are A's.
double closing_force(const Eigen::MatrixXd& G, const Eigen::VectorXd& f, Eigen::Index of_a) {
  const Eigen::Index others = G.cols() - of_a;
  const double a = -G.row(0).head(of_a).dot(f.head(of_a));
  const double bc = G.row(0).tail(others).dot(f.tail(others));
  return std::max({a, bc, 0.0});
}

/// Least closing forces that balance pulls at the centre of mass.
class ClosingForce {
 public:
  ClosingForce(const GraspContacts& contacts, double friction)
      : G_(wrench_columns(contacts, friction)),
        of_a_(Eigen::Index{contacts.on_a} * kEdges),
        problem_(weighted(G_), kRegularise * kRegularise) {}

  /// For a unit pull; empty if no force balances it.
  [[nodiscard]] std::optional<double> least(const Eigen::Vector3d& pull) {
    Eigen::VectorXd b = Eigen::VectorXd::Zero(7);
    b.head(3) = -pull;
    const Eigen::VectorXd f = problem_.solve(b);
    if ((G_ * f - b.head(6)).norm() > kResidual) return std::nullopt;
    return closing_force(G_, f, of_a_);
  }

 private:
  /// All forces push, so the square of their sum along x is a weight on the grip force itself.
  static Eigen::MatrixXd weighted(const Eigen::MatrixXd& G) {
    Eigen::MatrixXd A(7, G.cols());
    A.topRows(6) = G;
    A.row(6) = std::sqrt(kGripWeight) * G.row(0).cwiseAbs();
    return A;
  }

  Eigen::MatrixXd G_;
  Eigen::Index of_a_;
  NonnegativeLeastSquares problem_;
};

}  // namespace

bool squeeze_holds(const GraspContacts& contacts, double friction) {
  const Eigen::MatrixXd G = wrench_columns(contacts, friction);
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(7, G.cols());
  A.topRows(6) = G;
  const Eigen::Index of_a = Eigen::Index{contacts.on_a} * kEdges;
  A.row(6).head(of_a) = -G.row(0).head(of_a);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(7);
  b[6] = 1.0;
  return (A * NonnegativeLeastSquares(A, kRegularise).solve(b) - b).norm() < kResidual;
}

std::optional<std::array<double, 6>> force_per_weight(const GraspContacts& contacts, double friction) {
  ClosingForce closing(contacts, friction);
  std::array<double, 6> force{};
  for (std::size_t d = 0; d < 6; ++d) {
    Eigen::Vector3d pull = Eigen::Vector3d::Zero();
    pull[static_cast<Eigen::Index>(d / 2)] = d % 2 == 0 ? 1.0 : -1.0;
    const auto needed = closing.least(pull);
    if (!needed) return std::nullopt;
    force[d] = *needed;
  }
  return force;
}

GraspContacts contacts_in_T(const Grasp& grasp, const Eigen::Vector3d& p_O_M) {
  const Pose T_T_O = grasp.T_O_T.inverse();
  GraspContacts contacts;
  contacts.p_T_M = T_T_O * p_O_M;
  contacts.count = grasp.contacts;
  contacts.on_a = grasp.on_a;
  for (std::size_t i = 0; i < static_cast<std::size_t>(grasp.contacts); ++i) {
    contacts.p_T[i] = T_T_O * grasp.p_O_contact[i];
    contacts.n_T[i] = T_T_O.linear() * grasp.n_O_contact[i];
  }
  return contacts;
}

double exact_holding_force(const Grasp& grasp, const Eigen::Vector3d& p_O_M, double friction, double weight,
                           const Eigen::Vector3d& n_T_down) {
  const auto needed = ClosingForce(contacts_in_T(grasp, p_O_M), friction).least(n_T_down);
  return needed ? weight * *needed : std::numeric_limits<double>::infinity();
}

}  // namespace stonestack::motion
