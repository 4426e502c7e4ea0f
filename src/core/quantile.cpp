#include "core/quantile.hpp"

#include <algorithm>
#include <limits>

#include "stonestack/core/error.hpp"

namespace stonestack::core {

double quantile(std::vector<double> values, double share) {
  require(share >= 0.0 && share <= 1.0, "a share must be in [0, 1], got ", share);
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto rank = static_cast<std::size_t>(share * static_cast<double>(values.size()));
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(std::min(rank, values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace stonestack::core
