// What `stonestack calibrate` does with stations that are none.
#include <sstream>

#include "commands.hpp"
#include "core/constants.hpp"
#include "stonestack/emulators/simulated_servers.hpp"
#include "stonestack/hardware/cell_file.hpp"

namespace stonestack {
namespace {

class CalibrateCommand : public Commands {
 protected:
  void SetUp() override {
    Commands::SetUp();
    ASSERT_EQ(run("calibrate --simulate 12 --seed 3 --write-pairs pairs.yaml --out good.yaml").code, 0);
    std::istringstream lines(read_file(folder_ + "/pairs.yaml", 1 << 20));
    for (std::string line; std::getline(lines, line);)
      (line.find("T_R_F") == std::string::npos ? head_ : stations_.emplace_back()) += line + "\n";
  }
  /// The first `count` stations, each with the target as the station `shift` further on saw it.
  void write_stations(const std::string& name, std::size_t count, std::size_t shift) const {
    std::string text = head_;
    for (std::size_t i = 0; i < count; ++i) {
      const std::string &arm = stations_[i], &target = stations_[(i + shift) % count];
      text += arm.substr(0, arm.find("T_C_B")) + target.substr(target.find("T_C_B"));
    }
    write(name, text);
  }

  std::string head_;
  std::vector<std::string> stations_;
};

TEST_F(CalibrateCommand, DoesNotWriteWhatDoesNotAgreeWithItsStations) {
  write_stations("shuffled.yaml", stations_.size(), 5);
  const Outcome seen = run("calibrate shuffled.yaml --json");
  EXPECT_EQ(seen.code, 0) << "looking is allowed";
  EXPECT_EQ(seen.data()["warnings"].size(), 1U) << seen.out;
  expect_refusal("calibrate shuffled.yaml -q --out bad.yaml", 3,
                 {"shuffled.yaml", "bad.yaml", " mm", "--force"});
  EXPECT_FALSE(fs::exists(folder_ + "/bad.yaml"));
  EXPECT_EQ(run("calibrate shuffled.yaml --out bad.yaml --force").code, 0);
  EXPECT_TRUE(fs::exists(folder_ + "/bad.yaml"));
  EXPECT_EQ(run("calibrate pairs.yaml --out fine.yaml --json").data()["warnings"].size(), 0U);
}

TEST_F(CalibrateCommand, DoesNotWriteAnInvertedResult) {
  std::string text = head_;
  for (const auto& station : stations_) {
    double v[7];
    ASSERT_EQ(std::sscanf(station.c_str(),
                          " - {T_R_F: {x: %lf, y: %lf, z: %lf, qx: %lf, qy: %lf, qz: %lf, qw: %lf}", v, v + 1,
                          v + 2, v + 3, v + 4, v + 5, v + 6),
              7);
    const Pose T_F_R = make_pose({v[0], v[1], v[2]}, Eigen::Quaterniond(v[6], v[3], v[4], v[5])).inverse();
    text += concat("  - {T_R_F: ", to_text(T_F_R), ", ", station.substr(station.find("T_C_B")));
  }
  write("inverted.yaml", text);
  expect_refusal("calibrate inverted.yaml -q --out bad.yaml", 3, {"inverted.yaml", "inverted", "--force"});
  EXPECT_FALSE(fs::exists(folder_ + "/bad.yaml"));
}

TEST_F(CalibrateCommand, WritesIntoACell) {
  write("cell.yaml", "robot: ur10  # mine\nlayout:\n  T_F_T: {z: 0.3}\n");
  ASSERT_EQ(run("calibrate pairs.yaml --write cell.yaml").code, 0);
  EXPECT_THAT(
      read_file(folder_ + "/cell.yaml", 1 << 16),
      testing::AllOf(HasSubstr("robot: ur10  # mine\nlayout:\n  T_T_C: {x: "), HasSubstr("z: -0.20")));
  // With --out the cell names the file, and takes over what stands there from then on.
  write("cell.yaml", "robot: ur10\n");
  const Outcome both = run("calibrate pairs.yaml --out eyes/mine.yaml --write cell.yaml");
  EXPECT_THAT(both.err, HasSubstr("layout.hand_eye: eyes/mine.yaml"));
  EXPECT_EQ(read_file(folder_ + "/cell.yaml", 1 << 16), "robot: ur10\nlayout:\n  hand_eye: eyes/mine.yaml\n");
  // Nothing is written of a calibration that is none, or of a camera beside the arm.
  write_stations("shuffled.yaml", stations_.size(), 5);
  write("cell.yaml", "robot: ur10\n");
  expect_refusal("calibrate shuffled.yaml -q --write cell.yaml", 3, {"cell.yaml", "--force"});
  expect_refusal("calibrate --simulate 12 --on-base -q --write cell.yaml", 2,
                 {"cell.yaml", "beside the arm"});
  expect_refusal("calibrate pairs.yaml -q --write none.yaml", 3, {"none.yaml"});
  EXPECT_EQ(read_file(folder_ + "/cell.yaml", 1 << 16), "robot: ur10\n");
}

TEST_F(CalibrateCommand, NamesTheFileThatHasTooFewStations) {
  write_stations("two.yaml", 2, 0);
  expect_refusal("calibrate two.yaml", 3, {"two.yaml", "three stations", "got 2"});
  std::string same = head_;
  for (int i = 0; i < 4; ++i) same += stations_[0];
  write("same.yaml", same);
  expect_refusal("calibrate same.yaml", 3, {"same.yaml", "no three differ"});
}

TEST_F(CalibrateCommand, ReportsTheChecksFindingInJson) {
  const json check = run("calibrate pairs.yaml --check good.yaml --json").data()["check"];
  EXPECT_FALSE(check["inverted"].get<bool>());
  EXPECT_LT(check["residual"]["translation_m"].get<double>(), 0.002);
  EXPECT_LT(check["off"]["translation_m"].get<double>(), 1e-6);
}

/// `calibrate --table` on simulated devices behind their protocols.
class TableCommand : public Commands {
 protected:
  /// A cell whose camera is said to sit `deeper` m further from the fingers than it does.
  void write_cell(double deeper) const {
    write("cell.yaml",
          concat("simulate: true\n"
                 "arm: {rtde: {stale_after: 1.0}, script: {force_stale: 1.0, heartbeat_rate: 2}}\n"
                 "force_torque: {stale: 0.5}\n"
                 "layout:\n  T_T_C: {x: 0.0, y: 0.11, z: ",
                 -0.17 - deeper,
                 ", qx: 0.0871557, qy: 0.0, qz: 0.0, qw: 0.9961947}\n"
                 "simulators:\n  camera: {port: 0, T_T_C: {x: 0.0, y: 0.11, z: -0.17, qx: 0.0871557, "
                 "qy: 0.0, qz: 0.0, qw: 0.9961947}}\n"
                 "  arm: {standard_ports: false, speed: 4}\n  gripper: {port: 0}\n"
                 "  force_torque: {port: 0, command_port: 0}\n"));
  }
  [[nodiscard]] std::string cell() const { return read_file(folder_ + "/cell.yaml", 1 << 16); }
};

TEST_F(TableCommand, MovesNoRealArmUnlessRequested) {
  write("lab.yaml", "arm: {address: 192.0.2.1}\n");
  expect_refusal("calibrate --table lab.yaml", 2, {"192.0.2.1", "--execute", "clear the field"});
  write("lab.yaml", "robot: ur10\n");
  expect_refusal("calibrate --table lab.yaml --execute", 3, {"lab.yaml", "arm.address"});
  expect_refusal("calibrate --execute --simulate 12", 2, {"--execute", "--table"});
  expect_refusal("calibrate pairs.yaml --table lab.yaml", 2, {"--table"});
  expect_refusal("calibrate --simulate 12 --table lab.yaml", 2, {"--simulate", "--table"});
  expect_refusal("calibrate --table nowhere.yaml", 3, {"nowhere.yaml"});
}

TEST_F(TableCommand, TheArmTakesTheStationsAndTheMountIsWritten) {
  write_cell(0.012);
  const Outcome done =
      run("calibrate --capture cell.yaml --stations 8 --block 0.12,0.08,0.05 --write cell.yaml --json "
          "--set simulation.hand_eye_translation=0 --set simulation.hand_eye_rotation=0");
  ASSERT_EQ(done.code, 0) << done.err;
  EXPECT_THAT(done.err, testing::AllOf(HasSubstr("block is the target"), HasSubstr("station 8 of 8"),
                                       HasSubstr("wrote layout.T_T_C")));
  const emulators::CellFile written = emulators::read_cell(folder_ + "/cell.yaml");
  const PoseDifference off = difference(to_layout(written.cell()).T_T_C, CellLayout{}.T_T_C);
  EXPECT_LT(off.translation, 0.002) << cell();
  EXPECT_LT(off.angle, 0.3 * kDegree) << cell();
}

TEST_F(TableCommand, TheArmTakesNoStationsUnlessRequested) {
  write("lab.yaml", "arm: {address: 192.0.2.1}\n");
  expect_refusal("calibrate --capture lab.yaml", 2, {"192.0.2.1", "--execute", "lay the target"});
  expect_refusal("calibrate --capture lab.yaml --execute --block 0.1,0.1,0.05", 2, {"sides", "differ"});
  expect_refusal("calibrate --capture lab.yaml --execute --block 0.1,0.1", 2, {"--block"});
  expect_refusal("calibrate --capture lab.yaml --target granite", 2, {"granite"});
  expect_refusal("calibrate --capture lab.yaml pairs.yaml", 2, {"--capture"});
  expect_refusal("calibrate --capture lab.yaml --on-base", 2, {"--on-base"});
  expect_refusal("calibrate --capture lab.yaml --execute --write-pairs lab.yaml/p.yaml", 3, {"not a folder"});
  expect_refusal("calibrate --stations 8 pairs.yaml", 2, {"--stations", "--capture"});
}

TEST_F(TableCommand, TouchesTheTableAndWritesTheBase) {
  write_cell(0.0);
  const Outcome done =
      run("calibrate --table cell.yaml --seed 2 --json --write cell.yaml "
          "--set simulation.table_height=0.006");
  ASSERT_EQ(done.code, 0) << done.err;
  const json table = done.data();
  EXPECT_EQ(table["schema"], "stonestack.table/1");
  EXPECT_TRUE(table["agree"].get<bool>()) << done.out;
  EXPECT_EQ(table["points"].size(), 3U);
  EXPECT_NEAR(std::abs(table["touched"]["height_mm"].get<double>()), 6.0, 1.5) << done.out;
  EXPECT_THAT(done.err, testing::AllOf(HasSubstr("touched table:"), HasSubstr("wrote layout.T_W_R: {x: ")));
  EXPECT_THAT(cell(), HasSubstr("  T_W_R: {x: "));
  EXPECT_NEAR(table["T_W_R"]["z"].get<double>(), -1e-3 * table["touched"]["height_mm"].get<double>(), 0.002);
}

TEST_F(TableCommand, WritesNothingWhereTouchAndCameraDisagree) {
  write_cell(0.02);
  const std::string before = cell();
  const Outcome done = run("calibrate --table cell.yaml --write cell.yaml");
  EXPECT_EQ(done.code, 6) << done.err;
  EXPECT_THAT(
      done.out,
      testing::AllOf(testing::ContainsRegex("FAIL  the camera sees the table (1[5-9]|2[0-4]) mm above"),
                     HasSubstr("stonestack calibrate --capture CELL")));
  EXPECT_THAT(done.err, testing::AllOf(HasSubstr("disagree"), HasSubstr("nothing was written")));
  EXPECT_EQ(cell(), before);
}

}  // namespace
}  // namespace stonestack
