#include "stonestack/motion/planning_scene.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <set>

#include "stonestack/core/error.hpp"

namespace stonestack::motion {
namespace {

Stone block(const Eigen::Vector3d& size, double density = 2600.0) {
  Stone stone;
  stone.name = "block";
  stone.scan = stone.mesh = make_box(size);
  stone.mass = mass_properties(stone.scan, density);
  return stone;
}

TEST(FitForGripper, WidthIsMeasuredAcrossTheRestingStone) {
  EXPECT_NEAR(min_width_at_rest(block({0.14, 0.10, 0.07})), 0.07, 1e-9) << "on its narrow side";
  // A plate stands on its faces only: there it is 0.18 m across, though 0.02 m thick.
  EXPECT_NEAR(min_width_at_rest(block({0.20, 0.18, 0.02})), 0.18, 1e-9);
}

TEST(FitForGripper, NamesTheLimitThatIsExceeded) {
  const GripperModel gripper = make_robotiq_3f();
  EXPECT_EQ(unfit_for_gripper(block({0.12, 0.09, 0.06}), gripper), "");
  EXPECT_EQ(unfit_for_gripper(block({0.20, 0.18, 0.02}), gripper), "180 mm across, the fingers open 155 mm");
  EXPECT_THAT(unfit_for_gripper(block({0.12, 0.09, 0.06}, 5000.0), gripper),
              testing::HasSubstr("kg, the fingers carry 2.5 kg"));
}

TEST(FitForGripper, TheArmCarriesTheGripperToo) {
  const GripperModel gripper = make_robotiq_3f();  // 2.5 kg, with sensor and camera 3.35 kg
  const Stone stone = block({0.12, 0.09, 0.06});   // 1.7 kg
  RobotModel robot;
  robot.name = "ur5";
  robot.payload = carried_mass(gripper) + stone.mass.mass + 0.001;
  EXPECT_EQ(unfit_for_gripper(stone, gripper, robot), "");
  robot.payload = 5.0;
  EXPECT_THAT(unfit_for_gripper(stone, gripper, robot),
              testing::HasSubstr("kg, ur5 carries 5 kg, 3.35 kg of them the gripper with sensor and camera"));
  EXPECT_GT(carried_mass(gripper), sensed_mass(gripper)) << "the sensor does not feel itself";
  EXPECT_GT(sensed_mass(gripper), gripper.mass);
}

TEST(FitForGripper, DrawsOnlyStonesThatCanBeCarried) {
  const GripperModel gripper = make_robotiq_3f();
  const RobotModel robot = read_robot("ur10");
  Catalogue catalogue;
  for (int k = 0; k < 6; ++k) catalogue.stones.push_back(block({0.12, 0.09, 0.06}));
  catalogue.stones[2] = block({0.20, 0.18, 0.02});  // too wide
  EXPECT_EQ(draw_stones(catalogue, 9, 1, gripper, robot),
            (std::vector<StoneIndex>{0_stone, 1_stone, 3_stone, 4_stone, 5_stone}));
  std::set<std::vector<StoneIndex>> drawn;
  for (int seed = 1; seed <= 20; ++seed) {
    const std::vector<StoneIndex> stones = draw_stones(catalogue, 3, seed, gripper, robot);
    ASSERT_EQ(stones.size(), 3U);
    EXPECT_TRUE(std::is_sorted(stones.begin(), stones.end()));
    EXPECT_EQ(draw_stones(catalogue, 3, seed, gripper, robot), stones);
    drawn.insert(stones);
  }
  EXPECT_GT(drawn.size(), 4U) << "of ten possible sets";
  catalogue.stones = {block({0.20, 0.18, 0.02})};
  EXPECT_THROW((void)draw_stones(catalogue, 1, 1, gripper, robot), Error);
}

TEST(FitForGripper, StoneWithoutMassIsRefused) {
  Stone stone = block({0.1, 0.1, 0.1});
  stone.mass.mass = 0.0;
  EXPECT_THROW((void)min_width_at_rest(stone), InvalidArgument);
}

}  // namespace
}  // namespace stonestack::motion
