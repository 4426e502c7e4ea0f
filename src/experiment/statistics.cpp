#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>

#include "experiment/clustered_count.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/experiment/experiment.hpp"

namespace stonestack::experiment {
namespace {

constexpr double z = 1.959964;  // 95 %, two sides

double wilson(const Rate& rate, double side) {
  if (rate.trials == 0) return side > 0 ? 1.0 : 0.0;
  const double n = rate.effective > 0.0 ? rate.effective : rate.trials, p = rate.share();
  const double centre = p + z * z / (2 * n);
  const double spread = z * std::sqrt(p * (1 - p) / n + z * z / (4 * n * n));
  return std::clamp((centre + side * spread) / (1 + z * z / n), 0.0, 1.0);
}

/// Quantile 0.975 of Student's t distribution.
double t_quantile(int degrees) {
  return boost::math::quantile(boost::math::students_t(degrees), 0.975);
}

bool held(const PlacementRecord& record) {
  return record.outcome == PlacementRecord::Outcome::kPlaced;
}

/// The stones of a run, whatever their order.
std::string stone_set(const RunReport& report) {
  std::vector<std::string> names = report.present;
  std::sort(names.begin(), names.end());
  std::string set;
  for (const std::string& name : names) set += name + '\n';
  return set;
}

std::vector<int> histogram(const Experiment& experiment, int (*height)(const ExperimentRun&)) {
  std::vector<int> counts(static_cast<std::size_t>(experiment.per_run) + 1, 0);
  for (const auto& run : experiment.runs)
    ++counts[static_cast<std::size_t>(std::clamp(height(run), 0, experiment.per_run))];
  return counts;
}

int paper_height_of(const ExperimentRun& run) {
  return paper_height(run.report);
}

int judged(const RunReport& report) {
  const int reported = report.result.height;
  return report.truth ? std::min(reported, report.truth->height) : reported;
}

}  // namespace

void ClusteredCount::add(const RunReport& report, bool hit) {
  Tally& tally = clusters_[stone_set(report)];
  ++tally.trials;
  tally.hits += hit ? 1 : 0;
}

Rate ClusteredCount::rate() const {
  Rate rate;
  rate.clusters = static_cast<int>(clusters_.size());
  double squares = 0.0;
  for (const auto& [set, tally] : clusters_) {
    rate.hits += tally.hits;
    rate.trials += tally.trials;
    squares += static_cast<double>(tally.trials) * tally.trials;
  }
  const double n = rate.trials, k = rate.clusters, p = rate.share();
  if (rate.trials == rate.clusters) return rate;
  double effect = squares / n;  // largest: all trials of a cluster end alike
  if (rate.clusters == 1 || rate.hits == 0 || rate.hits == rate.trials) {
    rate.effective = n / effect;
    return rate;
  }
  double spread = 0.0;  // variance of the ratio of two sums over clusters, against that of independent trials
  for (const auto& [set, tally] : clusters_) spread += std::pow(tally.hits - p * tally.trials, 2);
  effect = std::clamp(k / (k - 1) * spread / (n * n) * (n - 1) / (p * (1 - p)), 1.0, effect);
  const double freedom = t_quantile(rate.trials - 1) / t_quantile(rate.clusters - 1);
  rate.effective = n / effect * freedom * freedom;
  return rate;
}

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
         record.outcome != PlacementRecord::Outcome::kReoriented &&
         record.outcome != PlacementRecord::Outcome::kPushed;
}

int judged_height(const ExperimentRun& run) {
  return judged(run.report);
}

std::vector<int> heights(const Experiment& experiment) {
  return histogram(experiment, judged_height);
}

Rate reached(const Experiment& experiment, int height) {
  ClusteredCount count;
  for (const auto& run : experiment.runs) count.add(run.report, judged_height(run) >= height);
  return count.rate();
}

int paper_height(const RunReport& report) {
  int placed = 0;
  for (const PlacementRecord& record : report.result.placements) {
    if (!held(record)) return placed;
    ++placed;
  }
  return std::min(placed, judged(report));
}

std::vector<int> paper_heights(const Experiment& experiment) {
  return histogram(experiment, paper_height_of);
}

Rate reached_by_paper(const Experiment& experiment, int height) {
  ClusteredCount count;
  for (const auto& run : experiment.runs) count.add(run.report, paper_height(run.report) >= height);
  return count.rate();
}

int stone_sets(const Experiment& experiment) {
  return reached(experiment, 0).clusters;
}

std::vector<CalibrationBin> calibration(const Experiment& experiment, int bins) {
  require(bins > 0, "calibration needs at least one bin, got ", bins);
  std::vector<CalibrationBin> table(static_cast<std::size_t>(bins));
  std::vector<ClusteredCount> counts(table.size());
  for (int b = 0; b < bins; ++b) {
    table[static_cast<std::size_t>(b)].low = static_cast<double>(b) / bins;
    table[static_cast<std::size_t>(b)].high = static_cast<double>(b + 1) / bins;
  }
  for (const auto& run : experiment.runs)
    for (const auto& record : run.report.result.placements) {
      if (!was_tried(record)) continue;
      const double p = record.planned.predicted_success;
      const auto b = static_cast<std::size_t>(std::clamp(static_cast<int>(p * bins), 0, bins - 1));
      table[b].mean_prediction += p;
      counts[b].add(run.report, held(record));
    }
  for (std::size_t b = 0; b < table.size(); ++b) {
    table[b].observed = counts[b].rate();
    if (table[b].observed.trials > 0) table[b].mean_prediction /= table[b].observed.trials;
  }
  return table;
}

}  // namespace stonestack::experiment
