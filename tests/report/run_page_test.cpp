#include "report/run_page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "stonestack/core/file.hpp"
#include "stonestack/experiment/simulated_run.hpp"
#include "stonestack/report/run_report.hpp"

namespace stonestack::report {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

const Catalogue& stones() {
  static const Catalogue catalogue = read_catalogue(data_path("stones"));
  return catalogue;
}

const RobotModel& robot() {
  static const RobotModel model = read_robot("ur10");
  return model;
}

WorldEstimate world_with(const Pose& T_W_O, StoneIndex stone) {
  WorldEstimate world;
  world.loose.push_back({stone, T_W_O, T_W_O});
  return world;
}

/// A run in which the arm stands still, grasps what lies at its tool and lets it go.
RunReport report_of_a_grasp(StoneIndex stone) {
  RunReport report;
  report.robot = "ur10";
  report.seed = 3;
  SimulatedRun run;
  report.options_text = write_fields(fields(run));
  RunResult& result = report.result;
  result.events.emplace_back(Observed{world_with(Pose::Identity(), stone)});
  result.timeline.event_time = {10.0};
  for (const auto& [time, holds] : {std::pair{10.0, false}, {11.0, true}, {12.5, true}, {13.0, false}}) {
    MotionSample sample;
    sample.time = time;
    sample.holds = holds;
    result.timeline.samples.push_back(sample);
  }
  return report;
}

TEST(RunPage, FollowsTheStoneFromGraspToRelease) {
  const json page = json::parse(page_data(report_of_a_grasp(2_stone), stones(), robot(), ""));
  ASSERT_EQ(page["carries"].size(), 1u);
  EXPECT_EQ(page["carries"][0]["stone"], 2);
  EXPECT_DOUBLE_EQ(page["carries"][0]["begin"], 1.0);
  EXPECT_DOUBLE_EQ(page["carries"][0]["end"], 3.0);
  EXPECT_EQ(page["views"].size(), 1u);
}

TEST(RunPage, ListsOptionsThatDifferFromTheirDefaults) {
  RunReport report = report_of_a_grasp(0_stone);
  EXPECT_TRUE(json::parse(page_data(report, stones(), robot(), ""))["changed"].empty());
  SimulatedRun run;
  run.build.search.friction = 0.37;
  report.options_text = write_fields(fields(run));
  const json changed = json::parse(page_data(report, stones(), robot(), ""))["changed"];
  ASSERT_EQ(changed.size(), 1u);
  EXPECT_EQ(changed[0][0], "search.friction");
  EXPECT_EQ(changed[0][1], "0.37");
}

TEST(RunPage, ShowsEveryDecisionWithWhatWasCompared) {
  RunReport report = report_of_a_grasp(0_stone);
  Placement first, second;
  first.stone = 0_stone;
  first.cost = 0.2;
  second.stone = 1_stone;
  second.cost = 0.5;
  report.result.events.emplace_back(ActionChosen{Place{{second}}, {first, second}});
  report.result.events.emplace_back(ActionChosen{Stop{RunEnd::kAllPlaced, "all is done"}, {}});
  report.result.timeline.event_time = {10.0, 10.5, 12.0};
  const json decisions = json::parse(page_data(report, stones(), robot(), ""))["decisions"];
  ASSERT_EQ(decisions.size(), 2u);
  EXPECT_EQ(decisions[0]["title"], "place " + stones().stones[1].name);
  ASSERT_EQ(decisions[0]["candidates"].size(), 2u);
  EXPECT_FALSE(decisions[0]["candidates"][0]["chosen"]);
  EXPECT_TRUE(decisions[0]["candidates"][1]["chosen"]);
  EXPECT_EQ(decisions[1]["why"].back(), "all is done");
  EXPECT_DOUBLE_EQ(decisions[1]["t"], 2.0);
}

TEST(RunPage, IsOneFileThatNoNameBreaks) {
  RunReport report = report_of_a_grasp(0_stone);
  report.result.placements.emplace_back();
  report.result.placements.back().stone = "</script><script>alert(1)</script>";
  report.result.placements.back().note = "bytes that are no UTF-8: \xff\xfe";
  const std::string page = run_html(report, stones(), robot());
  EXPECT_THAT(page, Not(HasSubstr("</script><script>alert")));
  EXPECT_THAT(page, Not(HasSubstr("src=\"http")));
  EXPECT_LT(page.size(), 6'000'000u);
  EXPECT_THAT(page, testing::StartsWith("<!doctype html>"));
}

}  // namespace
}  // namespace stonestack::report
