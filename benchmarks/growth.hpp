#pragma once
#include <vector>

#include "rooms.hpp"

namespace stonestack::bench {

/// Median of the slopes between all pairs of samples that follow each other in equal steps (Theil 1950, Sen
/// 1968), a step; single outliers do not move it. 0 for fewer than two samples.
[[nodiscard]] double median_slope(const std::vector<double>& samples);

/// Samples of the end of a long job, without its warm-up: the first quarter, at least five.
[[nodiscard]] std::vector<double> after_warm_up(const std::vector<double>& samples);

}  // namespace stonestack::bench
