#include "report/run_page.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <nlohmann/json.hpp>

#include "stonestack/core/clock.hpp"
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

TEST(RunPage, ShowsTheContactsOfARunThatWasInterrupted) {
  RunReport report = report_of_a_grasp(2_stone);
  Stack on_table;
  on_table.stones.push_back(
      {2_stone, Pose(Eigen::Translation3d(0.7, 0.28, -bounds(stones()[2_stone].scan).min().z()))});
  std::get<Observed>(report.result.events.front()).world.resting = {{0.3, on_table, ""}};
  const auto clock = make_steady_clock();
  const TimeLimit over(1e-9, *clock);
  const json page = json::parse(page_data(report, stones(), robot(), ""));
  ASSERT_EQ(page["towers"].size(), 1u);
  EXPECT_FALSE(page["towers"][0]["contacts"].empty());
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
  EXPECT_EQ(live.size(), 15u);
  for (const auto& [name, value] : live.items()) EXPECT_EQ(value, page[name]) << name;
  EXPECT_EQ(json::parse(page_changes(so_far, stones(), robot(), position)),
            json::parse(R"({"samples": "", "views": [], "towers": [], "decisions": [], "events": []})"))
      << "nothing has changed since";

  Catalogue grown = stones();
  grown.stones.push_back(stones()[0_stone]);
  const json more = json::parse(page_changes(so_far, grown, robot(), position));
  EXPECT_EQ(more.at("stones").size(), stones().stones.size() + 1) << "a stone was modelled on the way";
  EXPECT_FALSE(json::parse(page_changes(so_far, grown, robot(), position)).contains("stones"));
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

/// Placements of the first decision of a report with that decision.
json decision_page(const ActionChosen& chosen) {
  RunReport report = report_of_a_grasp(0_stone);
  report.result.events.emplace_back(chosen);
  report.result.timeline.event_time = {10.0, 10.5};
  return json::parse(page_data(report, stones(), robot(), ""))["decisions"][0];
}

TEST(RunPage, ShowsSixPlacementsWhereAPlanIsFollowed) {
  Placement next;
  next.stone = 1_stone;
  next.expected_height = 2.5;
  next.then = {{2_stone, Pose::Identity()}};
  ActionChosen chosen{Place{{next}}, {next}, {}};
  for (int k = 0; k < 7; ++k) {
    Alternative& other = chosen.others.emplace_back();
    other.stone = 3_stone;
    other.terms = {{"margin", 0.1}, {"area", 0.2}};
    other.predicted_success = k == 0 ? 0.75 : 0.0;
    if (k == 1) other.why_not = "falls too often";
  }
  const json decision = decision_page(chosen);
  const json& shown = decision["candidates"];
  ASSERT_EQ(shown.size(), 6U);
  EXPECT_TRUE(shown[0]["chosen"]);
  EXPECT_EQ(shown[1]["stone"], 3);
  EXPECT_EQ(shown[1]["predicted"], 0.75);
  EXPECT_EQ(shown[1]["margin"], 0.1);
  EXPECT_EQ(shown[2]["why_not"], "falls too often");
  EXPECT_TRUE(shown[3]["predicted"].is_null()) << "nobody tried it";
  EXPECT_EQ(decision["terms"][0], "area");
  EXPECT_THAT(decision["why"].back().get<std::string>(),
              testing::AllOf(HasSubstr("compared with 5 others"), HasSubstr("2.50 stones are expected")));
}

TEST(RunPage, SaysThatAPlanIsFollowed) {
  RunReport report = report_of_a_grasp(0_stone);
  Placement first, second;
  first.stone = 1_stone;
  first.then = {{2_stone, Pose::Identity()}};
  second.stone = 2_stone;
  for (const Placement& next : {first, second})
    report.result.events.emplace_back(ActionChosen{Place{{next}}, {next}, {Alternative{}}});
  report.result.timeline.event_time = {10.0, 10.5, 11.5};
  const json decisions = json::parse(page_data(report, stones(), robot(), ""))["decisions"];
  EXPECT_THAT(decisions[0]["why"].back().get<std::string>(), testing::StartsWith("compared with 1 other"));
  EXPECT_THAT(decisions[1]["why"].back().get<std::string>(), testing::StartsWith("next in the plan"));
}

TEST(RunPage, ShowsTheTermsOfAWall) {
  Placement next;
  next.stone = 1_stone;
  next.terms = {{"course", 2.0}, {"joint_cover", 0.02}, {"worth", 3.0}, {"margin", 0.2}};
  next.support.corners_W = {{0.0, 0.0, 0.1}, {0.1, 0.0, 0.1}, {0.0, 0.1, 0.1}};
  const json decision = decision_page({Place{{next}}, {next}, {}});
  EXPECT_EQ(decision["terms"], json({"course", "joint_cover", "worth"}));
  EXPECT_EQ(decision["candidates"][0]["terms"]["joint_cover"], 0.02);
  EXPECT_EQ(decision["candidates"][0]["support"].size(), 3U);
}

/// Two bricks side by side, and a third over their joint.
WorldEstimate small_wall(const Catalogue& bricks) {
  WorldEstimate world;
  RestingStack& resting = world.resting.emplace_back();
  resting.friction = 0.6;
  resting.stack.emplace();
  const std::vector<Eigen::Vector3d> places{{-0.055, 0.0, 0.025}, {0.055, 0.0, 0.025}, {0.0, 0.0, 0.075}};
  for (std::size_t k = 0; k < places.size(); ++k) {
    resting.stack->stones.push_back({StoneIndex(static_cast<int>(k)), make_pose(places[k])});
    world.stack.push_back({StoneIndex(static_cast<int>(k)), make_pose(places[k]), make_pose(places[k])});
  }
  EXPECT_EQ(bricks.stones.size(), places.size());
  return world;
}

TEST(RunPage, DrawsForcesAndThrustLinesOfAWall) {
  Catalogue bricks;
  for (const char* name : {"left", "right", "upper"}) {
    Stone& brick = bricks.stones.emplace_back();
    brick.name = name;
    brick.mesh = brick.scan = make_box({0.1, 0.06, 0.05});
    brick.mass = mass_properties(brick.mesh, 2600.0);
  }
  RunReport report = report_of_a_grasp(0_stone);
  report.result.events = {Observed{small_wall(bricks)}};
  const json tower = json::parse(page_data(report, bricks, robot(), ""))["towers"][0];
  EXPECT_EQ(tower["centres"].size(), 3U);
  double on_table = 0.0, between = 0.0;
  for (const json& contact : tower["contacts"])
    (contact["p"][2] < 0.01 ? on_table : between) += contact["f"][2].get<double>();
  const double weight = 2600.0 * 0.1 * 0.06 * 0.05 * 9.80665;
  EXPECT_NEAR(on_table, 3.0 * weight, 0.02 * weight);
  EXPECT_NEAR(between, weight, 0.15 * weight);
  // Each lower brick to the table, and the upper one to both: to the centre of pressure and on from there.
  ASSERT_EQ(tower["thrust"].size(), 6U);
  int from_upper = 0, to_left = 0, to_right = 0;
  for (const json& line : tower["thrust"]) {
    ASSERT_EQ(line.size(), 2U);
    from_upper += line[0] == tower["centres"][2] ? 1 : 0;
    to_left += line[1] == tower["centres"][0] ? 1 : 0;
    to_right += line[1] == tower["centres"][1] ? 1 : 0;
  }
  EXPECT_EQ(from_upper, 2);
  EXPECT_EQ(to_left, 1);
  EXPECT_EQ(to_right, 1);
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
