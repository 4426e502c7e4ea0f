#include "commands.hpp"
#include "stonestack/geometry/cloud.hpp"
#include "stonestack/geometry/mesh.hpp"

namespace stonestack {
namespace {

/// `stonestack search` on boxes.
class SearchCommand : public Commands {
 protected:
  void SetUp() override {
    Commands::SetUp();
    write_mesh(folder_ + "/low.ply", make_box({0.12, 0.1, 0.05}));
    write_mesh(folder_ + "/high.ply", make_box({0.07, 0.06, 0.05}));
    ASSERT_EQ(run("scan low.ply high.ply --catalogue boxes").code, 0);
  }
  /// The low box on the table, its centre at height z, and the high one beside it.
  void write_scene(double z) const {
    write("scene.yaml",
          concat("schema: stonestack.scene/1\nstack:\n  - {stone: low, T_W_O: {x: 0.7, y: 0.28, z: ", z,
                 ", qx: 0, qy: 0, qz: 0, qw: 1}}\nstones:\n"
                 "  - {stone: high, T_W_O: {x: 0.6, y: -0.2, z: 0.025, qx: 0, qy: 0, qz: 0, qw: 1}}\n"));
  }
};

TEST_F(SearchCommand, ReportsWhereAStackMeasuredWithAnErrorComesToRest) {
  write_scene(0.028);
  const Outcome outcome = run("search scene.yaml --catalogue boxes --json --out tower.yaml");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("comes to rest up to 3 mm from where it is said to be"));
  const json found = outcome.data();
  EXPECT_NEAR(pose_of(found["stack"][0]["T_W_O"]).translation().z(), 0.025, 5e-5);
  EXPECT_TRUE(found["repeatable"].get<bool>());
  EXPECT_EQ(run("check tower.yaml --catalogue boxes --seconds 1").code, 0)
      << "what was planned does not touch";
}

TEST_F(SearchCommand, PlansABridgeOfTheWidthThatIsAskedFor) {
  for (const char* name : {"pier_1", "pier_2", "lintel"})
    write_mesh(concat(folder_, "/", name, ".ply"), make_box({0.12, 0.07, 0.05}));
  ASSERT_EQ(run("scan pier_1.ply pier_2.ply lintel.ply --catalogue bricks").code, 0);
  const Outcome outcome = run("search --catalogue bricks --stones all --bridge 0.05 --friction 0.4 --json");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const json found = outcome.data();
  EXPECT_EQ(found["placements"].size(), 3U);
  EXPECT_EQ(found["wall"]["spanned_m"], found["wall"]["to_span_m"]);
  EXPECT_NEAR(found["wall"]["to_span_m"].get<double>(), 0.05, 1e-12);
  expect_refusal("search --catalogue bricks --stones all --bridge 0.05 --wall 2+1", 2,
                 {"--bridge", "--wall"});
  expect_refusal("search --catalogue bricks --stones all --bridge 9", 2, {"--bridge 9", "span"});
  expect_refusal("run --robot ur10 --bridge 9 --out refused", 2, {"--bridge 9", "span"});
}

TEST_F(SearchCommand, ClearsTheProgressLineBeforeTheTable) {
  write_scene(0.025);
  const std::string shown = on_terminal("TERM=xterm", "search scene.yaml --catalogue boxes");
  const std::size_t table = shown.find("stone  ");
  ASSERT_NE(table, std::string::npos) << shown;
  EXPECT_THAT(shown.substr(0, table), HasSubstr("\r\x1b[2K")) << "there was no progress to clear";
  EXPECT_EQ(shown.substr(table - 5, 5), "\r\x1b[2K") << shown;
}

/// The scene or an output that cannot be is named before the catalogue is read and its shapes are built.
TEST_F(SearchCommand, ChecksItsFilesFirst) {
  write_scene(0.025);
  write("taken", "a file");
  const std::string nowhere = " --catalogue nowhere";
  expect_refusal("search missing.ply" + nowhere, 3, {"missing.ply: No such file"});
  expect_refusal("search scene.yaml --robot kuka" + nowhere, 3, {"kuka"});
  for (const char* option : {"--out", "--picture", "--trace"})
    expect_refusal(concat("search scene.yaml ", option, " taken/x", nowhere), 3,
                   {"taken/x", "cannot be written", "taken is not a folder"});
  expect_refusal("check missing.yaml" + nowhere, 3, {"missing.yaml: No such file"});
  expect_refusal("check scene.yaml --picture taken/x.png" + nowhere, 3, {"taken/x.png"});
  const std::string plan = "plan scene.yaml --stone high --target 0.7,0.28,0.1,0,0,0,1";
  expect_refusal("plan missing.yaml --stone high --target 0.7,0.28,0.1,0,0,0,1" + nowhere, 3,
                 {"missing.yaml: No such file"});
  for (const char* option : {"--csv", "--plot", "--frames"})
    expect_refusal(concat(plan, " ", option, " taken/x", nowhere), 3, {"taken/x", "taken is not a folder"});
  expect_refusal("plan scene.yaml --search missing.json" + nowhere, 3, {"missing.json"});
}

TEST_F(SearchCommand, TakesACloudInTheUnitThatItsRemedyNames) {
  ASSERT_EQ(run("render --out scene --seed 3 --stones limestone_1").code, 0);
  Cloud cloud = read_cloud(folder_ + "/scene/cloud.ply");
  for (auto& p : cloud.points) p *= 1000.0F;
  write_cloud(folder_ + "/mm.ply", cloud);
  const std::string arguments = "search mm.ply --camera-pose scene/scene.yaml --json";
  const Outcome metres = run(arguments);
  EXPECT_NE(metres.code, 0);
  EXPECT_THAT(metres.err, HasSubstr("--units"));
  const Outcome millimetres = run(arguments + " --units mm");
  ASSERT_EQ(millimetres.code, 0) << millimetres.err;
  EXPECT_EQ(millimetres.data()["placements"][0]["stone"], "limestone_1");
  EXPECT_THAT(millimetres.data()["next"].get<std::string>(), HasSubstr("--units mm"));
}

TEST_F(SearchCommand, WarnsThatABudgetMayEndItElsewhereNextTime) {
  write_scene(0.025);
  const Outcome outcome = run("search scene.yaml --catalogue boxes --json --budget 600");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("another run may find something else"));
  EXPECT_FALSE(outcome.data()["repeatable"].get<bool>());
}

TEST_F(SearchCommand, CtrlCEndsItWithTheBestSoFar) {
  const Outcome outcome = shell(interrupted_at(
      folder_, "search --stones limestone_1,limestone_2,limestone_3,limestone_4 --json --picture tower.png",
      "round 1"));
  EXPECT_THAT(outcome.out, HasSubstr("code 130")) << outcome.err;
  const json found = json::parse(outcome.out.substr(0, outcome.out.rfind("code")), nullptr, false);
  EXPECT_EQ(found["placements"].size(), 1u) << outcome.err;
  EXPECT_FALSE(found["repeatable"].get<bool>());
  EXPECT_TRUE(fs::exists(folder_ + "/tower.png"));
}

}  // namespace
}  // namespace stonestack
