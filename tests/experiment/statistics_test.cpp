#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "stonestack/core/error.hpp"
#include "stonestack/experiment/experiment.hpp"

namespace stonestack::experiment {
namespace {

using StatisticsOutcome = PlacementRecord::Outcome;

PlacementRecord placement(double predicted, StatisticsOutcome outcome) {
  PlacementRecord record;
  record.planned.predicted_success = predicted;
  record.outcome = outcome;
  return record;
}

ExperimentRun run_of(int reported, int true_height, std::vector<PlacementRecord> placements) {
  ExperimentRun run;
  run.report.result.height = reported;
  run.report.result.placements = std::move(placements);
  run.report.truth = TruthReport{true_height, true_height >= reported, 60.0, 0.0, 0.0, "", {}};
  return run;
}

Experiment sample() {
  Experiment experiment;
  experiment.runs.push_back(
      run_of(2, 2,
             {placement(0.95, StatisticsOutcome::kPlaced), placement(0.9, StatisticsOutcome::kPlaced),
              placement(0.3, StatisticsOutcome::kFallen)}));
  experiment.runs.push_back(run_of(
      3, 1, {placement(1.0, StatisticsOutcome::kPlaced), placement(1.0, StatisticsOutcome::kNotPicked)}));
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

ExperimentRun run_on(const std::string& stones, int height, std::vector<PlacementRecord> placements = {}) {
  ExperimentRun run = run_of(height, height, std::move(placements));
  for (const char stone : stones) run.report.present.emplace_back(1, stone);
  return run;
}

/// Runs of height 1 (true) or 0 on the sets of stones ab, cd and so on.
Experiment clustered(const std::vector<std::vector<bool>>& outcomes) {
  Experiment experiment;
  char name = 'a';
  for (const auto& set : outcomes) {
    for (const bool hit : set) experiment.runs.push_back(run_on({name, static_cast<char>(name + 1)}, hit));
    name = static_cast<char>(name + 2);
  }
  return experiment;
}

TEST(Statistics, RunsOfOneSetOfStonesAreACluster) {
  // By hand: hits 4, 0, 2 of 4 each. Variance of the share over clusters 3/2 8/144 against 1/4 1/11, so the
  // design effect is 3.6667; t(11) = 2.20099, t(2) = 4.30265; 12 / 3.6667 (2.20099 / 4.30265)^2 = 0.85642.
  const auto all = std::vector<bool>(4, true), none = std::vector<bool>(4, false);
  const Rate rate = reached(clustered({all, none, {true, true, false, false}}), 1);
  EXPECT_EQ(rate.hits, 6);
  EXPECT_EQ(rate.trials, 12);
  EXPECT_EQ(rate.clusters, 3);
  EXPECT_NEAR(rate.effective, 0.8564, 1e-3);
  EXPECT_NEAR(rate.low(), 0.0479, 1e-3);
  EXPECT_NEAR(rate.high(), 0.9521, 1e-3);
  // Hits 2, 1, 1, 0 of 2 each: design effect 7/6, t(7) = 2.36462, t(3) = 3.18245.
  EXPECT_NEAR(reached(clustered({{true, true}, {true, false}, {false, true}, {false, false}}), 1).effective,
              8 / (7.0 / 6) * std::pow(2.36462 / 3.18245, 2), 0.01);
}

TEST(Statistics, ClustersThatAgreeNoMoreThanChanceCostOnlyTheirFewness) {
  // Every set has one hit of two: less spread than chance gives, so the design effect is 1.
  const Rate rate = reached(clustered({{true, false}, {false, true}, {true, false}, {false, true}}), 1);
  EXPECT_NEAR(rate.effective, 8 * std::pow(2.36462 / 3.18245, 2), 1e-4);
}

TEST(Statistics, RunsThatAllEndAlikeCountOnceASet) {
  const Rate all = reached(clustered({{true, true, true}, {true, true, true}}), 1);
  EXPECT_NEAR(all.effective, 2.0, 1e-12);
  EXPECT_NEAR(all.low(), 1 / (1 + 1.959964 * 1.959964 / 2), 1e-6);  // Wilson, 2 of 2
  EXPECT_NEAR(reached(clustered({{true, false, true, true}}), 1).effective, 1.0, 1e-12) << "one set";
}

TEST(Statistics, SetsOfTheirOwnGiveWilsonsInterval) {
  std::vector<std::vector<bool>> outcomes(8, {true});
  outcomes.resize(10, {false});
  const Rate rate = reached(clustered(outcomes), 1);
  EXPECT_EQ(rate.clusters, 10);
  EXPECT_NEAR(rate.low(), 0.4902, 1e-4);
  EXPECT_NEAR(rate.high(), 0.9433, 1e-4);
}

TEST(Statistics, TheOrderOfTheStonesDoesNotMatter) {
  Experiment experiment;
  experiment.runs = {run_on("ab", 1), run_on("ba", 0), run_on("ac", 1)};
  EXPECT_EQ(stone_sets(experiment), 2);
}

TEST(Statistics, PlacementsOfOneSetAreOneCluster) {
  Experiment experiment;
  const auto placed = [] { return placement(0.9, StatisticsOutcome::kPlaced); };
  experiment.runs = {run_on("ab", 2, {placed(), placed()}), run_on("ab", 2, {placed(), placed()}),
                     run_on("cd", 1, {placed(), placement(0.9, StatisticsOutcome::kFallen)})};
  const Rate observed = calibration(experiment).back().observed;
  EXPECT_EQ(observed.trials, 6);
  EXPECT_EQ(observed.clusters, 2);
  EXPECT_LT(observed.effective, 6.0);
}

TEST(Statistics, ThePapersProtocolEndsAtTheFirstPlacementThatWasNotPlaced) {
  const auto records = [](const std::vector<StatisticsOutcome>& outcomes) {
    std::vector<PlacementRecord> list;
    for (const StatisticsOutcome outcome : outcomes) list.push_back(placement(0.9, outcome));
    return list;
  };
  const auto height = [&](int judged, const std::vector<StatisticsOutcome>& outcomes) {
    return paper_height(run_of(4, judged, records(outcomes)).report);
  };
  const StatisticsOutcome placed = StatisticsOutcome::kPlaced;
  EXPECT_EQ(height(4, {placed, placed, placed, placed}), 4);
  EXPECT_EQ(height(3, {placed, placed, placed, placed}), 3) << "what does not stand does not count";
  EXPECT_EQ(height(4, {placed, placed, StatisticsOutcome::kFallen, placed, placed}), 2);
  EXPECT_EQ(height(1, {placed, placed, StatisticsOutcome::kFallen}), 2)
      << "before the fall took the second with it";
  EXPECT_EQ(height(4, {placed, StatisticsOutcome::kNotPicked, placed, placed, placed}), 1)
      << "no second pick";
  EXPECT_EQ(height(4, {placed, placed, StatisticsOutcome::kUnstacked, placed, placed, placed}), 2);
  EXPECT_EQ(height(4, {StatisticsOutcome::kReoriented, placed, placed, placed, placed}), 0);
  EXPECT_EQ(height(4, {placed, StatisticsOutcome::kMoved, placed, placed}), 1);

  Experiment experiment;
  experiment.runs = {run_of(4, 4, records({placed, placed, placed, placed})),
                     run_of(4, 4, records({placed, StatisticsOutcome::kFallen, placed, placed, placed}))};
  EXPECT_THAT(paper_heights(experiment), testing::ElementsAre(0, 1, 0, 0, 1));
  EXPECT_EQ(reached_by_paper(experiment, 4).hits, 1);
  EXPECT_EQ(reached(experiment, 4).hits, 2);
}

TEST(Statistics, EnginesDisagreeWhereTheirHeightsDiffer) {
  TruthReport truth;
  truth.height = 3;
  EXPECT_FALSE(engines_disagree(truth)) << "older records hold none";
  truth.engines = {{"bullet", 3, 60.0, 0.0, 0.0, ""}, {"ode", 3, 5.0, 0.0, 0.0, ""}};
  EXPECT_FALSE(engines_disagree(truth));
  truth.engines[0].height = 4;
  EXPECT_TRUE(engines_disagree(truth));
}

TEST(Statistics, CalibrationNeedsABin) {
  EXPECT_THROW((void)calibration(sample(), 0), InvalidArgument);
}

}  // namespace
}  // namespace stonestack::experiment
