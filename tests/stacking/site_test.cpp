#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "stacking/arrangement.hpp"
#include "stacking/heard.hpp"
#include "stacking/hiding_camera.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/build_tower.hpp"

/// Behaviour of a run with what stands at the site when it begins.
namespace stonestack::stacking {
namespace {

using namespace simulation;  // the cell that the loop works in here

using testing::HasSubstr;

/// A camera that looks straight down on an empty table from 0.6 m, above `p_W`.
CameraView look_down(const Eigen::Vector2d& p_W) {
  CameraView view;
  view.T_W_C.linear() = Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()).toRotationMatrix();
  view.T_W_C.translation() << p_W, 0.6;
  const CameraIntrinsics& camera = view.image.camera;
  view.image.z.assign(static_cast<std::size_t>(camera.width * camera.height), 0.6F);
  return view;
}

TEST(SiteIn, DistinguishesTableObjectsAndNothing) {
  const Eigen::Vector2d site(0.7, 0.28);
  EXPECT_EQ(site_in({look_down(site)}, site), SiteStatus::kFree);
  EXPECT_EQ(site_in({look_down(site - Eigen::Vector2d(0, 0.8))}, site), SiteStatus::kUnseen);
  CameraView blind = look_down(site);
  for (float& z : blind.image.z) z = 0.0F;
  EXPECT_EQ(site_in({blind}, site), SiteStatus::kUnseen) << "no depth is no table";
  CameraView thing = look_down(site);
  const CameraIntrinsics& camera = thing.image.camera;
  for (int v = camera.height / 2; v < camera.height / 2 + 40; ++v)  // 5 cm square, 5 cm high
    for (int u = camera.width / 2; u < camera.width / 2 + 40; ++u)
      thing.image.z[static_cast<std::size_t>(v * camera.width + u)] = 0.55F;
  EXPECT_EQ(site_in({thing}, site), SiteStatus::kOccupied);
  EXPECT_EQ(site_in({look_down(site), thing}, site), SiteStatus::kOccupied) << "one view is enough";
}

/// Takes the depth of one half of the columns away.
void hide_half(DepthImage& image, bool right) {
  for (int v = 0; v < image.camera.height; ++v)
    for (int u = 0; u < image.camera.width; ++u)
      if ((u >= image.camera.width / 2) == right)
        image.z[static_cast<std::size_t>(v * image.camera.width + u)] = 0.0F;
}

TEST(SiteIn, ViewsThatShowPartOfItEachAreTakenTogether) {
  const Eigen::Vector2d site(0.7, 0.28);
  CameraView left = look_down(site), right = look_down(site);
  hide_half(left.image, false);
  hide_half(right.image, true);
  EXPECT_EQ(site_in({left}, site), SiteStatus::kUnseen);
  EXPECT_EQ(site_in({left, left}, site), SiteStatus::kUnseen) << "the same half twice";
  EXPECT_EQ(site_in({left, right}, site), SiteStatus::kFree);
}

TEST(SiteIn, DepthsThatAreNoNumbersShowNothing) {
  const Eigen::Vector2d site(0.7, 0.28);
  for (const float depth : {std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN(),
                            std::numeric_limits<float>::max()}) {
    CameraView view = look_down(site);
    view.image.camera.cx = 320.0;  // a ray straight down: zero times infinity
    view.image.camera.cy = 240.0;
    for (float& z : view.image.z) z = depth;
    EXPECT_EQ(site_in({view}, site), SiteStatus::kUnseen) << depth;
  }
}

struct Started {
  Catalogue catalogue = read_catalogue(data_path("stones"));
  RobotModel robot = read_robot("ur10");
  std::unique_ptr<SimulatedCell> world;
  std::string message;

