#include <map>
#include <sstream>
#include <string>

#include "bench_command.hpp"

namespace stonestack::bench {
namespace {

TEST_F(BenchCommand, RtdeCountsEverySample) {
  const Outcome bench = run("rtde --seconds 1 --rate 125 --json");
  ASSERT_EQ(bench.code, 0) << bench.err;
  const json result = bench.data();
  EXPECT_EQ(result["schema"], "stonestack.bench/1");
  EXPECT_EQ(result["benchmark"], "rtde");
  EXPECT_EQ(result["settings"]["rate_hz"], 125.0);
  const json found = rows_of(result, "rtde")[0];
  EXPECT_GT(found["samples"].get<int>(), 10);
  EXPECT_EQ(found["refused"], 0);
  EXPECT_GT(found["server_cpu_percent"].get<double>(), 0.0);
}

TEST_F(BenchCommand, AStoneBehindAnUnfoundOneIsFoundWithIt) {
  // Two stones of this stack are refused one by one: each hides a part of the other.
  const Outcome bench = run("detection --seed 2001 --scenes 1 --kinds stacked --json");
  ASSERT_EQ(bench.code, 0) << bench.err;
  const json found = rows_of(bench.data(), "detection")[0];
  EXPECT_EQ(found["present"], 4);
  EXPECT_EQ(found["right"], 4);
}

TEST_F(BenchCommand, AStoneSeenInAMirrorIsNotFound) {
  const Outcome bench = run("detection --seed 90817 --kinds mirrored --first 6 --scenes 1 --json");
  ASSERT_EQ(bench.code, 0) << bench.err;
  const json found = rows_of(bench.data(), "detection")[0];
  EXPECT_EQ(found["absent"], 6);
  EXPECT_EQ(found["false"], 0) << "another stone, which fits the mirror image with 0.875";
}

TEST_F(BenchCommand, StonesModelledFromViewsAreFoundWhereTheScannedStonesLie) {
  ASSERT_EQ(run_stonestack("scan --generate 2 --seed 3 --catalogue two").code, 0);
  const std::string common = "detection --catalogue two --seed 4 --kinds isolated --scenes 8 --json";
  const Outcome bench = run(common + " --attitudes 1"), of_scans = run(common);
  ASSERT_EQ(bench.code, 0) << bench.err;
  ASSERT_EQ(of_scans.code, 0) << of_scans.err;
  EXPECT_EQ(bench.data()["settings"]["attitudes"], 1);
  const json found = rows_of(bench.data(), "detection")[0];
  const json scanned = rows_of(of_scans.data(), "detection")[0];
  EXPECT_EQ(found["present"], 16);
  EXPECT_EQ(scanned["right"], 16);
  EXPECT_GE(found["right"].get<int>(), 6) << "within 5 deg and 5 mm of the scanned stones";
  EXPECT_LT(found["right"].get<int>(), 16) << "some show a side that no view has seen";
  EXPECT_LE(found["wrong"].get<int>(), 1);
}

/// Each at its smallest. `detection` and `rtde` have tests of their own.
TEST_F(BenchCommand, EveryBenchmarkReportsTablesAsData) {
  const std::map<std::string, std::string> tables{
      {"kinematics --poses 20", "random poses"},
      {"collision --configurations 20", "against exact distances (CGAL)"},
      {"cartesian --poses 20 --robot ur10", "straight motions with both ends in reach"},
      {"timing --paths 3", "timing"},
      {"equilibrium --stacks 2 --stones 2 --generated 3 --scans none --seconds 0.1", "verdicts"},
      {"search --draws 1 --stones 1 --generated 2 --scans none --paper 0 --stand 0.1", "towers"},
      {"calibration --placements 2 --stones 1 --repeats 1 --generated 2 --scans none", "generated"},
      {"tasks --draws 1 --stones 3 --generated 4 --scans none --folder one_task --stand 0.1", "tasks"},
      {"push --pushes 3 --cell mild", "pushes by how far the stone was to move"}};
  write_file(folder_ + "/one_task/reach.yaml",
             "schema: stonestack.target/1\nspans: [{from: 0, to: 0.03, clear: 0.1}]\n"
             "supports: [{from: -0.2, to: 0, height: 0.1}]\non_table: false\n");
  for (const auto& [arguments, table] : tables) {
    const Outcome bench = run(arguments + " --json --seed 3");
    ASSERT_EQ(bench.code, 0) << arguments << bench.err;
    const json result = bench.data();
    EXPECT_EQ(result["schema"], "stonestack.bench/1") << arguments;
    EXPECT_EQ(result["benchmark"], arguments.substr(0, arguments.find(' ')));
    EXPECT_EQ(result["settings"]["seed"], 3) << arguments;
    EXPECT_EQ(result["complete"], true) << arguments;
    const json rows = rows_of(result, table);
    ASSERT_TRUE(rows.is_array() && !rows.empty()) << arguments << bench.out;
  }
}

TEST_F(BenchCommand, LiftsDrawnStonesInAnySimulatedCell) {
  const std::string lifts = "hold --generated 2 --picks 1 --pads-only --seed 4 --json";
  const Outcome usual = run(lifts), slippery = run(lifts + " --set simulation.pad_friction=0.05");
  ASSERT_EQ(usual.code, 0) << usual.err;
  ASSERT_EQ(slippery.code, 0) << slippery.err;
  const auto all = [](const Outcome& bench) {
    return rows_of(bench.data(), "grasps chosen by pressed pads").back();
  };
  EXPECT_EQ(all(usual)["tried"], 2);
  EXPECT_EQ(all(usual)["not_held"], 0);
  EXPECT_GE(all(slippery)["not_held"].get<int>(), 1);
  EXPECT_TRUE(rows_of(usual.data(), "grasps chosen by three contacts").is_null());
}

TEST_F(BenchCommand, AFolderWithoutScansIsNamed) {
  const Outcome bench = run("search --draws 1 --generated 0 --paper 0 --scans .");
  EXPECT_EQ(bench.code, 3);
  EXPECT_THAT(bench.err, HasSubstr("holds no OBJ file"));
}

TEST_F(BenchCommand, EveryBenchmarkTakesJson) {
  const Outcome list = run("--help");
  std::istringstream lines(list.out.substr(list.out.find("Subcommands:")));
  std::string line, name;
  std::getline(lines, line);
  int count = 0;
  for (; std::getline(lines, line) && line.starts_with("  "); ++count) {
    if (line.starts_with("   ")) continue;  // the description goes on
    std::istringstream(line) >> name;
    if (name == "results") continue;  // prints a page
    EXPECT_THAT(run(name + " --help").out, HasSubstr("--json")) << name;
  }
  EXPECT_GE(count, 14) << list.out;
}

TEST_F(BenchCommand, ARecordHoldsTheResultAndItsCommand) {
  const Outcome bench = run("kinematics --poses 20 --json --record record.json");
  ASSERT_EQ(bench.code, 0) << bench.err;
  const json record = json::parse(read_file(folder_ + "/record.json", 1U << 20U));
  EXPECT_EQ(record["command"], "bench kinematics --poses 20 --json --record record.json");
  EXPECT_EQ(record["tables"], bench.data()["tables"]);
  EXPECT_EQ(record["settings"], bench.data()["settings"]);
}

TEST_F(BenchCommand, RefusesWhatItDoesNotKnow) {
  expect_refusal("frobnicate", 2, {"unknown command 'frobnicate'", "kinematics"});
  expect_refusal("kinematics --poses 0", 2, {"--poses"});
}

}  // namespace
}  // namespace stonestack::bench
