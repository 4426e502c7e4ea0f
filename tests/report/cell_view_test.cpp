#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "report/cell_page.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/stacking/observe.hpp"
#include "temporary_folder.hpp"

namespace stonestack::report {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

/// A folder of its own for each test.
class CellPage : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = (std::filesystem::path(test::temporary_folder()) /
               testing::UnitTest::GetInstance()->current_test_info()->name())
                  .string();
    std::filesystem::remove_all(folder_);
  }
  [[nodiscard]] std::string write(const std::string& name, const std::string& text) const {
    write_file(folder_ + "/" + name, text);
    return folder_ + "/" + name;
  }
  /// The whole page of a cell.
  [[nodiscard]] std::string page(const std::string& cell) const {
    const ShownCell shown = show_cell({cell, folder_ + "/page.html", {}});
    EXPECT_THAT(shown.files, testing::ElementsAre(folder_ + "/page.html"));
    return read_file(folder_ + "/page.html", 1 << 24);
  }
  std::string folder_;
};

/// Data that the scripts of a page draw.
json data_of(const std::string& page) {
  const std::string begin = "const run = ";
  const std::size_t from = page.find(begin) + begin.size(), to = page.find(";\n</script>", from);
  return json::parse(page.substr(from, to - from));
}

/// Value and origin of a row of the table.
json row(const json& data, const std::string& name) {
  for (const json& entry : data.at("numbers"))
    if (entry.at(0) == name) return entry;
  return {name, "no such row", ""};
}

constexpr const char* kFullCell = R"(robot: ur10
arm: {address: 192.168.1.10}
camera: {driver: v4l2, v4l2: {depth_scale: 8000, width: 640, height: 480, fx: 475, fy: 475, cx: 320, cy: 240}}
layout:
  site: {x: 0.70, y: 0.30}
  obstacles:
    - {name: wall, box: {x: 0.02, y: 2, z: 1.5}, T_W_O: {x: -0.6, y: 0, z: 0.75, qx: 0, qy: 0, qz: 0, qw: 1}}
    - {name: lamp, sphere: {radius: 0.1}, T_W_O: {x: 0.6, y: 0.9, z: 1.2, qx: 0, qy: 0, qz: 0, qw: 1}}
limits:
  workspace: {x: [0.2, 1.1], y: [-0.7, 0.7]}
  fence: {x: [-0.5, 1.3], y: [-0.9, 0.9], z: [-0.1, 1.6]}
)";

TEST_F(CellPage, HoldsEveryPartOfTheCell) {
  const json data = data_of(page(write("full.yaml", kFullCell)));
  EXPECT_EQ(data.at("title"), "Cell full");
  EXPECT_EQ(data.at("robot_model").at("T_parent_joint").size(), 6U);
  EXPECT_FALSE(data.at("robot_model").at("shapes").empty());
  EXPECT_FALSE(data.at("robot_model").at("boxes").empty()) << "the gripper";
  EXPECT_EQ(data.at("site"), json({0.7, 0.3}));
  EXPECT_EQ(data.at("field").at("size"), json({0.4, 0.5}));
  ASSERT_EQ(data.at("obstacles").size(), 2U);
  EXPECT_EQ(data.at("obstacles")[0].at("name"), "wall");
  EXPECT_EQ(data.at("obstacles")[0].at("faces").size(), 36U);
  EXPECT_EQ(data.at("obstacles")[0].at("vertices").size(), 24U);
  EXPECT_EQ(data.at("fence").at("max"), json({1.3, 0.9, 1.6}));
  EXPECT_EQ(data.at("workspace").at("min")[0], 0.2);
  EXPECT_LT(data.at("workspace").at("max")[2], 3.0) << "a side without an end is drawn to where the arm is";
  EXPECT_GT(data.at("reach").size(), 20U);
  ASSERT_GE(data.at("poses").size(), 1U);
  EXPECT_EQ(data.at("poses")[0].at("q").size(), 6U);
  EXPECT_EQ(data.at("poses")[0].at("seen").size(), 4U);
  EXPECT_GE(data.at("findings").size(), 8U);
  EXPECT_THAT(data.at("picture").get<std::string>(), StartsWith("data:image/png;base64,"));
}

TEST_F(CellPage, NumbersNameTheirOrigin) {
  const json data = data_of(page(write("full.yaml", kFullCell)));
  EXPECT_EQ(row(data, "site"), json({"site", "(0.7, 0.3) m", "layout.site"}));
  EXPECT_EQ(row(data, "robot base, T_W_R"),
            json({"robot base, T_W_R", "(0, 0, 0) m, not turned", "default"}));
  EXPECT_EQ(row(data, "workspace of the tool tip")[1], "x 0.2 to 1.1, y -0.7 to 0.7, z no end to no end m");
  EXPECT_EQ(row(data, "workspace of the tool tip")[2], "limits.workspace");
  EXPECT_EQ(row(data, "obstacle wall")[1], "x -0.61 to -0.59, y -1 to 1, z 0 to 1.5 m");
  EXPECT_EQ(row(data, "camera, T_T_C")[2], "default");
}

TEST_F(CellPage, ShowsACellWithoutCameraLimitsAndObstacles) {
  const std::string text = page(write("bare.yaml", ""));
  const json data = data_of(text);
  EXPECT_FALSE(data.at("has_camera"));
  EXPECT_TRUE(data.at("obstacles").empty());
  EXPECT_TRUE(data.at("workspace").is_null());
  EXPECT_TRUE(data.at("fence").is_null());
  EXPECT_TRUE(data.at("poses")[0].at("seen").empty());
  EXPECT_EQ(row(data, "lens")[1], "none");
  EXPECT_THAT(text, HasSubstr("note  camera, lens: the file names no camera"));
}