  explicit Started(const std::vector<StoneIndex>& present) {
    SimulationOptions options;
    options.seed = 7;
    world = std::make_unique<SimulatedCell>(catalogue.stones, present, robot, CellLayout{}, options);
  }
  /// As it lies.
  void bring_to_site(StoneIndex stone) const {
    const Truth truth = world->truth();
    Pose T_W_O = at(truth.T_W_O, stone);
    T_W_O.translation().head<2>() = CellLayout{}.site;
    world->place(stone, T_W_O);
  }
  RunResult build(int max_stones, const Catalogue& known) {
    BuildOptions options;
    options.max_stones = max_stones;
    options.search.horizon = 1;
    Cell cell = world->cell();
    RunResult result = build_tower(cell, known, robot, options);
    message = test::words(result.events, known);
    return result;
  }
};

TEST(Site, AnExistingTowerIsBuiltOn) {
  Started lab({1_stone, 2_stone, 3_stone});
  const RunResult first = lab.build(2, lab.catalogue);
  ASSERT_EQ(first.height, 2) << lab.message;
  EXPECT_TRUE(all_of<SiteOccupied>(first.events).empty());
  const Truth before = lab.world->truth();
  const RunResult second = lab.build(3, lab.catalogue);
  EXPECT_EQ(all_of<SiteOccupied>(second.events).size(), 1U);
  EXPECT_EQ(second.height, 3) << lab.message;
  using Outcome = PlacementRecord::Outcome;
  ASSERT_FALSE(second.placements.empty());
  EXPECT_EQ(second.placements.back().outcome, Outcome::kPlaced) << lab.message;
  for (const PlacementRecord& record : second.placements) {
    EXPECT_EQ(record.stone, second.placements.back().stone) << "only the third stone is touched";
    EXPECT_NE(record.outcome, Outcome::kUnstacked) << lab.message;
  }
  const Truth after = lab.world->truth();
  for (std::size_t i = 0; i < 2; ++i) {
    const StoneIndex stone = first.world.stack[i].stone;
    EXPECT_EQ(second.world.stack[i].stone, stone);
    EXPECT_LT(difference(at(after.T_W_O, stone), at(before.T_W_O, stone)).translation, 0.003);
  }
}

TEST(Site, AnUnseenSiteIsNotBuiltOn) {
  Started lab({1_stone, 2_stone});
  const Cell seeing = lab.world->cell();
  test::HidingCamera blind(seeing, lab.robot);
  blind.p_W_hidden = seeing.layout.site;
  blind.radius = 0.15;
  Cell cell{seeing.arm, seeing.gripper, seeing.force_torque, blind, seeing.clock, seeing.layout};
  BuildOptions options;
  options.max_stones = 1;
  const RunResult result = build_tower(cell, lab.catalogue, lab.robot, options);
  EXPECT_EQ(result.end, RunResult::End::kNoPose);
  EXPECT_THAT(result.ended, HasSubstr("no view shows whether something stands at the site"));
  EXPECT_TRUE(result.placements.empty());
}

/// A camera of which half of the image has failed.
struct HalfCamera : DepthCamera {
  DepthCamera& camera;
  bool right;
  HalfCamera(DepthCamera& real, bool right_half) : camera(real), right(right_half) {}
  DepthFrame capture() override {
    DepthFrame frame = camera.capture();
    hide_half(frame.image, right);
    return frame;
  }
};

TEST(Site, IsSeenTurnedWhereHalfOfTheImageIsMissing) {
  for (const bool right : {false, true}) {
    Started lab({1_stone});
    const Cell real = lab.world->cell();
    HalfCamera camera(real.camera, right);
    Cell cell{real.arm, real.gripper, real.force_torque, camera, real.clock, real.layout};
    BuildOptions options;
    options.max_stones = 1;
    options.refine_camera = false;
    options.search.horizon = 1;
    const RunResult result = build_tower(cell, lab.catalogue, lab.robot, options);
    EXPECT_EQ(result.height, 1) << (right ? "right" : "left") << " half: " << result.ended;
  }
}

TEST(Site, AnUnknownObjectIsNotBuiltOn) {
  Started lab({1_stone, 2_stone, 5_stone});
  lab.bring_to_site(5_stone);
  Catalogue known = lab.catalogue;
  known.stones.pop_back();
  const RunResult result = lab.build(1, known);
  EXPECT_EQ(result.end, RunResult::End::kNoPose);
  EXPECT_THAT(result.ended, HasSubstr("none of the known stones: clear the site"));
  EXPECT_TRUE(result.placements.empty());
}

/// A camera that sends no frame from the third on: of the field, of the site, of the site's other side.
struct FailingCamera : DepthCamera {
  DepthCamera& camera;
  int frames = 0;
  explicit FailingCamera(DepthCamera& real) : camera(real) {}
  DepthFrame capture() override {
    if (++frames > 2) throw DeviceError("camera", "sends no frame", "look at its cable");
    return camera.capture();
  }
};

TEST(Site, ACameraThatFailsAtTheSitesOtherSideEndsTheRun) {
  Started lab({1_stone, 2_stone});
  lab.bring_to_site(2_stone);
  const Cell real = lab.world->cell();
  FailingCamera camera(real.camera);
  Cell cell{real.arm, real.gripper, real.force_torque, camera, real.clock, real.layout};
  BuildOptions options;
  options.max_stones = 1;
  options.refine_camera = false;
  const RunResult result = build_tower(cell, lab.catalogue, lab.robot, options);
  EXPECT_EQ(all_of<SiteOccupied>(result.events).size(), 1U) << "after the second frame";
  EXPECT_TRUE(all_of<SiteSeenFromOneSide>(result.events).empty()) << "no device's failure is a missing route";
  EXPECT_EQ(camera.frames, 3) << "not asked again";
  EXPECT_EQ(result.end, RunResult::End::kStopped);
  EXPECT_THAT(result.ended, HasSubstr("sends no frame"));
}

}  // namespace
}  // namespace stonestack::stacking
