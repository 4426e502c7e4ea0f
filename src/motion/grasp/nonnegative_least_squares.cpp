#include "motion/grasp/nonnegative_least_squares.hpp"

#include <Eigen/Cholesky>
#include <vector>

namespace stonestack::motion {
namespace {

using Index = Eigen::Index;

/// Least squares over the columns in `used`, zero elsewhere.
Eigen::VectorXd solve_used(const Eigen::MatrixXd& H, const Eigen::VectorXd& c,
                           const std::vector<Index>& used) {
  const auto n = static_cast<Index>(used.size());
  Eigen::MatrixXd h(n, n);
  Eigen::VectorXd r(n);
  for (Index i = 0; i < n; ++i) {
    r[i] = c[used[static_cast<std::size_t>(i)]];
    for (Index j = 0; j < n; ++j)
      h(i, j) = H(used[static_cast<std::size_t>(i)], used[static_cast<std::size_t>(j)]);
  }
  const Eigen::VectorXd s = h.llt().solve(r);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(c.size());
  for (Index i = 0; i < n; ++i) x[used[static_cast<std::size_t>(i)]] = s[i];
  return x;
}

}  // namespace

Eigen::VectorXd nonnegative_least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b,
                                          double regularisation) {
  Eigen::MatrixXd H = A.transpose() * A;
  H.diagonal().array() += regularisation;
  const Eigen::VectorXd c = A.transpose() * b;
  const Index n = c.size();
  const double tolerance = 1e-10 * std::max(1.0, c.cwiseAbs().maxCoeff());
  Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
  std::vector<Index> used;
  for (Index turn = 0; turn < 5 * n; ++turn) {
    const Eigen::VectorXd gain = c - H * x;
    Index enter = -1;
    for (Index i = 0; i < n; ++i)
      if (x[i] == 0.0 && gain[i] > tolerance && (enter < 0 || gain[i] > gain[enter])) enter = i;
    if (enter < 0) break;
    used.push_back(enter);
    Eigen::VectorXd s = solve_used(H, c, used);
    while (!used.empty()) {
      double step = 1.0;  // towards s as far as nothing turns negative
      for (const Index i : used)
        if (s[i] <= 0.0) step = std::min(step, x[i] / (x[i] - s[i]));
      if (step >= 1.0) break;
      x += step * (s - x);
      std::erase_if(used, [&](Index i) {
        const bool leaves = s[i] <= 0.0 && x[i] <= 1e-14;
        if (leaves) x[i] = 0.0;
        return leaves;
      });
      s = solve_used(H, c, used);
    }
    x = s;
  }
  return x;
}

}  // namespace stonestack::motion
