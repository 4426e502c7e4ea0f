#include <algorithm>
#include <cmath>
#include <numeric>

#include "stacking/run_memory.hpp"
#include "stonestack/core/error.hpp"

/// A discrete Bayes filter over the frictions that are assumed.
namespace stonestack::stacking {
namespace {

/// Of falls that have nothing to do with friction: a stone released askew, a knock. Design choice; it bounds
/// what a single fall can change.
constexpr double kOtherCauses = 0.25;
/// Standard deviation of the friction of other pairs from a measured one: uniform over +-0.15, as of dry
/// stone (design choice), and 0.04 of the measurement.
constexpr double kPairs = 0.10;

}  // namespace

FrictionEstimate first_estimate(const std::vector<double>& frictions) {
  require(!frictions.empty(), "at least one friction must be assumed");
  FrictionEstimate estimate{frictions, {}};
  const auto count = static_cast<double>(frictions.size());
  for (std::size_t level = 0; level < frictions.size(); ++level)
    estimate.weights.push_back(static_cast<double>(level + 1) / (count * (count + 1) / 2));
  return estimate;
}

bool min_is_likeliest(const FrictionEstimate& estimate) {
  return std::max_element(estimate.weights.begin(), estimate.weights.end()) == estimate.weights.begin();
}

FrictionEstimate update_estimate(FrictionEstimate estimate, const std::vector<double>& success) {
  std::vector<double>& weights = estimate.weights;
  require(success.size() == weights.size(), "one success for each friction, got ", success.size());
  for (std::size_t level = 0; level < weights.size(); ++level)
    weights[level] *= kOtherCauses + (1.0 - kOtherCauses) * (1.0 - std::clamp(success[level], 0.0, 1.0));
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  for (double& weight : weights) weight /= sum;
  return estimate;
}

FrictionEstimate update_by_measurement(FrictionEstimate estimate, double measured) {
  std::vector<double>& weights = estimate.weights;
  const double known = std::clamp(measured, estimate.frictions.front(), estimate.frictions.back());
  for (std::size_t level = 0; level < weights.size(); ++level) {
    const double off = (estimate.frictions[level] - known) / kPairs;
    weights[level] *= std::exp(-0.5 * off * off);
  }
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  for (double& weight : weights) weight /= sum;
  return estimate;
}

}  // namespace stonestack::stacking
