#include "detection/scene/depth_error.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "detection/constants.hpp"
#include "stonestack/detection/detect_stones.hpp"

namespace stonestack::detection {
namespace {

constexpr int kClear = 4;              // px: so far around a pixel of bare table, there is table
constexpr double kFullShare = 0.5;     // of a cell's pixels: enough to speak of its mean
constexpr int kLags = 9;               // cells
constexpr double kFewestPairs = 60.0;  // at lag 1
constexpr std::array<double, 7> kLengths = {9, 13, 19, 28, 40, 57, 80};  // px

double matern(double distance, double length) {
  const double x = std::sqrt(3.0) * distance / length;
  return (1.0 + x) * std::exp(-x);
}

/// Measured minus flat depth of every pixel of bare table; NaN elsewhere.
std::vector<float> deviations(const DepthImage& depth, const Plane& table_V, double tolerance) {
  std::vector<float> off(depth.z.size(), std::numeric_limits<float>::quiet_NaN());
  const CameraIntrinsics& camera = depth.camera;
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      const double z = depth.at(u, v);
      if (z <= 0) continue;
      const Eigen::Vector3d ray = deproject(camera, u, v);
      const double slope = table_V.normal.dot(ray), distance = z * slope - table_V.offset;
      if (std::abs(distance) < tolerance && slope < -0.1)
        off[static_cast<std::size_t>(v * camera.width + u)] = static_cast<float>(distance / slope);
    }
  return off;
}

void fill_cells(DepthError& error, const CameraIntrinsics& camera, const std::vector<float>& off) {
  const auto at = [&](int u, int v) { return off[static_cast<std::size_t>(v * camera.width + u)]; };
  std::vector<double> sum(error.offset.size(), 0.0);
  for (int v = kClear; v < camera.height - kClear; ++v)
    for (int u = kClear; u < camera.width - kClear; ++u) {
      const float here = at(u, v);
      if (!std::isfinite(here + at(u - kClear, v) + at(u + kClear, v) + at(u, v - kClear) +
                         at(u, v + kClear)))
        continue;
      const auto cell = static_cast<std::size_t>(error.cell_at(u, v));
      sum[cell] += here;
      ++error.count[cell];
    }
  for (std::size_t i = 0; i < sum.size(); ++i)
    if (error.count[i] > 0) error.offset[i] = static_cast<float>(sum[i] / error.count[i]);
}

/// Mean product of the offsets of full cells that are `lag` apart along a row or a column, and how many.
struct Lag {
  double covariance = 0.0, pairs = 0.0;
};

std::array<Lag, kLags> autocovariance(const DepthError& error) {
  const double full = kFullShare * error.cell * error.cell;
  std::array<Lag, kLags> lags{};
  const auto add = [&](int column, int row, int other_column, int other_row, Lag& lag) {
    if (other_column >= error.columns || other_row >= error.rows) return;
    const auto a = static_cast<std::size_t>(row * error.columns + column);
    const auto b = static_cast<std::size_t>(other_row * error.columns + other_column);
    if (error.count[a] < full || error.count[b] < full) return;
    lag.covariance += static_cast<double>(error.offset[a]) * error.offset[b];
    ++lag.pairs;
  };
  for (int row = 0; row < error.rows; ++row)
    for (int column = 0; column < error.columns; ++column)
      for (int k = 0; k < kLags; ++k) {
        add(column, row, column + k, row, lags[static_cast<std::size_t>(k)]);
        if (k > 0) add(column, row, column, row + k, lags[static_cast<std::size_t>(k)]);
      }
  for (auto& lag : lags) lag.covariance /= std::max(1.0, lag.pairs);
  return lags;
}

/// Sets deviation, reach and noise so that the covariance fits best from lag 1 on; the rest is noise.
void fit_covariance(DepthError& error, const std::array<Lag, kLags>& lags) {
  double best = std::numeric_limits<double>::max();
  for (const double length : kLengths) {
    double mm = 0, mc = 0, cc = 0;
    for (int k = 1; k < kLags; ++k) {
      const Lag& lag = lags[static_cast<std::size_t>(k)];
      const double m = matern(k * error.cell, length);
      mm += lag.pairs * m * m, mc += lag.pairs * m * lag.covariance;
      cc += lag.pairs * lag.covariance * lag.covariance;
    }
    const double variance = std::clamp(mc / mm, 0.0, lags[0].covariance);
    const double misfit = cc - 2.0 * variance * mc + variance * variance * mm;
    if (misfit < best) best = misfit, error.length = length, error.sigma = std::sqrt(variance);
  }
  const double rest = lags[0].covariance - error.sigma * error.sigma;
  error.pixel_noise = error.cell * std::sqrt(std::max(rest, 0.02 * lags[0].covariance));
}

}  // namespace

int DepthError::cell_at(double u, double v) const {
  const int column = std::clamp(static_cast<int>(u) / cell, 0, columns - 1);
  const int row = std::clamp(static_cast<int>(v) / cell, 0, rows - 1);
  return row * columns + column;
}

double DepthError::covariance(double distance) const {
  return sigma * sigma * matern(distance, length);
}

DepthError assumed_depth_error(const CameraIntrinsics& camera, const DetectionOptions& options) {
  DepthError error;
  error.columns = (camera.width + error.cell - 1) / error.cell;
  error.rows = (camera.height + error.cell - 1) / error.cell;
  const auto cells = static_cast<std::size_t>(error.columns) * static_cast<std::size_t>(error.rows);
  error.offset.assign(cells, 0.0F);
  error.count.assign(cells, 0);
  error.sigma = options.bias_sigma;
  error.length = kBiasLength;
  return error;
}

DepthError measure_depth_error(const DepthImage& depth, const Plane& table_V,
                               const DetectionOptions& options) {
  DepthError error = assumed_depth_error(depth.camera, options);
  fill_cells(error, depth.camera, deviations(depth, table_V, kTableTolerance));
  const auto lags = autocovariance(error);
  if (lags[1].pairs >= kFewestPairs && lags[0].covariance > 0) fit_covariance(error, lags);
  return error;
}

}  // namespace stonestack::detection
