#include "stacking/friction_belief.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "stonestack/core/error.hpp"

namespace stonestack::stacking {
namespace {

/// Of falls that have nothing to do with friction: a stone let go askew, a knock. Ours; it bounds what a
/// single fall can tell.
constexpr double kOtherCauses = 0.25;

}  // namespace

FrictionBelief::FrictionBelief(std::vector<double> frictions) : frictions_(std::move(frictions)) {
  const auto count = static_cast<double>(frictions_.size());
  for (std::size_t level = 0; level < frictions_.size(); ++level)
    weights_.push_back(static_cast<double>(level + 1) / (count * (count + 1) / 2));
}

bool FrictionBelief::least_is_likeliest() const {
  return std::max_element(weights_.begin(), weights_.end()) == weights_.begin();
}

void FrictionBelief::fell(const std::vector<double>& success) {
  require(success.size() == weights_.size(), "one success for each friction, got ", success.size());
  for (std::size_t level = 0; level < weights_.size(); ++level)
    weights_[level] *= kOtherCauses + (1.0 - kOtherCauses) * (1.0 - std::clamp(success[level], 0.0, 1.0));
  const double sum = std::accumulate(weights_.begin(), weights_.end(), 0.0);
  for (double& weight : weights_) weight /= sum;
}

}  // namespace stonestack::stacking
