#include "stonestack/report/results.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "stonestack/core/file.hpp"
#include "temporary_folder.hpp"

namespace stonestack::report {
namespace {

using nlohmann::json;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

Catalogue named(const std::vector<std::string>& names) {
  Catalogue catalogue;
  for (const auto& name : names) {
    catalogue.stones.emplace_back();
    catalogue.stones.back().name = name;
  }
  return catalogue;
}

Pose at(double x, double y, double z) {
  return make_pose({x, y, z});
}

std::string temporary(const std::string& name) {
  return (std::filesystem::path(test::temporary_folder()) / name).string();
}

/// "a" is certain; "b" may be "a" as well, and a pose of its own fits as well.
DetectionResult two_detections() {
  DetectionResult result;
  result.detections.resize(2);
  result.detections[0].stone = 0_stone;
  result.detections[0].T_C_O = at(0.1, 0.0, 0.5);
  result.detections[0].score = 0.95;
  result.detections[1].stone = 1_stone;
  result.detections[1].T_C_O = at(0.0, 0.2, 0.6);
  result.detections[1].score = 0.8;
  result.detections[1].certainty = 0.5;
  result.detections[1].alternatives = {{at(0.0, 0.2, 0.6), 0.3, 0_stone}, {at(0.0, 0.2, 0.6), 0.2, 1_stone}};
  return result;
}

TEST(DetectionResults, NameStonesAndAddTheWorldWhereTheCameraIsKnown) {
  const Catalogue catalogue = named({"a", "b"});
  const json unknown = json::parse(detection_json(two_detections(), catalogue, std::nullopt));
  EXPECT_EQ(unknown.at("schema"), "stonestack.detect/1");
  EXPECT_EQ(unknown.at("detections").at(1).at("stone"), "b");
  EXPECT_EQ(unknown.at("detections").at(1).at("likes").at(0).at("stone"), "a");
  EXPECT_FALSE(unknown.at("detections").at(0).contains("T_W_O"));
  EXPECT_FALSE(unknown.contains("depth_scale"));
  const json known = json::parse(detection_json(two_detections(), catalogue, at(1.0, 0.0, 0.0)));
  EXPECT_NEAR(known.at("detections").at(0).at("T_W_O").at("x").get<double>(), 1.1, 1e-12);
}

TEST(DetectionResults, ATableOfACloudInTheWorldHasPositionsThere) {
  SceneView view;
  view.T_W_C = at(1.0, 0.0, 0.0);
  EXPECT_THAT(detection_table(two_detections(), named({"a", "b"}), view),
              HasSubstr(" 0.1000  0.0000  0.5000"));
  view.world = true;
  const std::string table = detection_table(two_detections(), named({"a", "b"}), view);
  EXPECT_THAT(table, HasSubstr("in the world frame"));
  EXPECT_THAT(table, HasSubstr(" 1.1000  0.0000  0.5000"));
}

TEST(DetectionResults, WarningsNameWhatElseAStoneMayBe) {
  DetectionOptions options;
  options.accept_score = 0.85;
  const auto warnings = detection_warnings(two_detections(), named({"a", "b"}), options);
  ASSERT_EQ(warnings.size(), 2U);
  EXPECT_THAT(warnings[0], HasSubstr("b may be 'a' as well and is nearly symmetric: 1 other poses"));
  EXPECT_THAT(warnings[1], HasSubstr("its score of 0.8 says that the pose is wrong"));
}

TEST(DetectionResults, AreReadBackAsSeenPoses) {
  const std::string path = temporary("results_test_detected.json");
  write_file(path, detection_json(two_detections(), named({"a", "b"}), at(1.0, 0.0, 0.0)));
  const auto poses = read_seen_poses(path);
  ASSERT_EQ(poses.size(), 2U);
  EXPECT_EQ(poses[1].stone, "b");
  EXPECT_NEAR((poses[1].T_W_O.translation() - Eigen::Vector3d(1.0, 0.2, 0.6)).norm(), 0.0, 1e-12);
  write_file(path, detection_json(two_detections(), named({"a", "b"}), std::nullopt));
  EXPECT_THROW((void)read_seen_poses(path), FileError);  // where it is in W is not known
  write_file(path, R"({"detections": [{"stone": "a", "T_W_O":
      {"x": 0, "y": 0, "z": 0, "qx": 0, "qy": 0, "qz": 0, "qw": 0.5}}]})");
  EXPECT_THROW((void)read_seen_poses(path), FileError);  // no rotation
}