TEST_F(CellPage, IsOneFileThatNoNameBreaks) {
  const std::string name = "</script><script>alert(1)</script><!--<script>";
  const std::string text =
      page(write("hostile.yaml", "layout:\n  obstacles:\n    - {name: '" + name +
                                     "', sphere: {radius: 0.1}, T_W_O: {x: 0.70, y: 0.28, z: 0.1, qx: 0, "
                                     "qy: 0, qz: 0, qw: 1}}\n"));
  EXPECT_THAT(text, StartsWith("<!doctype html>"));
  EXPECT_THAT(text, Not(HasSubstr("<script>alert")));
  EXPECT_THAT(text, Not(HasSubstr("<!--<")));
  EXPECT_THAT(text, Not(HasSubstr("src=\"http")));
  EXPECT_LT(text.size(), 6'000'000U);
  EXPECT_EQ(data_of(text).at("obstacles")[0].at("name"), name);
  EXPECT_THAT(text, HasSubstr("FAIL  site, obstacles: the obstacle '&lt;/script&gt;"));
}

TEST_F(CellPage, EveryCellThatComesWithStonestackIsSound) {
  for (const char* name :
       {"lab-ur10", "loopback-ur10", "loopback-ur10e", "loopback-2f-85", "practice-ur10", "simulated-ur10"}) {
    const ShownCell shown = show_cell({name, folder_, {}});
    EXPECT_THAT(shown.files, testing::ElementsAre(folder_ + "/cell.html", folder_ + "/cell.png"));
    EXPECT_EQ(shown.preview.report.failed(), 0) << name << "\n" << cell_view_text(shown);
    EXPECT_EQ(shown.preview.poses.size(), 3U) << name;
    EXPECT_THAT(read_file(folder_ + "/cell.png", 1 << 24), StartsWith("\x89PNG"));
  }
}

/// setup writes a robot file with the arm's calibration beside the cell.
TEST_F(CellPage, ShowsACellThatSetupWrote) {
  CellSetup setup;
  setup.path = folder_ + "/mine.yaml";
  setup.arm = "192.168.1.10";
  setup.gripper_address = "192.168.1.11";
  ControllerDescription controller;
  controller.model = "UR10";
  controller.polyscope = "3.15.8.106339";
  const RobotModel nominal = read_robot("ur10");
  controller.dh = {{{0, nominal.d1 + 1e-3, 0, M_PI / 2},
                    {0, 0, nominal.a2, 0},
                    {0, 0, nominal.a3, 0},
                    {0, nominal.d4, 0, M_PI / 2},
                    {0, nominal.d5, 0, -M_PI / 2},
                    {0, nominal.d6, 0, 0}}};
  const NewCell made = write_new_cell(setup, controller);
  ASSERT_FALSE(made.robot_file.empty());
  const json data = data_of(page(made.path));
  EXPECT_EQ(row(data, "robot"), json({"robot", made.robot_file, "robot"}));
  EXPECT_EQ(row(data, "controller")[1], "192.168.1.10");
}

TEST_F(CellPage, ThePictureHoldsAllThatIsDrawn) {
  const std::vector<DrawnMesh> meshes = drawn_cell(show_cell({"practice-ur10", folder_, {}}).preview);
  const View view = view_of_cell(meshes);
  const Eigen::Vector3d forward = (view.p_W_target - view.p_W_eye).normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  const double half = std::tan(view.angle / 2), aspect = static_cast<double>(view.width) / view.height;
  double widest = 0.0;
  for (const DrawnMesh& drawn : meshes)
    for (const Eigen::Vector3d& v : drawn.mesh.vertices) {
      const Eigen::Vector3d p = drawn.T_W_A * v - view.p_W_eye;
      const double x = right.dot(p) / forward.dot(p) / (half * aspect),
                   y = right.cross(forward).dot(p) / forward.dot(p) / half;
      ASSERT_LT(std::max(std::abs(x), std::abs(y)), 1.0);
      widest = std::max({widest, std::abs(x), std::abs(y)});
    }
  EXPECT_GT(widest, 0.85) << "and fills the picture";
}

TEST_F(CellPage, FindingsAreJson) {
  ShownCell shown;
  shown.cell = "lab.yaml";
  shown.files = {"lab_view.html"};
  shown.preview.report.checks = {{"site", "reach", CellCheck::Verdict::kFailed, "out of reach"}};
  CellPose start{"start", home_joints(), make_pose({0.1, 0.2, 0.3}), {{1, 2, 0}}};
  shown.preview.poses = {start};
  const json data = json::parse(cell_view_json(shown));
  EXPECT_EQ(data.at("schema"), "stonestack.view/1");
  EXPECT_EQ(data.at("files"), json({"lab_view.html"}));
  EXPECT_EQ(data.at("findings")[0].at("good"), false);
  EXPECT_EQ(data.at("findings")[0].at("device"), "site");
  EXPECT_EQ(data.at("poses")[0].at("T_W_C").at("y"), 0.2);
  EXPECT_EQ(data.at("poses")[0].at("p_W_seen"), json({{1.0, 2.0, 0.0}}));
}

}  // namespace
}  // namespace stonestack::report
