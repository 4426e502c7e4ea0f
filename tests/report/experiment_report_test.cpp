#include "stonestack/report/record_run.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "temporary_folder.hpp"

namespace stonestack::report {
namespace {

using ::testing::HasSubstr;
using Outcome = PlacementRecord::Outcome;

PlacementRecord placement(double cost, double predicted, Outcome outcome, const char* stone = "stone") {
  PlacementRecord record;
  record.stone = stone;
  record.planned.cost = cost;
  record.planned.predicted_success = predicted;
  record.outcome = outcome;
  return record;
}

ExperimentRun run_of(int reported, int true_height, std::vector<PlacementRecord> placements) {
  ExperimentRun run;
  run.number = 1;
  run.report.seed = 1001;
  run.report.present = {"a", "b"};
  run.report.result.height = reported;
  run.report.result.placements = std::move(placements);
  run.report.result.ended = "it ended";
  run.report.truth = TruthReport{true_height, true_height >= reported, 60.0, 0.0, 0.0, "", {}};
  run.survival = {{reported, reported, reported - 1}, reported};
  return run;
}

Experiment sample() {
  Experiment experiment;
  experiment.title = "a test";
  experiment.runs.push_back(run_of(
      2, 2,
      {placement(0.2, 0.95, Outcome::kPlaced, "first"), placement(0.5, 0.9, Outcome::kPlaced, "second"),
       placement(0.9, 0.3, Outcome::kFallen, "third")}));
  experiment.runs.push_back(
      run_of(3, 1, {placement(0.1, 1.0, Outcome::kPlaced), placement(0.1, 1.0, Outcome::kNotPicked)}));
  experiment.runs[1].number = 2;
  return experiment;
}

TEST(ExperimentReport, CountsTheHeightThatTheTrueWorldHolds) {
  EXPECT_THAT(heights(sample()), testing::ElementsAre(0, 1, 1, 0, 0));
  EXPECT_EQ(reached(sample(), 2).hits, 1);
  EXPECT_THAT(experiment_table(sample()), HasSubstr("reported 3!"));
  EXPECT_THAT(experiment_table(sample()), testing::StartsWith("a test (2 done)\n"));
}

TEST(ExperimentReport, UntriedPlacementsHaveNoRate) {
  EXPECT_THAT(experiment_table(sample()), HasSubstr("stand whole after"));
  Experiment untried = sample();
  for (ExperimentRun& run : untried.runs) run.survival = {};
  EXPECT_THAT(experiment_table(untried), HasSubstr("survival was not tried"));
  EXPECT_THAT(experiment_table(untried), testing::Not(HasSubstr("stand whole after")));
}

/// Numbers to nine digits: poses become quaternions and matrices again.
nlohmann::json to_nine_digits(const nlohmann::json& value) {
  if (value.is_number_float()) return std::round(1e9 * value.get<double>());
  if (!value.is_structured()) return value;
  nlohmann::json same = value;
  for (auto& entry : same) entry = to_nine_digits(entry);
  return same;
}

TEST(ExperimentReport, WrittenFilesAreReadBack) {
  Experiment experiment = sample();
  PlacementRecord& first = experiment.runs[0].report.result.placements[0];
  first.planned.T_W_O = make_pose(Eigen::Vector3d(0.1, -0.7, 0.05), Eigen::Quaterniond(0.5, -0.5, 0.5, 0.5));
  first.T_W_O_measured = first.planned.T_W_O;
  first.planned.terms = {{"area", 0.25}, {"margin", HUGE_VAL}};
  first.note = "1 mm and 0 deg from the plan";
  first.course = 2;
  experiment.runs[0].report.result.wall = WallMetrics{3, 6, 0.4, 0.2, 0.1, 0.5, 0.8, 2, 1, 0.003, 0.07};
  experiment.runs[1].report.result.end = RunResult::End::kPlacementFailed;
  experiment.runs[1].report.result.seconds = {1.0, 2.0, 3.0, 4.0, 5.0};
  experiment.protocol = "paper";
  experiment.new_stones = 5;
  experiment.new_stones_from = "rocks";
  experiment.runs[1].report.robot = "ur10";
  experiment.runs[1].report.version = "0.1.0 (767bf62a1)";  // an experiment may go on with another program
  const std::string path = test::temporary_folder() + "experiment_to_read.json",
                    text = experiment_json(experiment);
  write_file(path, text);
  const Experiment same = read_experiment(path);
  EXPECT_EQ(to_nine_digits(nlohmann::json::parse(experiment_json(same))),
            to_nine_digits(nlohmann::json::parse(text)));
  EXPECT_EQ(experiment_table(same), experiment_table(experiment));
  EXPECT_EQ(runs_csv(same), runs_csv(experiment));
  EXPECT_EQ(same.runs[0].report.version, "");
  EXPECT_EQ(same.runs[0].report.result.placements[0].course, 2);
  ASSERT_TRUE(same.runs[0].report.result.wall.has_value());
  EXPECT_EQ(same.runs[0].report.result.wall->asked, 6);
  EXPECT_FALSE(same.runs[1].report.result.wall.has_value());
  EXPECT_EQ(same.runs[1].report.version, "0.1.0 (767bf62a1)");
}

TEST(ExperimentReport, ARunSaysWhichCellItIsFrom) {
  Experiment experiment = sample();
  experiment.runs[0].report.cell = "lab";
  experiment.runs[0].report.cell_changes = {"friction=0.2", "clearance=0.1"};
  experiment.runs[0].report.safety_checksum = "57F4285B";
  const std::string text = experiment_json(experiment);
  const nlohmann::json cell = nlohmann::json::parse(text)["runs"][0]["cell"];
  EXPECT_EQ(cell["name"], "lab");
  EXPECT_EQ(cell["changes"], (nlohmann::json{"friction=0.2", "clearance=0.1"}));
  EXPECT_EQ(nlohmann::json::parse(text)["runs"][1]["cell"]["name"], "real");
  EXPECT_THAT(run_table(experiment.runs[0].report), HasSubstr("cell lab, but friction=0.2, clearance=0.1"));
  const std::string path = test::temporary_folder() + "experiment_in_a_lab.json";
  write_file(path, text);
  const Experiment same = read_experiment(path);
  EXPECT_EQ(same.runs[0].report.cell, "lab");
  EXPECT_EQ(same.runs[0].report.cell_changes, experiment.runs[0].report.cell_changes);
  EXPECT_EQ(same.runs[0].report.safety_checksum, "57F4285B");
  EXPECT_EQ(same.runs[1].report.cell, "");
}

TEST(ExperimentReport, ARecordThatIsBrokenIsRefused) {
  const std::string path = test::temporary_folder() + "broken_experiment.json";
  const nlohmann::json whole = nlohmann::json::parse(experiment_json(sample()));
  const auto refused = [&](const nlohmann::json& broken, const std::string& part) {
    write_file(path, broken.dump());
    try {
      (void)read_experiment(path);
      ADD_FAILURE() << "read: " << part;
    } catch (const FileError& error) {
      EXPECT_THAT(error.what(), HasSubstr(part));
      EXPECT_THAT(error.what(), HasSubstr(path));
    }
  };
  for (const char* key : {"seed", "stones", "ended", "placements", "seconds", "survival"}) {
    nlohmann::json broken = whole;
    broken["runs"][0].erase(key);
    refused(broken, key);
    broken["runs"][0][key] = nullptr;
    refused(broken, key);
  }
  nlohmann::json broken = whole;
  broken["runs"][0]["placements"][0]["outcome"] = "flown away";
  refused(broken, "flown away");
  broken = whole;
  broken["runs"][0]["placements"][0]["T_W_O_planned"]["qw"] = 2.0;
  refused(broken, "quaternion");
  broken = whole;
  broken["runs"][1]["stones"][0] = 3;
  refused(broken, "stones");
  refused(nlohmann::json::array(), "stonestack.experiment/1");
}

TEST(ExperimentReport, FigureHasAMarkForEachSelectedPose) {
  const std::string csv = figure5_csv(sample());
  EXPECT_EQ(csv,
            "run,seed,level,stone,cost,held\n"
            "1,1001,1,first,0.2,1\n1,1001,2,second,0.5,1\n1,1001,3,third,0.9,0\n2,1001,1,stone,0.1,1\n");
  const std::string svg = figure5_svg(sample());
  EXPECT_THAT(svg, testing::StartsWith("<svg"));
  std::size_t rings = 0;
  for (std::size_t at = svg.find("<circle"); at != std::string::npos; at = svg.find("<circle", at + 1))
    ++rings;
  EXPECT_EQ(rings, 3u + 1u);  // and one in the legend
}

/// a, b and c stand; c is unstacked and put back, d falls and takes c with it, then c and d go up again.
Experiment with_a_return() {
  Experiment experiment;
  experiment.runs.push_back(
      run_of(4, 4,
             {placement(0.1, 0.9, Outcome::kPlaced, "a"), placement(0.1, 0.9, Outcome::kPlaced, "b"),
              placement(0.1, 0.9, Outcome::kPlaced, "c"), placement(0.0, 0.0, Outcome::kUnstacked, "c"),
              placement(0.1, 0.9, Outcome::kPlaced, "c"), placement(0.1, 0.9, Outcome::kFallen, "d"),
              placement(0.1, 0.9, Outcome::kPlaced, "c"), placement(0.1, 0.9, Outcome::kPlaced, "d")}));
  return experiment;
}

TEST(ExperimentReport, FigureShowsTheLevelThatAStoneWasMeantFor) {
  Experiment experiment = with_a_return();
  const std::string csv = figure5_csv(experiment);
  EXPECT_EQ(csv,
            "run,seed,level,stone,cost,held\n1,1001,1,a,0.1,1\n1,1001,2,b,0.1,1\n1,1001,3,c,0.1,1\n"
            "1,1001,3,c,0.1,1\n1,1001,4,d,0.1,0\n1,1001,3,c,0.1,1\n1,1001,4,d,0.1,1\n");
  auto& placements = experiment.runs[0].report.result.placements;
  const int levels[] = {1, 2, 3, 0, 3, 4, 3, 4};
  for (std::size_t i = 0; i < placements.size(); ++i) placements[i].level = levels[i];
  EXPECT_EQ(figure5_csv(experiment), csv);
  const auto json = nlohmann::json::parse(experiment_json(experiment));
  EXPECT_EQ(json["runs"][0]["placements"][4]["level"], 3);
  placements[5].level = 5;  // any value is drawn within the axes
  EXPECT_THAT(figure5_svg(experiment), HasSubstr("'middle'>5</text>"));
}

TEST(ExperimentReport, TablesForOthersHoldAnyName) {
  Experiment experiment = sample();
  ExperimentRun& run = experiment.runs.front();
  run.report.result.placements.front().stone = "grey, \"flat\"";
  run.report.result.ended = std::string(600, 'x') + " \"so\"";
  run.report.present.assign(60, "a stone of a long name");
  const std::string csv = runs_csv(experiment);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 3);
  EXPECT_THAT(csv, HasSubstr("x \"\"so\"\"\","));
  EXPECT_THAT(figure5_csv(experiment), HasSubstr("1,1001,1,\"grey, \"\"flat\"\"\",0.2,1\n"));
}

TEST(ExperimentReport, ListsTowersOnWhichTheEnginesDisagree) {
  Experiment experiment = sample();
  EXPECT_THAT(experiment_table(experiment), testing::Not(HasSubstr("engines disagree")));
  auto& truth = *experiment.runs[0].report.truth;
  truth.engines = {{"bullet", 2, 60.0, 0.0001, 0.001, ""}, {"ode", 1, 5.0, 0.03, 0.1, "stone b moved"}};
  truth.height = 1;
  truth.stands = false;
  const std::string table = experiment_table(experiment);
  EXPECT_THAT(table, HasSubstr("engines disagree (they count as far as both let them stand): 1 of 1"));
  EXPECT_THAT(table, HasSubstr("run 1: bullet 2 of 2; ode 1 of 2 (stone b moved)"));
  EXPECT_EQ(judged_height(experiment.runs[0]), 1);
  const std::string path = test::temporary_folder() + "experiment_with_engines.json";
  write_file(path, experiment_json(experiment));
  const Experiment same = read_experiment(path);
  EXPECT_EQ(experiment_table(same), table);
  const auto json = nlohmann::json::parse(experiment_json(same));
  EXPECT_EQ(json["runs"][0]["truth"]["engines_disagree"], true);
  EXPECT_EQ(json["runs"][0]["truth"]["engines"][1]["note"], "stone b moved");
  EXPECT_EQ(json["runs"][1]["truth"]["engines_disagree"], false);
}

TEST(ExperimentReport, ShowsTheHeightByThePapersProtocolBesideTheOther) {
  const Experiment experiment = with_a_return();  // four in the end, three before the first return
  EXPECT_THAT(experiment_table(experiment), HasSubstr("mean height 4.00; by the paper's protocol 3.00"));
  const auto json = nlohmann::json::parse(experiment_json(experiment));
  EXPECT_EQ(json["runs"][0]["paper_height"], 3);
  EXPECT_EQ(json["heights"], (nlohmann::json{0, 0, 0, 0, 1}));
  EXPECT_EQ(json["by_paper_protocol"]["heights"], (nlohmann::json{0, 0, 0, 1, 0}));
  EXPECT_THAT(runs_csv(experiment), HasSubstr("\n1,1001,a b,4,4,3,"));
}

TEST(ExperimentReport, JsonHoldsEveryRun) {
  const auto json = nlohmann::json::parse(experiment_json(sample()));
  EXPECT_EQ(json["schema"], "stonestack.experiment/1");
  ASSERT_EQ(json["runs"].size(), 2u);
  EXPECT_EQ(json["runs"][1]["judged_height"], 1);
  EXPECT_EQ(json["runs"][0]["survival"]["standing"][2], 1);
}

}  // namespace
}  // namespace stonestack::report
