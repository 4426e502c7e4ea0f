#include "growth.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdio>

#include "core/quantile.hpp"
#include "stonestack/core/error.hpp"

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

double growth_exponent(const std::vector<CostPoint>& points) {
  double x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
  const auto n = static_cast<double>(points.size());
  for (const CostPoint& point : points) {
    const double u = std::log(point.size), v = std::log(point.cost);
    x += u / n, y += v / n, xx += u * u / n, xy += u * v / n;
  }
  return (xy - x * y) / (xx - x * x);
}

std::string growth_plot(const std::vector<CostPoint>& points, const std::string& of_size,
                        const std::string& of_cost) {
  constexpr double kWidth = 480, kHeight = 320, kLeft = 60, kBottom = 50, kTop = 20, kRight = 20;
  double largest = 1.0, highest = 1e-9;
  for (const CostPoint& point : points) {
    largest = std::max(largest, point.size);
    highest = std::max(highest, point.cost);
  }
  const auto x = [&](double stones) { return kLeft + (kWidth - kLeft - kRight) * stones / largest; };
  const auto y = [&](double seconds) {
    return kHeight - kBottom - (kHeight - kBottom - kTop) * seconds / (1.1 * highest);
  };
  std::string text = concat("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 ", kWidth, ' ', kHeight,
                            "\" font-family=\"sans-serif\" font-size=\"12\">\n"
                            "<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n");
  const auto line = [&](double x1, double y1, double x2, double y2, const char* style) {
    text += concat("<line x1=\"", x1, "\" y1=\"", y1, "\" x2=\"", x2, "\" y2=\"", y2, "\" ", style, "/>\n");
  };
  const auto label = [&](double at_x, double at_y, const char* anchor, const std::string& words) {
    text +=
        concat("<text x=\"", at_x, "\" y=\"", at_y, "\" text-anchor=\"", anchor, "\">", words, "</text>\n");
  };
  line(kLeft, y(0), kWidth - kRight, y(0), "stroke=\"black\"");
  line(kLeft, y(0), kLeft, kTop, "stroke=\"black\"");
  if (!points.empty()) {
    const double slope = points.front().cost / points.front().size;
    const double end = std::min(largest, 1.1 * highest / slope);
    line(x(0), y(0), x(end), y(slope * end), "stroke=\"gray\" stroke-dasharray=\"5 4\"");
  }
  for (std::size_t k = 0; k < points.size(); ++k) {
    const CostPoint& point = points[k];
    if (k > 0)
      line(x(points[k - 1].size), y(points[k - 1].cost), x(point.size), y(point.cost),
           "stroke=\"#1f5fa8\" stroke-width=\"2\"");
    text +=
        concat("<circle cx=\"", x(point.size), "\" cy=\"", y(point.cost), "\" r=\"4\" fill=\"#1f5fa8\"/>\n");
    char cost[32];
    std::snprintf(cost, sizeof cost, "%.3g", point.cost);
    label(x(point.size) - 8, y(point.cost) - 8, "end", cost);
    label(x(point.size), kHeight - kBottom + 18, "middle", concat(point.size));
  }
  label(0.5 * (kLeft + kWidth - kRight), kHeight - 12, "middle", of_size);
  label(kLeft + 6, kTop + 4, "start", of_cost + "; dashed: linear");
  return text + "</svg>\n";
}

}  // namespace stonestack::bench
