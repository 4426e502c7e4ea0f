#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/constants.hpp"
#include "motion/collision/mounted_gripper.hpp"
#include "motion/grasp.hpp"
#include "motion/grasp/finger_reach.hpp"
#include "motion/grasp/grasp_wrench.hpp"
#include "motion/grasp/pad_press.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/hardware/cell.hpp"

namespace stonestack::motion {
namespace {

Stone pad_block(const Eigen::Vector3d& size, double density = 2600.0) {
  Stone stone;
  stone.name = "block";
  stone.scan = stone.mesh = make_box(size);
  stone.mass = mass_properties(stone.scan, density);
  return stone;
}

GraspOptions few_directions() {
  GraspOptions options;
  options.directions = 60;
  return options;
}

/// Every figure, not a rounded one: golden results hang on them.
void expect_same_model(const GripperModel& a, const GripperModel& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.against, b.against);
  EXPECT_EQ(a.linkage, b.linkage);
  for (const auto figure :
       {&GripperModel::tip,          &GripperModel::max_opening,    &GripperModel::min_object,
        &GripperModel::finger_width, &GripperModel::finger_spacing, &GripperModel::narrow_spacing,
        &GripperModel::pad_length,   &GripperModel::force,          &GripperModel::min_force,
        &GripperModel::max_force,    &GripperModel::min_speed,      &GripperModel::max_speed,
        &GripperModel::friction,     &GripperModel::pad_thickness,  &GripperModel::pad_stiffness,
        &GripperModel::pad_shear,    &GripperModel::mass,           &GripperModel::centre_of_mass,
        &GripperModel::sensor_mass,  &GripperModel::camera_mass,    &GripperModel::payload})
    EXPECT_EQ(a.*figure, b.*figure);
  EXPECT_TRUE(a.tips.empty() && b.tips.empty());
  ASSERT_EQ(a.boxes.size(), b.boxes.size());
  for (std::size_t i = 0; i < a.boxes.size(); ++i) {
    EXPECT_EQ(a.boxes[i].size, b.boxes[i].size) << i;
    EXPECT_EQ(a.boxes[i].p_T_centre, b.boxes[i].p_T_centre) << i;
    EXPECT_EQ(a.boxes[i].finger_side, b.boxes[i].finger_side) << i;
    EXPECT_EQ(a.boxes[i].spread, b.boxes[i].spread) << i;
    EXPECT_EQ(a.boxes[i].camera, b.boxes[i].camera) << i;
    EXPECT_EQ(a.boxes[i].advance, b.boxes[i].advance) << i;
  }
}

TEST(ReadGripper, TheThreeFingerGrippersFileIsTheProgramsModelToTheBit) {
  for (const Linkage linkage : {Linkage::kParallel, Linkage::kThreeFinger})
    expect_same_model(read_gripper("robotiq-3f", linkage), make_robotiq_3f(linkage));
}

TEST(ReadGripper, OtherGrippersHaveTheArcOfTheirOwnFile) {
  const GripperModel flat = read_gripper("robotiq-2f-85"),
                     arc = read_gripper("robotiq-2f-85", Linkage::kThreeFinger);
  EXPECT_EQ(flat.linkage, Linkage::kParallel);
  EXPECT_EQ(arc.linkage, Linkage::kArc);
  EXPECT_EQ(tip_advance(flat, 0.0), 0.0);
  EXPECT_NEAR(tip_advance(arc, 0.0), 0.0135, 1e-12) << "162.8 mm closed, 149.3 mm open in the manual";
  EXPECT_NEAR(tip_advance(arc, 0.085), 0.0, 1e-12);
  EXPECT_NEAR(furthest_tip(arc, 0.0, 0.03), 0.0137, 1e-12) << "between the two";
  EXPECT_EQ(finger_inside(arc, 0.04, -0.04), 0.02) << "its fingers stay upright";
  EXPECT_EQ(read_gripper("robotiq-hand-e", Linkage::kThreeFinger).linkage, Linkage::kParallel)
      << "jaws slide";
}

TEST(ReadGripper, TheCameraStaysOnTheFlange) {
  for (const std::string& name : gripper_names()) {
    const GripperModel gripper = read_gripper(name);
    const hardware::CellLayout layout = hardware::with_gripper({}, name);
    EXPECT_NEAR(layout.T_F_T.translation().z(), 0.041 + gripper.tip, 1e-12) << name;
    EXPECT_TRUE((layout.T_F_T * layout.T_T_C)
                    .isApprox(hardware::CellLayout{}.T_F_T * hardware::CellLayout{}.T_T_C, 1e-12))
        << name;
    const GripperModel mounted = with_camera_at(gripper, layout.T_T_C);
    for (std::size_t i = 0; i < gripper.boxes.size(); ++i) {
      EXPECT_EQ(mounted.boxes[i].p_T_centre, gripper.boxes[i].p_T_centre) << name << " " << i;
      if (!gripper.boxes[i].camera) continue;
      const GripperBox of_three = make_robotiq_3f().boxes[3];
      EXPECT_NEAR(
          (layout.T_F_T * gripper.boxes[i].p_T_centre - hardware::CellLayout{}.T_F_T * of_three.p_T_centre)
              .norm(),
          0.0, 1e-9)
          << name;
    }
    double back = 0.0;
    for (const GripperBox& box : gripper.boxes)
      back = std::min(back, box.p_T_centre.z() - 0.5 * box.size.z());
    EXPECT_NEAR(-back, layout.T_F_T.translation().z(), 1e-9) << name << ": the boxes reach to the flange";
  }
}

// The file draws the gripper on a sensor of 41 mm.
TEST(ReadGripper, NothingIsDrawnBehindTheFlange) {
  for (const std::string& name : gripper_names()) {
    const GripperModel gripper = read_gripper(name);
    const auto at = [&](double height) {
      return mounted_at(gripper, Pose(Eigen::Translation3d(0, 0, gripper.tip + height)));
    };
    const GripperModel on_sensor = at(0.041);
    ASSERT_EQ(on_sensor.boxes.size(), gripper.boxes.size()) << name;
    for (std::size_t i = 0; i < gripper.boxes.size(); ++i)
      EXPECT_EQ(on_sensor.boxes[i].size, gripper.boxes[i].size);
    EXPECT_EQ(at(0.0).boxes.size(), gripper.boxes.size() - 1) << name << ": without the sensor";
    const auto thickest = [&](double height) {
      double back = 0.0;
      for (const GripperBox& box : at(height).boxes)
        if (!box.camera) back = std::max(back, 0.5 * box.size.z() - box.p_T_centre.z());
      return back;
    };
    EXPECT_NEAR(thickest(0.0), gripper.tip, 1e-9) << name;
    EXPECT_NEAR(thickest(0.035), gripper.tip + 0.035, 1e-9) << name << ": an FT300";
  }
  Pose tilted = Pose(Eigen::Translation3d(0, 0, 0.1));
  tilted.linear() = Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitX()).toRotationMatrix();
  EXPECT_EQ(mounted_at(make_robotiq_3f(), tilted).boxes.size(), make_robotiq_3f().boxes.size());
}

