#include "report/run_page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "stonestack/core/file.hpp"
#include "stonestack/experiment/simulated_run.hpp"
#include "stonestack/report/record_run.hpp"

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

/// Numbers of the packed text, by a decoder of its own.
std::vector<float> decoded(const std::string& text) {
  static const std::string kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  unsigned bits = 0;
  int count = 0;
  for (const char c : text) {
    if (c == '=') break;
    bits = (bits << 6U) | static_cast<unsigned>(kDigits.find(c));
    if ((count += 6) >= 8) bytes += static_cast<char>((bits >> static_cast<unsigned>(count -= 8)) & 255U);
  }
  std::vector<float> values(bytes.size() / sizeof(float));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(float));
  return values;
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

/// Appends lists and replaces values, as the page does.
void apply_changes(json& page, const json& changes, std::vector<float>& samples) {
  for (const auto& [name, value] : changes.items()) {
    if (name == "samples") {
      const std::vector<float> more = decoded(value.get<std::string>());
      samples.insert(samples.end(), more.begin(), more.end());
    } else if (name == "views" || name == "towers" || name == "decisions" || name == "events") {
      if (!page.contains(name)) page[name] = json::array();
      page[name].insert(page[name].end(), value.begin(), value.end());
    } else {
      page[name] = value;
    }
  }
}

TEST(RunPage, ChangesInOrderMakeThePage) {
  RunReport whole = report_of_a_grasp(2_stone);
  whole.result.events.emplace_back(StoneMoved{1_stone, 0.004});
  whole.result.events.emplace_back(ActionChosen{Stop{RunEnd::kNoPose, "nothing fits"}, {}});
  whole.result.timeline.event_time = {10.0, 11.5, 13.0};
  PlacementRecord placed;
  placed.stone = stones()[2_stone].name;
  placed.outcome = PlacementRecord::Outcome::kPlaced;
  whole.result.placements = {placed};
  whole.result.height = 1;

  RunReport so_far = whole;
  PagePosition position;
  json live = json::object();
  std::vector<float> samples;
  for (std::size_t n = 0; n <= 3; ++n) {
    so_far.result.events.assign(whole.result.events.begin(),
                                whole.result.events.begin() + static_cast<long>(n));
    so_far.result.timeline.samples.assign(whole.result.timeline.samples.begin(),
                                          whole.result.timeline.samples.begin() + static_cast<long>(n) + 1);
    so_far.result.placements = n == 3 ? whole.result.placements : std::vector<PlacementRecord>();
    so_far.result.height = n == 3 ? 1 : 0;
    apply_changes(live, json::parse(page_changes(so_far, stones(), robot(), position)), samples);
  }
  const json page = json::parse(page_data(whole, stones(), robot(), ""));
  EXPECT_EQ(samples, decoded(page["samples"].get<std::string>()));
  EXPECT_EQ(live.size(), 14u);
  for (const auto& [name, value] : live.items()) EXPECT_EQ(value, page[name]) << name;
  EXPECT_EQ(json::parse(page_changes(so_far, stones(), robot(), position)),
            json::parse(R"({"samples": "", "views": [], "towers": [], "decisions": [], "events": []})"))
      << "nothing has changed since";
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
