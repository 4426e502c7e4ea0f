#pragma once
#include <string>
#include <vector>

#include "rooms.hpp"

namespace stonestack::bench {

/// Median of the slopes between all pairs of samples that follow each other in equal steps (Theil 1950, Sen
/// 1968), a step; single outliers do not move it. 0 for fewer than two samples.
[[nodiscard]] double median_slope(const std::vector<double>& samples);

/// Samples of the end of a long job, without its warm-up: the first quarter, at least five.
[[nodiscard]] std::vector<double> after_warm_up(const std::vector<double>& samples);

/// Cost of a problem of some size.
struct CostPoint {
  double size = 0.0, cost = 0.0;
};
/// Exponent of the cost in the size, by least squares of the logarithms; 1: linear. Not finite for fewer than
/// two sizes.
[[nodiscard]] double growth_exponent(const std::vector<CostPoint>& points);
/// The points and a straight line through the first and the origin, as SVG. `of_size` and `of_cost` say what
/// the axes are of.
[[nodiscard]] std::string growth_plot(const std::vector<CostPoint>& points, const std::string& of_size,
                                      const std::string& of_cost);

}  // namespace stonestack::bench
