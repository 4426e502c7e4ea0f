// `stonestack record`: a folder that every command with a depth image takes, however the recording ended.
#include "commands.hpp"
#include "geometry/depth_sequence.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack {
namespace {

using ::testing::AllOf;

class RecordCommand : public Commands {
 protected:
  [[nodiscard]] json noted() const {
    return json::parse(read_file(folder_ + "/views/record.json", 1 << 20), nullptr, false);
  }
  [[nodiscard]] std::size_t images() const { return read_depth_sequence(folder_ + "/views").records.size(); }
};

TEST_F(RecordCommand, EveryCommandTakesTheFolder) {
  const Outcome done =
      run("record --robot ur10 --seed 3 --per-run 2 --frames 2 --every 0.5 --out views --json");
  ASSERT_EQ(done.code, 0) << done.err;
  EXPECT_THAT(done.err, AllOf(HasSubstr("record: 1 of 2 frames"), HasSubstr("record: 2 of 2 frames")));
  const json note = noted();
  EXPECT_EQ(done.data(), note);
  EXPECT_EQ(note["ended"], "done");
  EXPECT_EQ(note["cell"]["simulated"], true);
  EXPECT_EQ(note["camera"]["name"], "simulated sr300");
  ASSERT_EQ(note["frames"].size(), 2U);
  EXPECT_NEAR(note["frames"][1]["time"].get<double>() - note["frames"][0]["time"].get<double>(), 0.5, 0.05);
  // The camera's pose by the reported joints and the cell's mounts.
  const json& cell = note["cell"];
  Joints q;
  for (int i = 0; i < 6; ++i) q[i] = note["frames"][1]["q"][static_cast<std::size_t>(i)];
  const Pose T_W_C = pose_of(cell["T_W_R"]) * forward(read_robot("ur10"), q) * pose_of(cell["T_F_T"]) *
                     pose_of(cell["T_T_C"]);
  const auto sequence = read_depth_sequence(folder_ + "/views");
  ASSERT_EQ(sequence.records.size(), 2U);
  ASSERT_TRUE(sequence.records[1].T_W_C);
  EXPECT_TRUE(sequence.records[1].T_W_C->isApprox(T_W_C, 1e-9));
  EXPECT_DOUBLE_EQ(sequence.records[1].unit, 0.000125) << "the sensor's own count";
  EXPECT_NE(read_depth(sequence.records[0]).z, read_depth(sequence.records[1]).z) << "each has its noise";
  // The stones of the simulated cell, from the folder alone.
  const Outcome found = run("detect views --frame 1 --json");
  ASSERT_EQ(found.code, 0) << found.err;
  write("found.json", found.out);
  const json detections = found.data()["detections"];
  EXPECT_EQ(detections.size(), 2U);
  for (const json& stone : detections) {
    const Pose T_W_O = pose_of(stone["T_W_O"]);
    EXPECT_NEAR(T_W_O.translation().x(), 0.70, 0.25) << "in the field";
    EXPECT_NEAR(T_W_O.translation().y(), -0.18, 0.30);
    EXPECT_NEAR(T_W_O.translation().z(), 0.05, 0.05) << "on the table";
  }
  EXPECT_EQ(run("segment views --json").data()["objects"].size(), 2U);
  const json tracked = run("track views --expect found.json --json").data();
  ASSERT_EQ(tracked["tracked"].size(), 2U);
  for (const json& stone : tracked["tracked"]) EXPECT_EQ(stone["status"], "in place") << stone;
  const json next = run("search views --json --set search.rounds=1").data();
  EXPECT_EQ(next["frame"]["defined_by"], "camera_pose");
  EXPECT_EQ(next["placements"].size(), 1U);
}

TEST_F(RecordCommand, CtrlCLeavesARecordingThatCanBeRead) {
  const Outcome ended = shell(
      interrupted_at(folder_, "record --per-run 1 --frames 1000 --out views", "record: 2 of 1000 frames"));
  EXPECT_THAT(ended.out, HasSubstr("code 130")) << ended.err;
  EXPECT_THAT(ended.out, HasSubstr(" of 1000 frames of 640 x 480 in views"));
  EXPECT_EQ(noted()["ended"], "interrupted");
  EXPECT_GE(images(), 2U);
  EXPECT_EQ(noted()["frames"].size(), images());
  EXPECT_EQ(run("segment views --frame 1").code, 0);
}

TEST_F(RecordCommand, AKilledOneIsReadable) {
  std::string command =
      interrupted_at(folder_, "record --per-run 1 --frames 1000 --out views", "record: 2 of 1000 frames");
  command.replace(command.find("kill -INT"), 9, "kill -KILL");
  EXPECT_THAT(shell(command).out, HasSubstr("code 137"));
  EXPECT_EQ(noted()["ended"], "") << "nobody could write how it ended";
  EXPECT_GE(images(), 2U);
  EXPECT_EQ(run("segment views --frame 1").code, 0);
  EXPECT_EQ(run("record --per-run 1 --frames 1 --out views --force").code, 0);
  EXPECT_EQ(images(), 1U);
}

TEST_F(RecordCommand, ReadsDevicesOnTheirWires) {
  const Outcome done = run("record --cell loopback-ur10 --per-run 1 --frames 2 --out views --json");
  ASSERT_EQ(done.code, 0) << done.err;
  EXPECT_EQ(done.data()["camera"]["name"], "stream");
  const auto records = read_depth_sequence(folder_ + "/views").records;
  ASSERT_EQ(records.size(), 2U);
  EXPECT_TRUE(records[0].T_W_C) << "RTDE has the joints";
  EXPECT_EQ(run("detect views -q").code, 0);
  const Outcome mute =
      run("record --cell loopback-ur10 --per-run 1 --set simulators.arm.faults.no_rtde=true --out new");
  EXPECT_EQ(mute.code, 6) << mute.err;
  EXPECT_THAT(mute.err, AllOf(HasSubstr("RTDE"), HasSubstr("--set arm.address= records the camera alone")));
  EXPECT_FALSE(fs::exists(folder_ + "/new"));
}

TEST_F(RecordCommand, RefusesWhatCannotBeRecorded) {
  write("views/notes.txt", "mine");
  expect_refusal("record --out views", 2, {"views is not empty", "--out", "--force"});
  expect_refusal("record --out views --frames 0", 2, {"--frames"});
  expect_refusal("record --out new --cell nowhere.yaml", 3, {"nowhere.yaml"});
  expect_refusal("record --out new --cell loopback-ur10 --robot ur5", 2, {"--robot ur5", "ur10"});
  expect_refusal("record --out new --robot ur7", 3, {"ur7"});
  write("lab.yaml",
        "arm: {address: 127.0.0.1, rtde_port: 1}\ncamera: {driver: stream, stream: {address: "
        "127.0.0.1, port: 1}}\n");
  expect_refusal("record --out new --cell lab.yaml", 6, {"127.0.0.1:1", "start the camera's server"});
  EXPECT_FALSE(fs::exists(folder_ + "/new"));
}

}  // namespace
}  // namespace stonestack
