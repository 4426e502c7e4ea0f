#include <gmock/gmock.h>

#include "core/constants.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/check_cell.hpp"
#include "watched_arm.hpp"

namespace stonestack::stacking {
namespace {

using namespace simulation;
using testing::HasSubstr;

/// The mount as a tape measures it: 20 mm and 4 deg off.
CellLayout measured_by_tape() {
  CellLayout layout;
  layout.T_T_C.translation() += Eigen::Vector3d(0.012, -0.010, 0.012);
  layout.T_T_C.linear() =
      layout.T_T_C.linear() *
      Eigen::AngleAxisd(4.0 * kDegree, Eigen::Vector3d(1.0, -1.0, 0.5).normalized()).matrix();
  return layout;
}

/// A UR10 whose camera really sits where CellLayout has it, over one target.
struct CaptureCell {
  Catalogue targets;
  RobotModel robot = read_robot("ur10");
  SimulatedCell world;
  Cell devices = world.cell();
  WatchedArm arm{devices.arm, robot, devices.layout.T_F_T};
  Cell cell{arm, devices.gripper, devices.force_torque, devices.camera, devices.clock, measured_by_tape()};

  explicit CaptureCell(Catalogue known, const std::vector<StoneIndex>& present = {StoneIndex{0}},
                       const SimulationOptions& options = options_of_cell("ideal"))
      : targets(std::move(known)), world(targets.stones, present, robot, CellLayout{}, options) {}
  [[nodiscard]] HandEyeFile capture(const CaptureOptions& options) {
    return capture_stations(cell, robot, targets, options);
  }
  template <class Problem = DeviceError>
  [[nodiscard]] std::string problem(const CaptureOptions& options) {
    try {
      (void)capture(options);
    } catch (const Problem& error) {
      return error.what();
    }
    return {};
  }
};

/// Rest of the 20 mm and 4 deg.
PoseDifference left_over(const HandEyeFile& stations) {
  const HandEyeCalibration done = calibrate_stations(stations);
  EXPECT_EQ(done.uncertainty, "");
  const CellLayout truth;
  return difference(done.chosen.T_A_C, truth.T_F_T * truth.T_T_C);
}

TEST(CaptureStations, MeasuresTheMountWithAStone) {
  CaptureCell in(read_catalogue(data_path("stones")), {0_stone, 3_stone});
  const HandEyeFile stations = in.capture({12, in.targets[3_stone].name});
  EXPECT_EQ(stations.pairs.size(), 12U);
  const PoseDifference off = left_over(stations);
  EXPECT_LT(off.translation, 0.0015);
  EXPECT_LT(off.angle, 0.25 * kDegree);
  EXPECT_LE(in.arm.fastest, 0.255);
  EXPECT_EQ(in.arm.descents, 0);
}

TEST(CaptureStations, MeasuresTheMountWithABlock) {
  CaptureCell in(block_target({0.12, 0.08, 0.05}));
  const PoseDifference off = left_over(in.capture({12, ""}));
  EXPECT_LT(off.translation, 0.0015);
  EXPECT_LT(off.angle, 0.25 * kDegree);
}

TEST(CaptureStations, NothingMovesAfterAStop) {
  CaptureCell in(block_target({0.12, 0.08, 0.05}));
  in.arm.stopped_on_route = 3;
  EXPECT_THAT(in.problem({12, ""}), HasSubstr("a person came near"));
  EXPECT_EQ(in.arm.routes, 4) << "the one that was stopped is the last";
  EXPECT_EQ(in.arm.stops, 1);
}

TEST(CaptureStations, AnEmptyFieldSaysWhatToDo) {
  CaptureCell in(read_catalogue(data_path("stones")), {});
  EXPECT_THAT(in.problem({12, ""}),
              testing::AllOf(HasSubstr("none of the targets"), HasSubstr("lay the target")));
  EXPECT_EQ(in.arm.stops, 1);
  EXPECT_THAT(in.problem<InvalidArgument>({12, "granite"}), HasSubstr("granite"));
  EXPECT_THAT(in.problem<InvalidArgument>({2, ""}), HasSubstr("at least 4"));
}

TEST(CaptureStations, ABlockHasThreeSidesThatDiffer) {
  EXPECT_THROW((void)block_target({0.1, 0.1, 0.05}), InvalidArgument);
  EXPECT_THROW((void)block_target({0.1, 0.08, 0.005}), InvalidArgument);
  EXPECT_THROW((void)block_target({0.1, 0.08, std::nan("")}), InvalidArgument);
  EXPECT_EQ(block_target({0.12, 0.08, 0.05}).stones.size(), 1U);
}

}  // namespace
}  // namespace stonestack::stacking
