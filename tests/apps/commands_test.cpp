#include "commands.hpp"

#include <algorithm>
#include <map>
#include <sstream>
#include <utility>

namespace stonestack {
namespace {

using ::testing::ContainsRegex;

TEST_F(Commands, RenderedStonesAreDetectedWhereTheyLie) {
  const Outcome rendered =
      run("render --out scene --seed 3 --stones limestone_1,limestone_4,limestone_6 --json");
  ASSERT_EQ(rendered.code, 0) << rendered.err;
  const Outcome detected = run("detect scene/scene.yaml --json");
  ASSERT_EQ(detected.code, 0) << detected.err;
  EXPECT_EQ(detected.data()["schema"], "stonestack.detect/1");
  std::map<std::string, Pose> truth;
  const json scene = rendered.data();
  const json seen = detected.data();
  for (const auto& stone : scene["stones"]) truth[stone["stone"]] = pose_of(stone["T_C_O"]);
  int found = 0;
  for (const auto& detection : seen["detections"]) {
    ASSERT_TRUE(truth.count(detection["stone"])) << "absent stone reported: " << detection["stone"];
    const auto error = difference(pose_of(detection["T_C_O"]), truth[detection["stone"]]);
    found += error.translation < 0.005 && error.angle < 0.0873 ? 1 : 0;
  }
  EXPECT_EQ(found, 3);
}

TEST_F(Commands, TrackReportsStonesAtRestMovedAndHeld) {
  const std::string stones = "limestone_1,limestone_4,limestone_6";
  ASSERT_EQ(run("render --out scene --seed 3 --stones " + stones).code, 0);
  const Outcome detected = run("detect scene/scene.yaml --json");
  ASSERT_EQ(detected.code, 0) << detected.err;
  json before = detected.data();
  for (auto& entry : before["detections"]) {
    double& x = *entry["T_W_O"]["x"].get_ptr<double*>();
    if (entry["stone"] == "limestone_4") x += 0.008;  // so it now lies 8 mm beside
    if (entry["stone"] == "limestone_6") *entry["T_W_O"]["z"].get_ptr<double*>() += 0.05;
  }
  write("before.json", before.dump());
  const Outcome tracked = run("track scene/scene.yaml --expect before.json --json");
  ASSERT_EQ(tracked.code, 0) << tracked.err;
  std::map<std::string, json> found;
  const json data = tracked.data();
  for (const auto& entry : data["tracked"]) found[entry["stone"]] = entry;
  EXPECT_EQ(found["limestone_1"]["status"], "in place");
  EXPECT_EQ(found["limestone_4"]["status"], "moved");
  EXPECT_NEAR(found["limestone_4"]["moved_m"].get<double>(), 0.008, 0.001);
  EXPECT_EQ(found["limestone_6"]["status"], "fallen");
  EXPECT_NEAR(found["limestone_6"]["moved_m"].get<double>(), 0.05, 0.001);
  const Outcome held = run("track scene/scene.yaml --expect before.json --held limestone_4,limestone_6");
  EXPECT_EQ(held.code, 0) << held.err;
  EXPECT_THAT(held.out, ::testing::Not(HasSubstr("limestone_4")));
  EXPECT_THAT(run("track scene/scene.yaml --expect scene/scene.yaml").out, HasSubstr("in place"));
  expect_refusal("track scene/cloud.ply --expect before.json", 3, {"cloud.ply", "--camera-pose"});
  write("empty.json", "{}");
  expect_refusal("track scene/scene.yaml --expect empty.json", 3, {"empty.json", "detections"});
}

TEST_F(Commands, SearchesAndPlansFromFiles) {
  ASSERT_EQ(run("render --out scene --seed 5 --stones limestone_1,limestone_2,limestone_3").code, 0);
  const Outcome searched =
      run("search scene/cloud.ply --camera-pose scene/scene.yaml --robot ur10 --json --set search.rounds=1");
  ASSERT_EQ(searched.code, 0) << searched.err;
  const json found = searched.data();
  EXPECT_EQ(found["schema"], "stonestack.search/1");
  ASSERT_EQ(found["placements"].size(), 1u);
  for (const char* term : {"area", "kinetic_energy", "distance", "normal"})
    EXPECT_TRUE(found["placements"][0]["terms"].contains(term)) << term;
  EXPECT_NEAR(found["placements"][0]["T_W_O"]["x"], 0.70, 0.06);
  write("next.json", searched.out);
  const Outcome planned = run("plan scene/scene.yaml --search next.json --json --csv motion.csv");
  ASSERT_EQ(planned.code, 0) << planned.err;
  EXPECT_TRUE(fs::exists(folder_ + "/motion.csv"));
  // A target that cannot be is passed over for an alternative that can.
  json other = found;
  other["alternatives"].insert(other["alternatives"].begin(), found["placements"][0]);
  other["placements"][0]["T_W_O"]["x"] = 9.0;
  write("other.json", other.dump());
  const Outcome second = run("plan scene/scene.yaml --search other.json --json");
  ASSERT_EQ(second.code, 0) << second.err;
  EXPECT_EQ(second.data()["T_W_O"], planned.data()["T_W_O"]);
  other.erase("alternatives");
  write("other.json", other.dump());
  expect_refusal("plan scene/scene.yaml --search other.json", 6, {"no plan", "search --robot"});
}

/// A stone as `render --seed 5` lays it down, carried over to the site and turned by nothing.
constexpr const char* kLying =
    "schema: stonestack.scene/1\nstones:\n  - stone: limestone_3\n    T_W_O: {x: 0.8779, y: -0.3412, z: "
    "0.04204, "
    "qx: 0.3275739, qy: 0.9444004, qz: -0.017231, qw: 0.0225038}\n";
constexpr const char* kTurned = "0.3275739,0.9444004,-0.017231,0.0225038";

/// Accelerations as a reader of the CSV works them out, from second differences of the angles, keep 1.4
/// rad/s^2.
void expect_smooth_samples(const std::string& csv) {
  std::istringstream lines(csv);
  std::string line;
  std::getline(lines, line);
  double max = 0.0, before[2][8] = {};
  int step_of[2] = {-1, -1};
  while (std::getline(lines, line)) {
    int step = 0;
    double now[8] = {};
    ASSERT_EQ(std::sscanf(line.c_str(), "%d,%*[a-z],%lf,%lf,%lf,%lf,%lf,%lf,%lf", &step, now, now + 1,
                          now + 2, now + 3, now + 4, now + 5, now + 6),
              8)
        << line;
    const bool even = std::abs(now[0] - 2 * before[1][0] + before[0][0]) < 1e-9;  // not the last sample
    if (step_of[0] == step && step_of[1] == step && even)
      for (int j = 1; j <= 6; ++j)
        max = std::max(max, std::abs(now[j] - 2 * before[1][j] + before[0][j]) / (0.008 * 0.008));
    std::copy(before[1], before[1] + 8, before[0]);
    std::copy(now, now + 8, before[1]);
    step_of[0] = std::exchange(step_of[1], step);
  }
  EXPECT_GT(max, 1.0);
  EXPECT_LE(max, 1.4 * 1.0001);
}

TEST_F(Commands, PlanDrawsWhatItWillDo) {
  write("lying.yaml", kLying);
  const Outcome planned =
      run(concat("plan lying.yaml --stone limestone_3 --target 0.7,0.28,0.043,", kTurned,
                 " --json --csv motion.csv --plot motion.svg --frames frames --frame-width 64"));
  ASSERT_EQ(planned.code, 0) << planned.err;
  const json data = planned.data();
  std::size_t motions = 0;
  for (const auto& step : data["steps"]) motions += step["trajectory"].empty() ? 0 : 1;
  const auto pictures = std::distance(fs::directory_iterator(folder_ + "/frames"), fs::directory_iterator());
  EXPECT_EQ(pictures, static_cast<long>(motions) + 1);
  EXPECT_TRUE(fs::exists(folder_ + "/frames/03_lift.png"));
  EXPECT_THAT(read_file(folder_ + "/motion.svg", 1 << 22), HasSubstr("lift limestone_3"));
  const std::string csv = read_file(folder_ + "/motion.csv", 1 << 22);
  EXPECT_THAT(csv, HasSubstr(",descent,"));
  expect_smooth_samples(csv);
}

TEST_F(Commands, AGripperTooHeavyForTheArmIsRefusedAtOnce) {
  write("lying.yaml", kLying);
  expect_refusal("search lying.yaml --robot ur3", 6,
                 {"no stone of the scene can be carried", "ur3 carries 3 kg"});
  const std::string there =
      R"({"stone": "limestone_3", "T_W_O": {"x": 0.7, "y": 0.28, "z": 0.043, "qx": 0, "qy": 0, "qz": 0, "qw": 1}})";
  write("next.json", concat("{\"placements\": [", there, "], \"alternatives\": [", there, "]}"));
  const Outcome planned = run("plan lying.yaml --robot ur3 --search next.json");
  EXPECT_EQ(planned.code, 6);
  const std::size_t once = planned.err.find("ur3 carries 3 kg");
  ASSERT_NE(once, std::string::npos) << planned.err;
  EXPECT_EQ(planned.err.find("ur3 carries 3 kg", once + 1), std::string::npos) << planned.err;
}

TEST_F(Commands, PlanStaysClearOfTheObstaclesOfTheScene) {
  const std::string plan =
      concat("plan walled.yaml --stone limestone_3 --target 0.7,0.28,0.043,", kTurned, ' ');
  const auto wall = [&](const std::string& box, const std::string& at) {
    write("walled.yaml", concat(kLying, "obstacles:\n  - {name: wall, box: ", box, ", T_W_O: {", at,
                                ", qx: 0, qy: 0, qz: 0, qw: 1}}\n"));
    return run(plan);
  };
  const Outcome beside = wall("{x: 0.5, y: 0.02, z: 0.25}", "x: 0.8, y: 0.0, z: 0.125");
  EXPECT_EQ(beside.code, 0) << beside.err;
  const Outcome over = wall("{x: 0.4, y: 0.4, z: 0.05}", "x: 0.7, y: 0.28, z: 0.25");
  EXPECT_EQ(over.code, 6) << "a shelf over the target: " << over.err;
  const Outcome wrong = wall("{x: 0.4, y: 0.4}", "x: 0.7, y: 0.28, z: 0.25");
  EXPECT_EQ(wrong.code, 3);
  EXPECT_THAT(wrong.err, HasSubstr("obstacles[0].box.z is missing"));
}

TEST_F(Commands, PlanTakesRobotAndLayoutOfACell) {
  write("lying.yaml", kLying);
  const auto with = [&](const std::string& layout, const std::string& more = "") {
    write("cell.yaml", concat("robot: ur10\nlayout:\n", layout));
    return concat("plan lying.yaml --cell cell.yaml --stone limestone_3 --target 0.7,0.28,0.043,", kTurned,
                  ' ', more);
  };
  const std::string lamp =
      "  obstacles: [{name: lamp, sphere: {radius: 0.1}, T_W_O: {x: 1.0, y: 0.3, z: 0.6, qx: 0, qy: 0, qz: "
      "0, "
      "qw: 1}}]\n";
  const Outcome under = run(with(lamp));
  EXPECT_EQ(under.code, 0) << under.err;
  expect_refusal(with(lamp + "  padding: [{a: hand, b: lamp, m: 0.7}]\n"), 6, {"no plan"});
  expect_refusal(with(lamp + "  padding: [{a: hand, b: lmp, m: 0.7}]\n"), 3,
                 {"layout.padding[0]", "lmp", "table, lamp"});
  expect_refusal(with("  sensor_mass: 8\n"), 6, {"kg"});
  expect_refusal(with(lamp, "--robot ur5"), 2, {"--robot ur5", "cell.yaml", "ur10"});
  expect_refusal(
      concat("plan lying.yaml --cell no_such.yaml --stone limestone_3 --target 0.7,0.28,0.043,", kTurned), 3,
      {"no_such.yaml", "loopback-ur10"});
}

TEST_F(Commands, PlanStartsAtTheGivenJoints) {
  write("lying.yaml", kLying);
  const auto from = [&](const std::string& start) {
    return concat("plan lying.yaml --stone limestone_3 --target 0.7,0.28,0.043,", kTurned, " --json --start ",
                  start);
  };
  const Outcome planned = run(from("0.5,-1.75,1.85,-1.67,-1.5,0.1"));
  ASSERT_EQ(planned.code, 0) << planned.err;
  const json planned_data = planned.data();
  for (const auto& step : planned_data["steps"]) {
    if (step["trajectory"].empty()) continue;
    EXPECT_EQ(step["trajectory"][0]["q"], json({0.5, -1.75, 1.85, -1.67, -1.5, 0.1}));
    break;
  }
  expect_refusal(from("0.5,-1.75"), 2, {"2 numbers", "q1,q2,q3,q4,q5,q6 in rad"});
  expect_refusal(from("0.5,-1.75,1.85,-1.67,x,0"), 2, {"'x'"});
  expect_refusal(from("30,-90,90,-90,-90,0"), 2, {"joint 1 at 30 rad", "not degrees"});
}

TEST_F(Commands, PlanNamesTheFolderThatCannotTakePictures) {
  write("lying.yaml", kLying);
  write("taken", "a file");
  const Outcome refused = run(concat("plan lying.yaml --stone limestone_3 --target 0.7,0.28,0.043,", kTurned,
                                     " --frames taken/frames --frame-width 64"));
  EXPECT_EQ(refused.code, 3) << refused.err;
  EXPECT_THAT(refused.err, HasSubstr("taken/frames/00_start.png: cannot be written"));
}

TEST_F(Commands, PlanReportsImpossibleRequests) {
  write("lying.yaml", kLying);
  const auto plan = [&](const std::string& target, const std::string& more = "") {
    return concat("plan lying.yaml --stone limestone_3 --target ", target, ',', kTurned, ' ', more);
  };
  expect_refusal(plan("2.5,0.28,0.043"), 6, {"limestone_3", "from the robot's shoulder"});
  expect_refusal(plan("0.7,0.28,-0.05"), 6, {"limestone_3", "into the table"});
  expect_refusal(plan("nan,0.28,0.05"), 2, {"nan"});
  expect_refusal(concat("plan lying.yaml --stone limestone_9999 --target 0.7,0.28,0.1,", kTurned), 2,
                 {"limestone_9999"});
  expect_refusal("plan lying.yaml", 2, {"--target"});
  expect_refusal(plan("0.7,0.28,0.043", "--robot no_such_arm"), 3, {"no_such_arm", "ur10"});
  write("loop.urdf",
        "<robot name='x'><link name='a'/><link name='b'/><joint name='j' type='fixed'><parent link='a'/>"
        "<child link='b'/></joint><joint name='k' type='fixed'><parent link='b'/><child "
        "link='a'/></joint></robot>");
  expect_refusal(plan("0.7,0.28,0.043", "--robot loop.urdf"), 3, {"loop.urdf"});
}

TEST_F(Commands, SameSeedSameTowerForAnyThreads) {
  const std::string arguments =
      "search --stones limestone_1,limestone_2 --json --seed 4 --set search.threads=";
  const Outcome one = run(arguments + "1");
  const Outcome two = run(arguments + "2");
  ASSERT_EQ(one.code, 0) << one.err;
  EXPECT_EQ(one.out, two.out);
}

TEST_F(Commands, RunBuildsWhatItsTrueWorldHolds) {
  const std::string arguments = "run --robot ur10 --seed 1 --per-run 3 --height 2 --json --out run";
  const Outcome first = run(arguments);
  ASSERT_TRUE(first.code == 0 || first.code == 6) << first.err;
  EXPECT_THAT(first.err, HasSubstr("tower: 0 of 2 stones")) << "three lie there, two are asked for";
  json result = first.data();
  EXPECT_EQ(result["schema"], "stonestack.run/1");
  EXPECT_EQ(result["version"].get<std::string>() + "\n", run("--version").out);
  EXPECT_GE(result["height"], 1);
  EXPECT_GE(result["truth"]["height"], result["height"]) << "the run reports a tower that does not stand";
  for (const char* file : {"tower.png", "report.html", "result.json", "options.yaml", "journal.jsonl"})
    EXPECT_TRUE(fs::exists(folder_ + "/run/" + file)) << file;
  expect_refusal(arguments, 2, {"run", "holds a run already"});
  json again = run(arguments + "_again --set search.threads=1").data();
  result.erase("seconds");
  again.erase("seconds");
  EXPECT_EQ(result, again) << "same seed, other tower";
}

TEST_F(Commands, StonesThatTheGripperCannotCarryAreNotDrawnAndNamed) {
  const std::string rocks = " --catalogue " + folder_ + "/rocks ";
  ASSERT_EQ(run("scan --generate 2" + rocks).code, 0);
  const Outcome heavy =
      run("scan " + folder_ + "/rocks/limestone_1/scan.ply --name heavy --mass 2.8" + rocks);
  ASSERT_EQ(heavy.code, 0);
  EXPECT_NE(heavy.err.find("heavy: the gripper will not pick it up: 2.8 kg, the fingers carry 2.5 kg"),
            std::string::npos)
      << heavy.err;
  const Outcome done = run("simulate --per-run 3 --seconds 0.1" + rocks);
  EXPECT_NE(done.err.find(
                "not drawn, for gripper or arm cannot hold them: heavy (2.8 kg, the fingers carry 2.5 kg)"),
            std::string::npos)
      << done.err;
}

/// Time of the simulated devices against that of the host.
const std::string kQuickly = " --set simulators.arm.speed=2";

TEST_F(Commands, BuildsThroughTheRealBackends) {
  const std::string cell = std::string(STONESTACK_SOURCE_DIR) + "/data/cells/loopback-ur10.yaml";
  const Outcome done =
      run("run --robot ur10 --cell " + cell + " --per-run 2 --height 1 --seed 1 --json --out run" + kQuickly);
  ASSERT_EQ(done.code, 0) << done.err;
  const json result = done.data();
  EXPECT_EQ(result["height"], 1);
  EXPECT_GE(result["truth"]["height"], 1) << "the run reports a tower that does not stand";
  EXPECT_THAT(done.err, HasSubstr("RTDE"));
  EXPECT_EQ(result["cell"]["safety_checksum"], "2F0B1D6A") << "as the simulated controller says it";
}

TEST_F(Commands, RunMovesNothingWithAnotherSafetyConfiguration) {
  write("cell.yaml",
        "simulate: true\narm: {safety_checksum: 57F4285B}\nsimulators:\n"
        "  arm: {standard_ports: false}\n  gripper: {port: 0}\n"
        "  force_torque: {port: 0, command_port: 0}\n  camera: {port: 0}\n");
  const Outcome refused = run("run --cell cell.yaml --per-run 1 --seed 1 --out run");
  EXPECT_EQ(refused.code, 6) << refused.err;
  EXPECT_THAT(refused.err,
              testing::AllOf(HasSubstr("57F4285B"), HasSubstr("2F0B1D6A"), HasSubstr("on the pendant")));
}

// A UR10e with its own force sensor: the weights and contacts of the run come over RTDE.
TEST_F(Commands, BuildsWithTheArmsOwnForceSensor) {
  const std::string cell = std::string(STONESTACK_SOURCE_DIR) + "/data/cells/loopback-ur10e.yaml";
  const Outcome done =
      run("run --cell " + cell + " --per-run 1 --height 1 --seed 1 --json --out run" + kQuickly);
  ASSERT_EQ(done.code, 0) << done.err;
  EXPECT_EQ(done.data()["height"], 1);
  EXPECT_GE(done.data()["truth"]["height"], 1) << "the run reports a tower that does not stand";
  EXPECT_THAT(done.err, ::testing::Not(HasSubstr("\nforce sensor "))) << "no other sensor is served";
}

TEST_F(Commands, RunMovesNoRealArmUnlessRequested) {
  write("lab.yaml", "arm: {address: 192.0.2.1}\n");
  expect_refusal("run --cell lab.yaml", 2, {"192.0.2.1", "--execute"});
}

TEST_F(Commands, RefuseBadInputWithOneLine) {
  expect_refusal("frobnicate", 2, {"unknown command 'frobnicate'", "search"});
  expect_refusal("bench rtde", 2, {"unknown command 'bench'"});
  expect_refusal("run --cell nowhere", 3, {"nowhere", "loopback-ur10"});
  expect_refusal("run --robot kuka", 3, {"kuka", "ur10"});
  expect_refusal("run --catalogue nowhere", 3, {"nowhere"});
  fs::create_directories(folder_ + "/empty");
  expect_refusal("run --catalogue empty", 3, {"empty"});
  expect_refusal("search missing.ply", 3, {"missing.ply"});
  expect_refusal("search --stones limestone_1,no_stone", 2, {"no_stone"});
  write("empty.yaml", "schema: stonestack.scene/1\n");
  expect_refusal("search empty.yaml", 3, {"empty.yaml", "no stones"});
  write("options.yaml", "search:\n  fricton: 0.3\n");
  expect_refusal("run --config options.yaml", 3, {"options.yaml", "search.fricton", "search.friction"});
  expect_refusal("run --set search.friction=7", 2, {"search.friction", "2], got 7"});
  write("nan.ply",
        "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float "
        "z\nend_header\nnan 0 0\n");
  expect_refusal("detect nan.ply", 3, {"nan.ply"});
  EXPECT_FALSE(fs::exists(folder_ + "/runs")) << "a refused run left something behind";
}

TEST_F(Commands, CellFilesAreListedWithTheirDefaults) {
  const Outcome shown = run("config cell --expert > cell.yaml");
  ASSERT_EQ(shown.code, 0) << shown.err;
  const std::string text = read_file(folder_ + "/cell.yaml", 1 << 20);
  EXPECT_THAT(text, HasSubstr("\narm.rtde_port: 30004  # [0, 65535]"));
  EXPECT_THAT(text, HasSubstr("\nsimulators.arm.faults.local_mode: false"));
  write("ill.yaml", "arm: {rtde_port: 99999}\n");
  expect_refusal("doctor --cell ill.yaml", 3, {"ill.yaml", "arm.rtde_port", "config cell"});
}

TEST_F(Commands, ConfigShowsWhatWon) {
  write("stonestack.yaml", "search:\n  friction: 0.3\n");
  const Outcome shown = run("config show --origin --set search.beam=5");
  ASSERT_EQ(shown.code, 0) << shown.err;
  EXPECT_THAT(shown.out, HasSubstr("search.friction: 0.3  # project file stonestack.yaml"));
  EXPECT_THAT(shown.out, HasSubstr("search.beam: 5  # flag --set"));
  EXPECT_THAT(shown.out, HasSubstr("search.seed: 1  # default"));
}

TEST_F(Commands, ConfigShowsExpertOptionsOnRequest) {
  const std::string users = run("config show").out, all = run("config show --expert").out;
  EXPECT_THAT(users, HasSubstr("search.friction: 0.1  # [0.001, 2] coefficient between stones"));
  EXPECT_THAT(users, ::testing::Not(HasSubstr("search.beam")));
  EXPECT_THAT(all, HasSubstr("search.friction: 0.1"));
  EXPECT_THAT(all, HasSubstr("search.beam: 4"));
  EXPECT_THAT(run("config cell").out, ::testing::Not(HasSubstr("faults")));
  EXPECT_THAT(run("config cell --expert").out, HasSubstr("simulators.arm.faults.local_mode: false"));
  expect_refusal("run --set search.baem=5", 2, {"search.baem", "did you mean search.beam"});
}

TEST_F(Commands, TheFileThatConfigShowWritesServesEveryCommand) {
  ASSERT_EQ(run("config show --expert > stonestack.yaml").code, 0);
  EXPECT_EQ(run("render --out scene --seed 3 --stones limestone_1,limestone_4").code, 0);
  const Outcome detected = run("detect scene/scene.yaml --json");
  EXPECT_EQ(detected.code, 0) << detected.err;
  const Outcome searched = run("search --stones limestone_1 --json");
  EXPECT_EQ(searched.code, 0) << searched.err;
  const Outcome flags = run("config show --origin --set search.seed=9");
  EXPECT_THAT(flags.out, HasSubstr("search.seed: 9"));
  const Outcome paper = run("run --per-run 1 --method paper --seed 7 --out run");
  const std::string used = read_file(folder_ + "/run/options.yaml", 1 << 20);
  EXPECT_THAT(used, HasSubstr("search.method: paper")) << "the file beat the flag";
  EXPECT_THAT(used, HasSubstr("simulation.seed: 7")) << "the file beat the flag";
  write("other.yaml", "search.friction: 9\n");
  expect_refusal("detect scene/scene.yaml --config other.yaml", 3,
                 {"other.yaml", "search.friction", "got 9"});
}

TEST_F(Commands, CheckReportsHowFirmlyAPlannedStoneRests) {
  const Outcome planned = run("search --stones limestone_1 --out tower.yaml --trace trace --json");
  ASSERT_EQ(planned.code, 0) << planned.err;
  EXPECT_THAT(read_file(folder_ + "/trace/candidates.json", 1 << 26), HasSubstr("stonestack.trace/1"));
  const Outcome checked = run("check tower.yaml --friction 0.3 --seconds 2 --json --picture tower.png");
  ASSERT_EQ(checked.code, 0) << checked.err;
  const json data = checked.data();
  EXPECT_EQ(data["schema"], "stonestack.check/1");
  EXPECT_TRUE(data["stands"].get<bool>());
  EXPECT_TRUE(data["clean"].get<bool>());
  EXPECT_LT(data["shift_m"].get<double>(), 0.001);
  EXPECT_GT(data["margin_g"].get<double>(), 0.05);
  EXPECT_LE(data["margin_g"].get<double>(), 0.3);  // no more than the friction
  EXPECT_LT(data["min_friction"].get<double>(), 0.01);
  EXPECT_EQ(data["weakest_contact"]["below"], "the table");
  EXPECT_TRUE(fs::exists(folder_ + "/tower.png"));
}

TEST_F(Commands, CheckRefusesImpossibleStacksAndReportsFalls) {
  const auto stack = [&](double z) {
    const std::string pose = "{x: 0.7, y: 0.28, z: ";
    write("stack.yaml", concat("schema: stonestack.scene/1\nstack:\n  - {stone: limestone_1, T_W_O: ", pose,
                               "0.1, qx: 0, qy: 0, qz: 0, qw: 1}}\n  - {stone: limestone_2, T_W_O: ", pose, z,
                               ", qx: 0, qy: 0, qz: 0, qw: 1}}\n"));
  };
  stack(0.12);
  expect_refusal("check stack.yaml", 3, {"stack.yaml", "limestone_1 and limestone_2 overlap by"});
  stack(0.6);
  const Outcome falls = run("check stack.yaml --seconds 1 --json");
  EXPECT_EQ(falls.code, 5) << falls.err;
  EXPECT_FALSE(falls.data()["stands"].get<bool>());
  EXPECT_THAT(falls.err, HasSubstr("does not stand"));
  expect_refusal("check stack.yaml --friction 0", 2, {"--friction"});
  expect_refusal("check stack.yaml --friction nan", 2, {"friction"});
  expect_refusal("check missing.yaml", 3, {"missing.yaml"});
}

TEST_F(Commands, CtrlCEndsARunAfterItsFirstSearchAndKeepsTheRecord) {
  const Outcome outcome = shell(interrupted_at(folder_, "run --seed 7 --out record", "level 1:"));
  EXPECT_THAT(outcome.out, HasSubstr("code 130")) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("interrupted by the user"));
  EXPECT_THAT(outcome.err, testing::Not(HasSubstr("level 4:")));
  EXPECT_THAT(read_file(folder_ + "/record/journal.jsonl", 1 << 20), HasSubstr("observed"));
  EXPECT_TRUE(fs::exists(folder_ + "/record/result.json"));
}

}  // namespace
}  // namespace stonestack
