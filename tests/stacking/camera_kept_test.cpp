// A camera that is pushed aside in its mount while a run is under way, and a stone that is.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "rooms.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/build_tower.hpp"

namespace stonestack::stacking {
namespace {

using namespace simulation;  // the cell that the loop works in here

constexpr std::ptrdiff_t kAside = 40;  // pixels: some 50 mm at the site

/// A camera in whose first frame of the stone at the site something has been pushed aside: itself, or the
/// stone.
struct PushedCamera : DepthCamera {
  SimulatedCell& world;
  Cell cell;
  bool itself, pushed = false;
  int frames = 0;  ///< since then
  PushedCamera(SimulatedCell& w, bool camera_moves) : world(w), cell(w.cell()), itself(camera_moves) {}
  DepthFrame capture() override {
    Pose T_W_O = world.truth().T_W_O[0];
    const bool built = (T_W_O.translation().head<2>() - cell.layout.site).norm() < 0.1;
    if (built && !pushed && !itself) {
      T_W_O.translation() += Eigen::Vector3d(0.04, 0.02, 0.0);
      world.place(StoneIndex(0), T_W_O);
    }
    pushed = pushed || built;
    frames += pushed ? 1 : 0;
    DepthFrame frame = cell.camera.capture();
    if (!itself || !pushed) return frame;
    const auto width = static_cast<std::ptrdiff_t>(frame.image.camera.width);
    for (auto row = frame.image.z.begin(); row != frame.image.z.end(); row += width) {
      std::rotate(row, row + kAside, row + width);
      std::fill(row + width - kAside, row + width, 0.0F);
    }
    return frame;
  }
};

RunResult run_pushed(bool camera_moves, int& frames) {
  Catalogue catalogue = read_catalogue(data_path("stones"));
  catalogue.stones.resize(1);
  const RobotModel robot = read_robot("ur10");
  SimulationOptions simulation = options_of_cell("ideal");
  simulation.seed = 1;
  SimulatedCell world(catalogue.stones, {StoneIndex(0)}, robot, CellLayout{}, simulation);
  const Cell real = world.cell();
  PushedCamera camera(world, camera_moves);
  Cell cell{real.arm, real.gripper, real.force_torque, camera, real.clock, real.layout};
  BuildOptions options;
  options.measure_friction = options.refine_camera = false;
  options.search.horizon = 1;
  options.search.perturbations = 0;
  RunResult result = build_tower(cell, catalogue, robot, options);
  frames = camera.frames;
  return result;
}

TEST(CameraKept, ACameraThatIsPushedAsideEndsTheRun) {
  int frames = 0;
  const RunResult result = run_pushed(true, frames);
  EXPECT_EQ(result.end, RunResult::End::kStopped);
  EXPECT_THAT(result.ended, testing::HasSubstr("its mount has moved"));
  EXPECT_TRUE(result.placements.empty()) << "nothing is learned from what it shows";
}

TEST(CameraKept, AStoneThatIsPushedAsideDoesNot) {
  int frames = 0;
  const RunResult result = run_pushed(false, frames);
  EXPECT_EQ(frames, 3) << "of site and field, and one with the camera turned";
  EXPECT_NE(result.end, RunResult::End::kStopped) << result.ended;
  ASSERT_FALSE(result.placements.empty());
  EXPECT_EQ(result.placements.front().outcome, PlacementRecord::Outcome::kMoved)
      << result.placements.front().note;
}

}  // namespace
}  // namespace stonestack::stacking
