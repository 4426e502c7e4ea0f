#include <gmock/gmock.h>

#include "hardware/cell_config.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/stacking/check_cell.hpp"
#include "stonestack/stacking/observe.hpp"

namespace stonestack::stacking {
namespace {

using testing::HasSubstr;
using Verdict = CellCheck::Verdict;

/// The standard cell with a camera whose lens the file gives.
CellConfig sound_cell() {
  CellConfig cell;
  cell.file = "lab.yaml";
  cell.camera = "v4l2";
  cell.v4l2.camera.depth_scale = 8000;
  cell.v4l2.camera.width = 640;
  cell.v4l2.camera.height = 480;
  cell.v4l2.camera.fx = cell.v4l2.camera.fy = 475.0;
  cell.v4l2.camera.cx = 319.5;
  cell.v4l2.camera.cy = 239.5;
  return cell;
}

const CellCheck& finding(const CellPreview& preview, const std::string& device, const std::string& step) {
  for (const CellCheck& check : preview.report.checks)
    if (check.device == device && check.step == step) return check;
  throw InvalidArgument("there is no finding about " + device + ", " + step);
}

void expect_failure(const CellPreview& preview, const std::string& device, const std::string& step,
                    const std::string& part) {
  const CellCheck& found = finding(preview, device, step);
  EXPECT_EQ(found.verdict, Verdict::kFailed) << to_text(found);
  EXPECT_THAT(found.text, HasSubstr(part));
}

Obstacle box_at(const std::string& name, const Eigen::Vector3d& p_W, double size) {
  return {name, {make_box(Eigen::Vector3d::Constant(size))}, make_pose(p_W)};
}

TEST(PreviewCell, TheStandardCellHasNoFaults) {
  const CellPreview preview = preview_cell(sound_cell());
  for (const CellCheck& check : preview.report.checks)
    EXPECT_NE(check.verdict, Verdict::kFailed) << to_text(check);
  ASSERT_EQ(preview.poses.size(), 3U);
  const Eigen::Vector3d p_W_tip =
      (preview.layout.T_W_R * forward(preview.robot, preview.poses[0].q) * preview.layout.T_F_T)
          .translation();
  EXPECT_LT((p_W_tip - Eigen::Vector3d(0.70, -0.18, 0.45)).norm(), 1e-6) << "over the middle of the field";
  EXPECT_EQ(preview.poses[1].name, "view of the field");
  EXPECT_EQ(preview.poses[2].name, "view of the site");
  for (const CellPose& pose : preview.poses) EXPECT_EQ(pose.p_W_seen.size(), 4U) << pose.name;
  EXPECT_FALSE(preview.camera_is_assumed);
}

/// A UR10 with the gripper down stretches upper arm and forearm (1.184 m) to wrist 1, which stands higher
/// than the shoulder; wrist 2 leads 0.116 m further, and the flange is 0.164 m beside the arm's plane.
TEST(PreviewCell, TheReachIsACircleAboutTheBase) {
  CellConfig cell = sound_cell();
  cell.T_W_R[0] = 0.2;
  const CellPreview preview = preview_cell(cell);
  ASSERT_EQ(preview.p_W_reach.size(), preview.p_W_too_near.size());
  const RobotModel& ur10 = preview.robot;
  const double stretched = std::abs(ur10.a2) + std::abs(ur10.a3);
  const double higher = 0.02 + preview.layout.T_F_T.translation().z() + ur10.d6 - ur10.d1;
  const double expected = std::hypot(std::sqrt(stretched * stretched - higher * higher) + ur10.d5, ur10.d4);
  for (std::size_t i = 0; i < preview.p_W_reach.size(); ++i) {
    const double far = (preview.p_W_reach[i] - Eigen::Vector2d(0.2, 0.0)).norm();
    EXPECT_NEAR(far, (preview.p_W_reach[0] - Eigen::Vector2d(0.2, 0.0)).norm(), 0.011);
    EXPECT_NEAR(far, expected, 0.011);
    EXPECT_LT((preview.p_W_too_near[i] - Eigen::Vector2d(0.2, 0.0)).norm(), 0.5);
  }
}

TEST(PreviewCell, NamesWhatIsOutOfReach) {
  CellConfig cell = sound_cell();
  cell.field_x = 1.2;
  cell.site_y = 3.0;
  const CellPreview preview = preview_cell(cell);
  expect_failure(preview, "field", "reach", "out of the arm's reach at (1.");
  expect_failure(preview, "site", "reach", "out of the arm's reach at (0.7, 3, ");
  expect_failure(preview, "site", "view", "no view of it can be reached");
}

TEST(PreviewCell, NamesTheLimitThatFieldOrSiteBreak) {
  CellConfig cell = sound_cell();
  cell.limits.workspace[1] = "[-0.35, 0.5]";
  expect_failure(preview_cell(cell), "field", "reach", "leaves the workspace");
  cell.limits.workspace[1] = "[-0.6, 0.2]";
  const CellPreview preview = preview_cell(cell);
  expect_failure(preview, "site", "reach", "leaves the workspace");
  EXPECT_EQ(finding(preview, "field", "reach").verdict, Verdict::kPassed);
}

TEST(PreviewCell, NamesObstaclesInTheWay) {
  CellConfig cell = sound_cell();
  cell.obstacles = {box_at("post", {0.70, 0.28, 0.1}, 0.1), box_at("lamp", {0.70, -0.18, 1.8}, 0.3)};
  const CellPreview preview = preview_cell(cell);
  expect_failure(preview, "site", "obstacles", "'post'");
  expect_failure(preview, "site", "reach", "post");
  EXPECT_EQ(finding(preview, "field", "obstacles").verdict, Verdict::kPassed) << "the lamp hangs over it";
  EXPECT_EQ(finding(preview, "field", "reach").verdict, Verdict::kPassed);
}

TEST(PreviewCell, NamesWhatTheArmStandsInAtItsStart) {
  CellConfig cell = sound_cell();
  cell.obstacles = {box_at("shelf", {0.70, -0.18, 0.45}, 0.3)};
  expect_failure(preview_cell(cell), "start", "arm", "shelf");
  cell = sound_cell();
  cell.limits.fence[2] = "[-0.2, 0.6]";
  expect_failure(preview_cell(cell), "start", "arm", "leaves the fence");
  cell = sound_cell();
  cell.limits.joints = "[[-90, 90], [-180, 0], [150, 160], [-360, 360], [-180, 180], [-360, 360]]";
  expect_failure(preview_cell(cell), "start", "arm", "is outside the limits of the cell");
}

TEST(PreviewCell, SaysWhatTheCameraDoesNotShow) {
  CellConfig cell = sound_cell();
  cell.v4l2.camera.fx = cell.v4l2.camera.fy = 1500.0;
  const CellPreview narrow = preview_cell(cell);
  expect_failure(narrow, "field", "view", "% of it");
  cell = sound_cell();
  cell.T_T_C = {0.0, 0.11, 0.094, 0.0871557, 0.0, 0.0, 0.9961947};  // that of the flange
  expect_failure(preview_cell(cell), "camera", "mount", "T_F_C");
}

TEST(PreviewCell, KnowsACellWithoutACamera) {
  CellConfig cell = sound_cell();
  cell.camera = "stream";
  const CellPreview none = preview_cell(cell);
  EXPECT_FALSE(none.camera);
  ASSERT_EQ(none.poses.size(), 1U);
  EXPECT_TRUE(none.poses[0].p_W_seen.empty());
  EXPECT_EQ(finding(none, "camera", "lens").verdict, Verdict::kNote);
  CellPreviewOptions simulated;
  simulated.simulated = true;
  const CellPreview served = preview_cell(cell, simulated);
  EXPECT_TRUE(served.camera_is_assumed);
  EXPECT_EQ(served.poses.size(), 3U);
}

TEST(PreviewCell, RefusesJointAnglesThatTheRobotDoesNotHave) {
  CellPreviewOptions options;
  options.q_start = Joints::Constant(45.0);
  try {
    (void)preview_cell(sound_cell(), options);
    FAIL() << "45 rad are no joint angle";
  } catch (const InvalidArgument& refused) {
    EXPECT_THAT(refused.what(), HasSubstr("angles are in rad"));
  }
  options.q_start = home_joints();
  (*options.q_start)[0] = 0.5;
  EXPECT_EQ(preview_cell(sound_cell(), options).poses[0].q[0], 0.5);
}

}  // namespace
}  // namespace stonestack::stacking
