#include "motion/grasp/nonnegative_least_squares.hpp"

#include <Eigen/Cholesky>
#include <algorithm>

namespace stonestack::motion {

using Index = Eigen::Index;

NonnegativeLeastSquares::NonnegativeLeastSquares(const Eigen::MatrixXd& A, double regularisation)
    : A_(A), H_(A.transpose() * A), L_(A.cols(), A.cols()), gain_(A.cols()), s_(A.cols()) {
  H_.diagonal().array() += regularisation;
  used_.reserve(static_cast<std::size_t>(A.cols()));
}

/// Least squares over the columns in `used_`, in their order.
void NonnegativeLeastSquares::solve_used(const Eigen::VectorXd& c) {
  const auto n = static_cast<Index>(used_.size());
  for (Index j = 0; j < n; ++j) {
    const Index column = used_[static_cast<std::size_t>(j)];
    s_[j] = c[column];
    for (Index i = j; i < n; ++i) L_(i, j) = H_(used_[static_cast<std::size_t>(i)], column);
  }
  Eigen::Ref<Eigen::MatrixXd> in_place = L_.topLeftCorner(n, n);
  Eigen::VectorBlock<Eigen::VectorXd> s = s_.head(n);
  Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>>(in_place).solveInPlace(s);
}

Eigen::VectorXd NonnegativeLeastSquares::solve(const Eigen::VectorXd& b) {
  const Eigen::VectorXd c = A_.transpose() * b;
  const Index n = c.size();
  const double tolerance = 1e-10 * std::max(1.0, c.cwiseAbs().maxCoeff());
  Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
  used_.clear();
  for (Index turn = 0; turn < 5 * n; ++turn) {
    gain_ = c;
    for (const Index i : used_) gain_ -= x[i] * H_.col(i);
    Index enter = -1;
    for (Index i = 0; i < n; ++i)
      if (x[i] == 0.0 && gain_[i] > tolerance && (enter < 0 || gain_[i] > gain_[enter])) enter = i;
    if (enter < 0) break;
    used_.push_back(enter);
    solve_used(c);
    while (!used_.empty()) {
      double step = 1.0;  // towards s as far as nothing turns negative
      for (std::size_t k = 0; k < used_.size(); ++k)
        if (const double s = s_[static_cast<Index>(k)]; s <= 0.0)
          step = std::min(step, x[used_[k]] / (x[used_[k]] - s));
      if (step >= 1.0) break;
      std::size_t kept = 0;
      for (std::size_t k = 0; k < used_.size(); ++k) {
        const Index i = used_[k];
        const double s = s_[static_cast<Index>(k)];
        x[i] += step * (s - x[i]);
        if (s <= 0.0 && x[i] <= 1e-14)
          x[i] = 0.0;
        else
          used_[kept++] = i;
      }
      used_.resize(kept);
      solve_used(c);
    }
    for (std::size_t k = 0; k < used_.size(); ++k) x[used_[k]] = s_[static_cast<Index>(k)];
  }
  return x;
}

}  // namespace stonestack::motion
