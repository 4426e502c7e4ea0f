#pragma once
#include <Eigen/Core>

#include "stonestack/core/rooms.hpp"

namespace stonestack::motion {

/// min |A x - b|^2 + regularisation |x|^2 over x >= 0 by active sets (Lawson and Hanson 1974, in the form on
/// normal equations of Bro and de Jong 1997). For small dense problems; the regularisation makes the answer
/// unique and, where A x = b can be met, nearly the shortest one.
[[nodiscard]] Eigen::VectorXd nonnegative_least_squares(const Eigen::MatrixXd& A, const Eigen::VectorXd& b,
                                                        double regularisation);

}  // namespace stonestack::motion
