#include <algorithm>
#include <cmath>

#include "stonestack/core/error.hpp"
#include "stonestack/experiment/experiment.hpp"

namespace stonestack::experiment {
namespace {

double wilson(const Rate& rate, double side) {
  constexpr double z = 1.959964;  // 95 %, two sides
  if (rate.trials == 0) return side > 0 ? 1.0 : 0.0;
  const double n = rate.trials, p = rate.share();
  const double centre = p + z * z / (2 * n);
  const double spread = z * std::sqrt(p * (1 - p) / n + z * z / (4 * n * n));
  return std::clamp((centre + side * spread) / (1 + z * z / n), 0.0, 1.0);
}

bool held(const PlacementRecord& record) {
  return record.outcome == PlacementRecord::Outcome::kPlaced;
}

}  // namespace

double Rate::low() const {
  return wilson(*this, -1.0);
}
double Rate::high() const {
  return wilson(*this, 1.0);
}

bool was_tried(const PlacementRecord& record) {
  return record.outcome != PlacementRecord::Outcome::kNotPicked &&
         record.outcome != PlacementRecord::Outcome::kDropped &&
         record.outcome != PlacementRecord::Outcome::kUnstacked &&
         record.outcome != PlacementRecord::Outcome::kReoriented;
}

int judged_height(const ExperimentRun& run) {
  const int reported = run.report.result.height;
  return run.report.truth ? std::min(reported, run.report.truth->height) : reported;
}

std::vector<int> heights(const Experiment& experiment) {
  std::vector<int> counts(static_cast<std::size_t>(experiment.per_run) + 1, 0);
  for (const auto& run : experiment.runs)
    ++counts[static_cast<std::size_t>(std::clamp(judged_height(run), 0, experiment.per_run))];
  return counts;
}

Rate reached(const Experiment& experiment, int height) {
  Rate rate{0, static_cast<int>(experiment.runs.size())};
  for (const auto& run : experiment.runs) rate.hits += judged_height(run) >= height ? 1 : 0;
  return rate;
}

std::vector<CalibrationBin> calibration(const Experiment& experiment, int bins) {
  require(bins > 0, "calibration needs at least one bin, got ", bins);
  std::vector<CalibrationBin> table(static_cast<std::size_t>(bins));
  for (int b = 0; b < bins; ++b) {
    table[static_cast<std::size_t>(b)].low = static_cast<double>(b) / bins;
    table[static_cast<std::size_t>(b)].high = static_cast<double>(b + 1) / bins;
  }
  for (const auto& run : experiment.runs)
    for (const auto& record : run.report.result.placements) {
      if (!was_tried(record)) continue;
      const double p = record.planned.predicted_success;
      auto& bin = table[static_cast<std::size_t>(std::clamp(static_cast<int>(p * bins), 0, bins - 1))];
      bin.mean_prediction += p;
      ++bin.observed.trials;
      bin.observed.hits += held(record) ? 1 : 0;
    }
  for (auto& bin : table)
    if (bin.observed.trials > 0) bin.mean_prediction /= bin.observed.trials;
  return table;
}

}  // namespace stonestack::experiment
