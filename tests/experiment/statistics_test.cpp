#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "stonestack/core/error.hpp"
#include "stonestack/experiment/experiment.hpp"

namespace stonestack::experiment {
namespace {

using Outcome = PlacementRecord::Outcome;

PlacementRecord placement(double predicted, Outcome outcome) {
  PlacementRecord record;
  record.planned.predicted_success = predicted;
  record.outcome = outcome;
  return record;
}

ExperimentRun run_of(int reported, int true_height, std::vector<PlacementRecord> placements) {
  ExperimentRun run;
  run.report.result.height = reported;
  run.report.result.placements = std::move(placements);
  run.report.truth = TruthReport{true_height, true_height >= reported, 60.0, 0.0, 0.0, ""};
  return run;
}

Experiment sample() {
  Experiment experiment;
  experiment.runs.push_back(run_of(2, 2,
                                   {placement(0.95, Outcome::kPlaced), placement(0.9, Outcome::kPlaced),
                                    placement(0.3, Outcome::kFallen)}));
  experiment.runs.push_back(
      run_of(3, 1, {placement(1.0, Outcome::kPlaced), placement(1.0, Outcome::kNotPicked)}));
  return experiment;
}

TEST(Statistics, HeightsAreThoseOfTheTrueWorld) {
  EXPECT_THAT(heights(sample()), testing::ElementsAre(0, 1, 1, 0, 0));
  EXPECT_EQ(reached(sample(), 2).hits, 1);
  EXPECT_EQ(reached(sample(), 2).trials, 2);
}

TEST(Statistics, IntervalIsWilsons) {
  const Rate rate{8, 10};  // by hand: Wilson 95 % of 8/10 is 0.4902 to 0.9433
  EXPECT_NEAR(rate.low(), 0.4902, 1e-4);
  EXPECT_NEAR(rate.high(), 0.9433, 1e-4);
  const Rate all{11, 11};
  EXPECT_DOUBLE_EQ(all.high(), 1.0);
  EXPECT_NEAR(all.low(), 0.7412, 1e-4);
}

TEST(Statistics, ComparesPredictionsWithWhatWasSeen) {
  const auto bins = calibration(sample());
  ASSERT_EQ(bins.size(), 5u);
  EXPECT_EQ(bins[4].observed.trials, 3);  // not picked is no placement
  EXPECT_EQ(bins[4].observed.hits, 3);
  EXPECT_EQ(bins[1].observed.trials, 1);
  EXPECT_EQ(bins[1].observed.hits, 0);
  EXPECT_NEAR(bins[4].mean_prediction, 0.95, 1e-12);
}

TEST(Statistics, CalibrationNeedsABin) {
  EXPECT_THROW((void)calibration(sample(), 0), InvalidArgument);
}

}  // namespace
}  // namespace stonestack::experiment
