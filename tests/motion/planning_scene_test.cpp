#include "stonestack/motion/planning_scene.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "stonestack/core/error.hpp"
#include "stonestack/geometry/depth_image.hpp"
#include "stonestack/hardware/cell.hpp"

namespace stonestack::motion {
namespace {

using hardware::CellLayout;

Eigen::AlignedBox3d box_T(const GripperBox& box, double opening) {
  const Eigen::Vector3d centre = box.p_T_centre + Eigen::Vector3d(0.5 * opening * box.finger_side, 0.0, 0.0);
  return {centre - 0.5 * box.size, centre + 0.5 * box.size};
}

/// True if the ray from `p` along `d` enters the box (slab test).
bool hits(const Eigen::AlignedBox3d& box, const Eigen::Vector3d& p, const Eigen::Vector3d& d) {
  double near = 0.0;
  double far = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const double a = (box.min()[i] - p[i]) / d[i];
    const double b = (box.max()[i] - p[i]) / d[i];
    near = std::max(near, std::min(a, b));
    far = std::min(far, std::max(a, b));
  }
  return near <= far;
}

TEST(Gripper, FingersMeetAtTheToolAxisAndEndAtTheTip) {
  const GripperModel gripper = make_robotiq_3f();
  int fingers = 0, tips = 0;
  for (const auto& box : gripper.boxes) {
    const auto closed = box_T(box, 0.0);
    EXPECT_LE(closed.max().z(), 1e-12);
    if (box.finger_side == 0.0) continue;
    ++fingers;
    const double pad = box.finger_side > 0 ? closed.min().x() : closed.max().x();
    EXPECT_NEAR(pad, 0.0, 1e-12);
    tips += std::abs(closed.max().z()) < 1e-12 ? 1 : 0;
    const auto open = box_T(box, gripper.max_opening);
    EXPECT_NEAR((box.finger_side > 0 ? open.min().x() : -open.max().x()), 0.0775, 1e-12);
  }
  EXPECT_EQ(fingers, 5) << "B and C have two parts each";
  EXPECT_EQ(tips, 3);
}

TEST(Gripper, FingersBAndCDrawTogether) {
  const GripperModel wide = make_robotiq_3f();
  const GripperModel narrow = with_spacing(wide, wide.narrow_spacing);
  EXPECT_EQ(narrow.finger_spacing, wide.narrow_spacing);
  double max_wide = 0.0, max_narrow = 0.0;
  for (std::size_t i = 0; i < wide.boxes.size(); ++i) {
    const auto a = box_T(wide.boxes[i], 0.0), b = box_T(narrow.boxes[i], 0.0);
    if (wide.boxes[i].finger_side >= 0) {
      EXPECT_TRUE(a.isApprox(b)) << "finger A, palm, sensor and camera stay";
    }
    if (a.max().z() > -1e-12) {
      max_wide = std::max(max_wide, a.max().y());
      max_narrow = std::max(max_narrow, b.max().y());
    }
  }
  EXPECT_NEAR(max_wide - max_narrow, 0.5 * (0.073 - 0.042), 1e-12);
  EXPECT_TRUE(with_spacing(wide, wide.finger_spacing).boxes[0].p_T_centre.isApprox(wide.boxes[0].p_T_centre));
  EXPECT_THROW((void)with_spacing(wide, 0.030), InvalidArgument) << "they would cut each other";
  EXPECT_THROW((void)with_spacing(wide, 0.090), InvalidArgument);
  GripperModel stiff = wide;
  stiff.narrow_spacing = 0.0;
  EXPECT_THROW((void)with_spacing(stiff, 0.05), InvalidArgument);
}

TEST(Gripper, ReachesFromFlangeToTip) {
  double back = 0.0;
  for (const auto& box : make_robotiq_3f().boxes) back = std::min(back, box_T(box, 0.0).min().z());
  EXPECT_NEAR(-back, CellLayout().T_F_T.translation().z(), 1e-12);
}

TEST(CameraMount, LooksForwardWithImageAxesAsDocumented) {
  const Pose T_T_C = CellLayout::make_default_T_T_C();
  EXPECT_NEAR(T_T_C.linear().col(0).x(), 1.0, 1e-12) << "image x along x of T";
  EXPECT_GT(T_T_C.linear().col(2).z(), 0.95) << "points out of the gripper";
  EXPECT_LT(T_T_C.linear().col(2).y(), -0.1) << "tilted towards the tool axis";
}

const GripperBox& camera_of(const GripperModel& gripper) {
  return *std::find_if(gripper.boxes.begin(), gripper.boxes.end(),
                       [](const auto& box) { return box.camera; });
}

TEST(CameraMount, TheCamerasBoxGoesWhereTheCameraIs) {
  const GripperModel drawn = make_robotiq_3f();
  const Pose T_T_C = CellLayout::make_default_T_T_C();
  const Pose across(Eigen::AngleAxisd(std::acos(-1.0), Eigen::Vector3d::UnitZ()));
  const GripperModel other_side = with_camera_at(drawn, across * T_T_C);
  EXPECT_TRUE(camera_of(other_side).p_T_centre.isApprox(across * camera_of(drawn).p_T_centre));
  EXPECT_TRUE(camera_of(other_side).size.isApprox(camera_of(drawn).size));
  const Pose aside(Eigen::Translation3d(0.0, 0.03, 0.0));
  EXPECT_TRUE(camera_of(with_camera_at(drawn, aside * T_T_C))
                  .p_T_centre.isApprox(aside * camera_of(drawn).p_T_centre))
      << "the box is drawn for the layout's default mount";
  const Pose quarter(Eigen::AngleAxisd(0.5 * std::acos(-1.0), Eigen::Vector3d::UnitZ()));
  const Eigen::Vector3d size = camera_of(drawn).size;
  EXPECT_TRUE(camera_of(with_camera_at(drawn, quarter * T_T_C))
                  .size.isApprox(Eigen::Vector3d(size.y(), size.x(), size.z())));
  for (std::size_t i = 0; i < drawn.boxes.size(); ++i)
    EXPECT_TRUE(drawn.boxes[i].camera || other_side.boxes[i].p_T_centre.isApprox(drawn.boxes[i].p_T_centre));
}

/// A run corrects its mount by some millimetres; its plans shall not change by that.
TEST(CameraMount, ACorrectedMountKeepsTheBox) {
  const GripperModel drawn = make_robotiq_3f();
  const Pose corrected = CellLayout::make_default_T_T_C() * Eigen::Translation3d(0.003, -0.004, 0.002) *
                         Eigen::AngleAxisd(0.01, Eigen::Vector3d::UnitY());
  EXPECT_EQ(camera_of(with_camera_at(drawn, corrected)).p_T_centre, camera_of(drawn).p_T_centre);
  EXPECT_EQ(camera_of(with_camera_at(drawn, corrected)).size, camera_of(drawn).size);
  Pose broken = corrected;
  broken.linear() *= 2.0;
  EXPECT_THROW((void)with_camera_at(drawn, broken), InvalidArgument);
}

/// The gripper may stand in a corner of the picture, not more.
TEST(CameraMount, GripperFillsLittleOfTheView) {
  const GripperModel gripper = make_robotiq_3f();
  const Pose T_T_C = CellLayout::make_default_T_T_C();
  const CameraIntrinsics camera;
  for (const double opening : {0.0, 0.08, gripper.max_opening}) {
    int seen = 0;
    int all = 0;
    for (int v = 0; v < camera.height; v += 8) {
      for (int u = 0; u < camera.width; u += 8) {
        const Eigen::Vector3d ray_C((u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy, 1.0);
        const Eigen::Vector3d ray_T = T_T_C.linear() * ray_C;
        const bool blocked = std::any_of(gripper.boxes.begin(), gripper.boxes.end(), [&](const auto& box) {
          return hits(box_T(box, opening), T_T_C.translation(), ray_T);
        });
        seen += blocked ? 1 : 0;
        ++all;
      }
    }
    EXPECT_LT(static_cast<double>(seen) / all, 0.10) << "at opening " << opening;
  }
}

}  // namespace
}  // namespace stonestack::motion