TEST(TrackingResults, AStoneThatIsNotSeenHasNoPose) {
  TrackResult result;
  result.stones.resize(2);
  result.stones[0].stone = 0_stone;
  result.stones[0].status = TrackedStone::Status::kMoved;
  result.stones[0].detection = two_detections().detections[0];
  result.stones[0].moved.translation = 0.004;
  result.stones[1].stone = 1_stone;
  const json tracked = json::parse(tracking_json(result, named({"a", "b"}), at(0, 0, 0))).at("tracked");
  EXPECT_EQ(tracked.at(0).at("status"), "moved");
  EXPECT_NEAR(tracked.at(0).at("moved_m").get<double>(), 0.004, 1e-12);
  EXPECT_EQ(tracked.at(1).at("status"), "unseen");
  EXPECT_FALSE(tracked.at(1).contains("T_C_O"));
  const std::string path = temporary("results_test_tracked.json");
  write_file(path, tracking_json(result, named({"a", "b"}), at(0, 0, 0)));
  EXPECT_EQ(read_seen_poses(path).size(), 1U);
}

/// One placement with an alternative, found in a view with the camera's pose.
SceneSearch found_in_view() {
  SceneSearch found;
  found.catalogue = named({"a", "b"});
  found.start.seen = true;
  found.start.frame = "camera_pose";
  found.start.problem.stack.stones = {{0_stone, at(0.7, 0.2, 0.03)}};
  Placement first, second;
  first.stone = second.stone = 1_stone;
  first.T_W_O = at(0.7, 0.2, 0.09);
  second.T_W_O = at(0.71, 0.2, 0.09);
  found.placements = {first};
  found.alternatives = {second};
  return found;
}

TEST(SearchResults, AreReadBackAsTargetsBestFirst) {
  const std::string path = temporary("results_test_search.json");
  write_file(path, search_json(found_in_view(), 7, "next"));
  const auto targets = read_search_targets(path);
  ASSERT_EQ(targets.size(), 2U);
  EXPECT_EQ(targets[0].stone, "b");
  EXPECT_NEAR(targets[0].T_W_O.translation().x(), 0.70, 1e-12);
  EXPECT_NEAR(targets[1].T_W_O.translation().x(), 0.71, 1e-12);
  SceneSearch nothing = found_in_view();
  nothing.placements.clear();
  write_file(path, search_json(nothing, 7, ""));
  EXPECT_THROW((void)read_search_targets(path), FileError);
}

TEST(SearchResults, ThePlannedTowerIsTheStackWithThePlacementsOnIt) {
  const SceneSearch found = found_in_view();
  const auto tower = planned_tower(found);
  ASSERT_EQ(tower.size(), 2U);
  const SceneFile scene = scene_of(found);
  EXPECT_EQ(scene.stack[0].stone, "a");
  EXPECT_EQ(scene.stack[1].stone, "b");
}

TEST(SearchResults, TheNextCommandRepeatsWhatWasGivenAndQuotesIt) {
  SceneSearchTask task;
  task.scene = "my scene.ply";
  task.camera_pose = "0,0,1,1,0,0,0";
  task.depth.units = "mm";
  const std::string next = next_command(found_in_view(), task, "it's", "");
  EXPECT_EQ(next,
            "stonestack search 'my scene.ply' --units mm --catalogue 'it'\\''s' --camera-pose 0,0,1,1,0,0,0 "
            "--robot ur10 --json > next.json");
  task.robot = "ur5";
  EXPECT_THAT(next_command(found_in_view(), task, "", ""), HasSubstr(" --robot ur5 --out tower.yaml"));
  EXPECT_EQ(next_command(found_in_view(), task, "", "t.yaml"), "stonestack check t.yaml");
  SceneSearch not_seen = found_in_view();
  not_seen.start.seen = false;
  EXPECT_EQ(next_command(not_seen, task, "", ""), "");
}

TEST(SearchResults, TextStatesFrameAndStackOfAView) {
  SceneSearch found = found_in_view();
  found.start.frame_text = "the table";
  found.start.site_text = "a stands";
  found.start.T_W_C = at(0.0, 0.0, 0.5);
  EXPECT_THAT(search_text(found, "go on"),
              testing::AllOf(HasSubstr("frame  the table; camera at 0.000 0.000 0.500 m\nstack  a stands\n"),
                             HasSubstr("next   go on\n")));
  found.start.seen = false;
  EXPECT_THAT(search_text(found, ""), testing::AllOf(Not(HasSubstr("frame")), Not(HasSubstr("next"))));
}