TEST(OneAgainstOne, PadsFaceEachOtherOnABox) {
  const GripperModel gripper = read_gripper("robotiq-2f-85");
  const Eigen::Vector3d size(0.10, 0.055, 0.045);
  const GraspSet set = grasp_candidates(pad_block(size), gripper, few_directions());
  ASSERT_GT(set.grasps.size(), 20u);
  for (const Grasp& grasp : set.grasps) {
    const Eigen::Vector3d x = grasp.T_O_T.linear().col(0);
    ASSERT_GE(grasp.contacts, 2);
    ASSERT_LE(grasp.contacts, 4);
    for (int i = 0; i < grasp.contacts; ++i) {
      const auto k = static_cast<std::size_t>(i);
      EXPECT_GT((i < grasp.on_a ? 1.0 : -1.0) * grasp.n_O_contact[k].dot(x), 0.5);
      EXPECT_LT((grasp.p_O_contact[k].cwiseAbs() - size / 2).maxCoeff(), 1e-9) << "contact off the box";
      const Eigen::Vector3d p_T = grasp.T_O_T.inverse() * grasp.p_O_contact[k];
      EXPECT_LE(p_T.z(), 1e-9);
      EXPECT_GE(p_T.z(), -gripper.pad_length - 1e-9);
    }
    EXPECT_EQ(grasp.spacing, 0.0);
    EXPECT_LE(grasp.opening, gripper.max_opening - GraspOptions{}.finger_clearance);
    EXPECT_LE(grasp.pre_opening, gripper.max_opening);
  }
}

