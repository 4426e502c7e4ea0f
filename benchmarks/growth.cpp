#include "growth.hpp"

#include <algorithm>
#include <cstddef>

#include "core/quantile.hpp"

namespace stonestack::bench {

namespace {
constexpr std::size_t kMinWarmUp = 5;
}

double median_slope(const std::vector<double>& samples) {
  std::vector<double> slopes;
  for (std::size_t j = 1; j < samples.size(); ++j)
    for (std::size_t i = 0; i < j; ++i)
      slopes.push_back((samples[j] - samples[i]) / static_cast<double>(j - i));
  return slopes.empty() ? 0.0 : quantile(std::move(slopes), 0.5);
}

std::vector<double> after_warm_up(const std::vector<double>& samples) {
  const std::size_t first = std::min(samples.size(), std::max(kMinWarmUp, samples.size() / 4));
  return {samples.begin() + static_cast<std::ptrdiff_t>(first), samples.end()};
}

}  // namespace stonestack::bench