TEST(TowerResults, NameTheContactThatGivesWayFirst) {
  TowerCheck check;
  check.stack.stones = {{1_stone, at(0, 0, 0)}, {0_stone, at(0, 0, 0.05)}};
  check.verdict.stands = true;
  check.equilibrium.stands = true;
  check.equilibrium.min_friction = std::numeric_limits<double>::infinity();
  check.equilibrium.weakest_contact = 1;
  check.statics.contacts.resize(2);
  check.statics.contacts[1].above = 1;
  check.statics.contacts[1].below = 0;
  const json out = json::parse(tower_json(check, named({"a", "b"})));
  EXPECT_EQ(out.at("weakest_contact").at("above"), "a");
  EXPECT_EQ(out.at("weakest_contact").at("below"), "b");
  EXPECT_TRUE(out.at("min_friction").is_null());  // JSON knows no infinity
  EXPECT_THAT(tower_text(check, named({"a", "b"})), HasSubstr("weakest      a on b at"));
  check.statics.contacts[1].below = kTable;
  EXPECT_THAT(tower_text(check, named({"a", "b"})), HasSubstr("weakest      a on the table at"));
}

TEST(TowerResults, OfATowerThatDoesNotStandSayNothingOfItsContactsOrOfFrictionThatHolds) {
  TowerCheck check;
  check.stack.stones = {{0_stone, at(0, 0, 0)}};
  check.verdict.stands = false;
  check.verdict.clean = true;
  check.equilibrium.stands = true;
  check.equilibrium.min_friction = 0.0;
  const std::string text = tower_text(check, named({"a"}));
  EXPECT_THAT(text, HasSubstr("simulation   does not stand; moved"));
  EXPECT_THAT(text, HasSubstr("friction     contact forces balance down to 0.000 (forces alone)"));
  check.verdict.stands = true;
  EXPECT_THAT(tower_text(check, named({"a"})), HasSubstr("simulation   stands, clean; moved"));
}

TEST(StoneResults, ASummaryKeepsMeasuresWithoutMeshes) {
  ModelResult result;
  Stone& stone = result.stone;
  stone.name = "cube";
  stone.scan.vertices = {{0, 0, 0}, {2, 0, 0}, {0, 2, 0}, {0, 0, 2}};
  stone.scan.faces = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
  stone.mesh = stone.scan;
  const StoneSummary summary = summary_of(result);
  EXPECT_NEAR(summary.volume, 8.0 / 6.0, 1e-9);
  EXPECT_NEAR(summary.volume_over_hull, 1.0, 1e-9);
  EXPECT_EQ(summary.scan_faces, 4U);
  EXPECT_TRUE(summary.stone.scan.vertices.empty());
  const json out = json::parse(stones_json({summary}, "rocks", {{"bad.ply", "holes"}}));
  EXPECT_EQ(out.at("stones").at(0).at("folder"), "rocks/cube");
  EXPECT_EQ(out.at("failed").at(0).at("error"), "holes");
}

TEST(RunResults, ADryRunIsNamedAfterWhatWasOrdered) {
  RunReport report;
  report.result.end = RunResult::End::kPlanned;
  EXPECT_THAT(run_table(report), HasSubstr("tower of 0 of 0 stones"));
  report.structure = "wall";
  EXPECT_THAT(run_table(report), HasSubstr("wall of 0 of 0 stones"));
  report.result.wall.emplace().to_span = 0.1;
  EXPECT_THAT(run_table(report), HasSubstr("bridge of 0 of 0 stones"));
}

TEST(RunResults, ExitCodesFollowTheEnd) {
  RunResult result;
  result.end = RunResult::End::kHeightReached;
  EXPECT_EQ(exit_code(result), ExitCode::kDone);
  result.end = RunResult::End::kNoPose;
  result.height = 2;
  EXPECT_EQ(exit_code(result), ExitCode::kDone);
  result.height = 1;
  EXPECT_EQ(exit_code(result), ExitCode::kNoStablePose);
  result.end = RunResult::End::kStopped;
  EXPECT_EQ(exit_code(result), ExitCode::kSafetyStop);
}

}  // namespace
}  // namespace stonestack::report