/// A stone of 26 mm needs two fingers side by side with three fingers; one pad holds it.
TEST(OneAgainstOne, HoldsWhatIsNoLongerThanAPad) {
  const Stone stone = pad_block({0.028, 0.026, 0.024});
  GripperModel apart = make_robotiq_3f();
  apart.narrow_spacing = 0.0;
  EXPECT_TRUE(grasp_candidates(stone, apart, few_directions()).grasps.empty());
  EXPECT_FALSE(grasp_candidates(stone, read_gripper("robotiq-2f-85"), few_directions()).grasps.empty());
}

TEST(OneAgainstOne, IsRefusedWhatIsTooWide) {
  const Stone stone = pad_block({0.10, 0.10, 0.10});
  const GraspSet set = grasp_candidates(stone, read_gripper("robotiq-2f-85"), few_directions());
  EXPECT_TRUE(set.grasps.empty());
  EXPECT_GT(set.too_wide, 0);
  EXPECT_FALSE(grasp_candidates(stone, read_gripper("robotiq-2f-140"), few_directions()).grasps.empty());
  EXPECT_THAT(unfit_for_gripper(stone, read_gripper("robotiq-hand-e")),
              testing::HasSubstr("100 mm across, the fingers open 50 mm"));
}

/// Two point contacts let a stone turn about the line between them; the halves of the pads do not.
TEST(OneAgainstOne, PadsResistTurningAboutTheClosingAxis) {
  const GripperModel gripper = read_gripper("robotiq-2f-85");
  const Stone stone = pad_block({0.10, 0.055, 0.045});
  int beside = 0;
  for (const Grasp& grasp : grasp_candidates(stone, gripper, few_directions()).grasps) {
    if (grasp.contacts != 4) continue;
    GraspContacts contacts = contacts_in_T(grasp, stone.mass.p_O_M);
    const Eigen::Vector3d a = 0.5 * (contacts.p_T[0] + contacts.p_T[1]),
                          b = 0.5 * (contacts.p_T[2] + contacts.p_T[3]);
    if ((contacts.p_T_M - a).cross((b - a).normalized()).norm() < 0.006) continue;
    ++beside;
    EXPECT_TRUE(force_per_weight(contacts, gripper.friction).has_value());
    contacts.p_T[0] = a;
    contacts.p_T[1] = b;
    contacts.n_T[1] = contacts.n_T[2];
    contacts.count = 2;
    contacts.on_a = 1;
    EXPECT_FALSE(force_per_weight(contacts, gripper.friction).has_value()) << "it swings about two points";
  }
  EXPECT_GT(beside, 0) << "some grasps hold the block beside its centre of mass";
}

TEST(OneAgainstOne, BothPadsPressWithTheGripForce) {
  const GripperModel gripper = read_gripper("robotiq-2f-85");
  const Eigen::Vector3d size(0.05, 0.06, 0.06);
  Grasp grasp;
  grasp.T_O_T.translation() = Eigen::Vector3d(0, 0, 0.5 * gripper.pad_length);
  grasp.opening = size.x();
  grasp.pre_opening = size.x() + 0.02;
  const Stone stone = pad_block(size);
  const PadPress pads(sample_surface(stone.scan, 0.002), stone.mass, gripper, grasp);
  const double area = gripper.finger_width * gripper.pad_length;
  for (const int pad : {0, 1})
    EXPECT_NEAR(pads.deepest(pad), gripper.force / (gripper.pad_stiffness * area), 1e-4);
  EXPECT_EQ(pads.deepest(2), 0.0) << "there is no finger C";
  EXPECT_EQ(pads.bear(Eigen::Vector3d::UnitZ(), 2.0).share, 2.0);
}

TEST(ReadGripper, RefusesASpacingThatTheGripperDoesNotHave) {
  EXPECT_NO_THROW((void)with_spacing(read_gripper("robotiq-2f-85"), 0.0));
  EXPECT_THROW((void)with_spacing(read_gripper("robotiq-2f-85"), 0.04), InvalidArgument);
}

}  // namespace
}  // namespace stonestack::motion
