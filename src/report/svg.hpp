#pragma once
#include <cmath>

#include "report/text.hpp"

/// Private to report: what its drawings share.
namespace stonestack::report {

/// A step of 1, 2 or 5 times a power of ten that divides `range` into at most `max` parts.
[[nodiscard]] inline double tick(double range, double max = 10) {
  const double power = std::pow(10.0, std::floor(std::log10(range / max)));
  for (const double step : {1.0, 2.0, 5.0})
    if (range / (step * power) <= max) return step * power;
  return 10 * power;
}

}  // namespace stonestack::report
