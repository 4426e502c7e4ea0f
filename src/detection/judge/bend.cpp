#include "detection/judge/bend.hpp"

namespace stonestack::detection {

void BendTally::add(const Eigen::Vector3d& model, const Eigen::Vector3d& seen, double weight) {
  weight_ += weight;
  products_ += weight * model.dot(seen);
  squares_ += weight * model.squaredNorm();
  model_ += weight * model;
  seen_ += weight * seen;
}

void BendTally::end_view() {
  if (weight_ > 0.0) {
    covariance_ += products_ - model_.dot(seen_) / weight_;
    variance_ += squares_ - model_.squaredNorm() / weight_;
    all_weight_ += weight_;
  }
  weight_ = products_ = squares_ = 0.0;
  model_.setZero(), seen_.setZero();
}

double BendTally::variation() const {
  return all_weight_ > 0.0 ? variance_ / all_weight_ : 0.0;
}

double BendTally::agreement() const {
  return variance_ > 1e-9 * all_weight_ ? covariance_ / variance_ : 1.0;
}

}  // namespace stonestack::detection
