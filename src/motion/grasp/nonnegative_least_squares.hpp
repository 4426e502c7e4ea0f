#pragma once
#include <Eigen/Core>
#include <vector>

#include "stonestack/core/rooms.hpp"

namespace stonestack::motion {

/// min |A x - b|^2 + regularisation |x|^2 over x >= 0 by active sets (Lawson and Hanson 1974, in the form on
/// normal equations of Bro and de Jong 1997), for several b. For small dense problems; the regularisation
/// makes the answer unique and, where A x = b can be met, nearly the shortest one. Not to be shared between
/// threads.
class NonnegativeLeastSquares {
 public:
  NonnegativeLeastSquares(const Eigen::MatrixXd& A, double regularisation);
  [[nodiscard]] Eigen::VectorXd solve(const Eigen::VectorXd& b);

 private:
  void solve_used(const Eigen::VectorXd& c);

  Eigen::MatrixXd A_, H_, L_;
  Eigen::VectorXd gain_, s_;
  std::vector<Eigen::Index> used_;  ///< columns whose x is not held at 0
};

}  // namespace stonestack::motion
