// `stonestack view`: a page and a picture of a cell, and what a run would stumble over.
#include "commands.hpp"

namespace stonestack {
namespace {

using ::testing::AllOf;
using ::testing::Not;
using ::testing::StartsWith;

using ViewCommand = Commands;

TEST_F(ViewCommand, WritesOnePageAndPrintsFindings) {
  write("lab.yaml", "robot: ur10\ncamera: {stream: {port: 30100}}\n");
  const Outcome shown = run("view lab.yaml");
  ASSERT_EQ(shown.code, 0) << shown.err;
  EXPECT_THAT(shown.out, AllOf(HasSubstr("ok    field, reach: "), HasSubstr("ok    start, arm: free"),
                               HasSubstr("lab_view.html shows the cell"), Not(HasSubstr("FAIL"))));
  EXPECT_THAT(read_file(folder_ + "/lab_view.html", 1 << 24), StartsWith("<!doctype html>"));
}

TEST_F(ViewCommand, ShowsACellWithFaultsAndExitsWith0) {
  write("far.yaml",
        "camera: {stream: {port: 30100}}\nlayout: {site: {x: 2.0}}\nlimits: {workspace: {y: [-0.2, 0.9]}}\n");
  const Outcome shown = run("view far.yaml --out far.png --json");
  EXPECT_EQ(shown.code, 0) << shown.err;
  const json data = shown.data();
  EXPECT_EQ(data["schema"], "stonestack.view/1");
  EXPECT_EQ(data["files"], json({"far.png"}));
  std::map<std::string, std::string> failed;
  for (const json& finding : data["findings"])
    if (!finding["good"].get<bool>())
      failed[finding["device"].get<std::string>() + ", " + finding["step"].get<std::string>()] =
          finding["text"];
  EXPECT_THAT(failed["site, reach"], HasSubstr("out of the arm's reach at (2, "));
  EXPECT_THAT(failed["field, reach"], HasSubstr("leaves the workspace"));
  EXPECT_FALSE(fs::exists(folder_ + "/far_view.html"));
  EXPECT_THAT(read_file(folder_ + "/far.png", 1 << 24), StartsWith("\x89PNG"));
}

TEST_F(ViewCommand, ShowsTheArmWhereItStands) {
  const Outcome shown = run("view --out cell --joints 0.5,-1.75,1.85,-1.67,-1.5708,0 --json");
  ASSERT_EQ(shown.code, 0) << shown.err;
  EXPECT_EQ(shown.data()["poses"][0]["q"][0], 0.5);
  EXPECT_EQ(shown.data()["files"], json({"cell/cell.html", "cell/cell.png"}));
  EXPECT_THAT(shown.data()["cell"].get<std::string>(), HasSubstr("loopback-ur10.yaml"));
}

TEST_F(ViewCommand, RefusesWhatItCannotReadOrWrite) {
  expect_refusal("view nowhere.yaml", 3, {"nowhere.yaml"});
  write("bad.yaml", "layout: {site: {x: north}}\n");
  expect_refusal("view bad.yaml", 3, {"bad.yaml", "layout.site.x", "north"});
  write("odd.yaml", "limits: {workspace: {x: [1.0, 0.2]}}\n");
  expect_refusal("view odd.yaml", 3, {"odd.yaml", "limits.workspace.x", "smaller number first"});
  expect_refusal("view lab-ur10 --joints 1,2", 2, {"q1,q2,q3,q4,q5,q6 in rad"});
  expect_refusal("view lab-ur10 --joints 45,0,0,0,0,0", 2, {"joint 1 at 45 rad", "not degrees"});
  fs::create_directories(folder_ + "/taken.html");
  expect_refusal("view lab-ur10 --out taken.html", 3, {"taken.html"});
}

}  // namespace
}  // namespace stonestack
