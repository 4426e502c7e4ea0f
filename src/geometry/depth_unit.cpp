#include "geometry/depth_unit.hpp"

#include <algorithm>
#include <cmath>

namespace stonestack::geometry {
namespace {

constexpr double kMaxDepthCounts = 65535.0;
constexpr double kFloatRounding = 2e-7;  // share of a depth: twice that of a float, for depth and unit
constexpr int kMaxShortestGap = 4;       // counts: an image has thousands of depths, and some are neighbours
constexpr double kFinestUnits[] = {1e-5, 2e-5, 5e-5, 1e-4, 2e-4, 5e-4, 1e-3};  // m

bool has_depth(float z) {
  return z > 0.0F && std::isfinite(z);
}

/// Depths of the image, rising, each once.
std::vector<double> distinct_depths(const DepthImage& image) {
  std::vector<double> depths;
  for (const float z : image.z)
    if (has_depth(z)) depths.push_back(static_cast<double>(z));
  std::sort(depths.begin(), depths.end());
  depths.erase(std::unique(depths.begin(), depths.end()), depths.end());
  return depths;
}

/// Gaps between rising depths, the shortest first.
std::vector<double> gaps_between(const std::vector<double>& rising) {
  std::vector<double> gaps;
  for (std::size_t i = 1; i < rising.size(); ++i) gaps.push_back(rising[i] - rising[i - 1]);
  std::sort(gaps.begin(), gaps.end());
  return gaps;
}

/// Mean length of a count over all gaps, of which the shortest has `counts_of_shortest`. Each gap makes the
/// unit precise enough to count the next.
double mean_count(const std::vector<double>& gaps, int counts_of_shortest) {
  double length = 0.0, counts = 0.0, unit = gaps.front() / counts_of_shortest;
  for (const double gap : gaps) {
    length += gap;
    counts += std::round(gap / unit);
    unit = length / counts;
  }
  return unit;
}

/// To six digits: 0.000125 in place of 0.00012500000173.
double rounded_unit(double unit) {
  const double scale = std::pow(10.0, 5.0 - std::floor(std::log10(unit)));
  return std::round(unit * scale) / scale;
}

}  // namespace

bool is_depth_unit(const DepthImage& image, double unit) {
  return std::all_of(image.z.begin(), image.z.end(), [&](float depth) {
    if (!has_depth(depth)) return true;
    const auto z = static_cast<double>(depth);
    const double counts = std::round(z / unit);
    return counts >= 1.0 && counts <= kMaxDepthCounts && std::abs(z - unit * counts) <= kFloatRounding * z;
  });
}

std::optional<double> find_depth_unit(const DepthImage& image) {
  const std::vector<double> depths = distinct_depths(image);
  if (depths.size() < 2) return {};
  const std::vector<double> gaps = gaps_between(depths);
  for (int shortest = 1; shortest <= kMaxShortestGap; ++shortest) {
    const double counts = std::round(depths.back() / mean_count(gaps, shortest));
    if (!(counts >= 1.0 && counts <= kMaxDepthCounts)) return {};
    const double unit = depths.back() / counts;
    for (const double candidate : {rounded_unit(unit), unit})
      if (is_depth_unit(image, candidate)) return candidate;
  }
  return {};
}

double finest_depth_unit(const DepthImage& image) {
  const std::vector<double> depths = distinct_depths(image);
  const double farthest = depths.empty() ? 0.0 : depths.back();
  for (const double unit : kFinestUnits)
    if (farthest <= kMaxDepthCounts * unit) return unit;
  return *std::rbegin(kFinestUnits);
}

}  // namespace stonestack::geometry
