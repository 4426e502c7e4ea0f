#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "core/constants.hpp"
#include "simulation/true_table.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/check_cell.hpp"
#include "stonestack/stone/catalogue.hpp"
#include "watched_arm.hpp"

namespace stonestack::stacking {
namespace {

using namespace simulation;
using testing::HasSubstr;

constexpr double kMillimetre = 0.001;

/// A UR10 over a bare table.
struct BareCell {
  SimulationOptions options;
  Catalogue catalogue = read_catalogue(data_path("stones"));
  RobotModel robot = read_robot("ur10");
  SimulatedCell world;
  Cell devices = world.cell();
  WatchedArm arm{devices.arm, robot, devices.layout.T_F_T};
  Cell cell{arm, devices.gripper, devices.force_torque, devices.camera, devices.clock, devices.layout};

  explicit BareCell(const SimulationOptions& in = options_of_cell("ideal"),
                    const std::vector<StoneIndex>& present = {})
      : options(in), world(catalogue.stones, present, robot, CellLayout{}, in) {}
  [[nodiscard]] TouchedTable touch() { return touch_table(cell, robot); }
  [[nodiscard]] double true_height(const Eigen::Vector2d& p) const {
    return TrueTable(options, 0.5 * (cell.layout.site + cell.layout.field_centre)).height(p.x(), p.y());
  }
  /// Message of the error that `touch` throws.
  template <class Problem = DeviceError>
  [[nodiscard]] std::string problem() {
    try {
      (void)touch();
    } catch (const Problem& error) {
      return error.what();
    }
    return {};
  }
};

TEST(TouchTable, FindsATableThatIsWhereItIsSaidToBe) {
  BareCell in;
  const Joints q_start = in.arm.state().q;
  const TouchedTable table = in.touch();
  EXPECT_LT((in.arm.state().q - q_start).cwiseAbs().maxCoeff(), 1e-3) << "the arm returns";
  EXPECT_NEAR(table.touched.height, 0.0, 0.5 * kMillimetre);
  EXPECT_LT(table.touched.tilt, 0.15 * kDegree);
  EXPECT_THAT(table.problems, testing::IsEmpty()) << to_text(table);
  EXPECT_EQ(in.arm.descents, 3);
  EXPECT_LE(in.arm.fastest_descent, 0.0051);
  EXPECT_LE(in.arm.fastest, 0.255);
  for (const double force : table.force) EXPECT_GT(force, 4.0);
  EXPECT_GT(
      (in.world.cell().layout.T_W_R * forward(in.robot, in.arm.state().q) * in.arm.T_F_T).translation().z(),
      0.05)
      << "the arm is left above the table";
}

/// A table beside z = 0 and tilted; the camera sees it so, too.
TEST(TouchTable, MeasuresHeightAndTilt) {
  for (const int seed : {1, 2}) {
    SimulationOptions options = options_of_cell("ideal");
    options.seed = seed;
    options.table_height = 0.008;
    options.table_tilt = 0.02;
    BareCell in(options);
    const TouchedTable table = in.touch();
    const Eigen::Vector2d middle = in.cell.layout.field_centre;
    EXPECT_NEAR(table.touched.height, in.true_height(middle), 0.6 * kMillimetre) << to_text(table);
    EXPECT_NEAR(table.touched.tilt, 0.02, 0.15 * kDegree);
    EXPECT_THAT(table.problems, testing::IsEmpty()) << to_text(table);
    for (const Eigen::Vector3d& p_W : table.p_W) {
      EXPECT_NEAR(p_W.z(), in.true_height(p_W.head<2>()), 0.6 * kMillimetre);
      const Eigen::Vector3d corrected = table.T_W_R * in.cell.layout.T_W_R.inverse() * p_W;
      EXPECT_NEAR(corrected.z(), 0.0, 1e-9) << "with T_W_R the table is z = 0";
    }
  }
}

TEST(TouchTable, AgreesInACellWithTheErrorsOfALab) {
  SimulationOptions options = options_of_cell("lab");
  options.table_unevenness = 0.0;
  BareCell in(options);
  const TouchedTable table = in.touch();
  EXPECT_NEAR(table.touched.height, in.true_height(in.cell.layout.field_centre), 3 * kMillimetre)
      << to_text(table);
}

TEST(TouchTable, SaysWhatToDoWhereTheCameraDisagrees) {
  BareCell lifted;
  lifted.cell.layout.T_T_C.translation().z() -= 0.012;  // said to be further from the table than it is
  const TouchedTable high = lifted.touch();
  EXPECT_NEAR(high.apart.height, 0.012, 2 * kMillimetre) << to_text(high);
  ASSERT_EQ(high.problems.size(), 1U) << to_text(high);
  EXPECT_THAT(high.problems[0], testing::AllOf(testing::ContainsRegex("1[12] mm above"),
                                               HasSubstr("layout.T_F_T"), HasSubstr("stonestack calibrate")));
  EXPECT_NEAR(high.touched.height, 0.0, 0.5 * kMillimetre) << "the touch does not depend on the camera";

  BareCell turned;
  const Eigen::Vector3d p_T_C = turned.cell.layout.T_T_C.translation();
  turned.cell.layout.T_T_C.linear() =
      turned.cell.layout.T_T_C.linear() * Eigen::AngleAxisd(2.0 * kDegree, Eigen::Vector3d::UnitX()).matrix();
  ASSERT_EQ(p_T_C, turned.cell.layout.T_T_C.translation());
  const TouchedTable tilted = turned.touch();
  EXPECT_NEAR(tilted.apart.tilt, 2.0 * kDegree, 0.3 * kDegree) << to_text(tilted);
  ASSERT_FALSE(tilted.problems.empty());
  EXPECT_THAT(tilted.problems.back(),
              testing::AllOf(testing::ContainsRegex(" (1.9|2|2.1) deg"), HasSubstr("stonestack calibrate")));
  EXPECT_THAT(to_text(tilted), HasSubstr("FAIL  the camera sees"));
}

TEST(TouchTable, AStoneInTheFieldIsNotTouched) {
  BareCell in(options_of_cell("ideal"), {StoneIndex(0)});
  const Truth before = in.world.truth();
  const TouchedTable table = in.touch();
  EXPECT_LT(difference(in.world.truth().T_W_O[0], before.T_W_O[0]).translation, 0.1 * kMillimetre);
  EXPECT_NEAR(table.touched.height, 0.0, 0.5 * kMillimetre);
}

TEST(TouchTable, ADescentThatMeetsNothingIsReportedFromAboveTheTable) {
  SimulationOptions options = options_of_cell("ideal");
  options.table_height = 0.045;
  while (TrueTable(options, CellLayout{}.field_centre).height(0.7, 0.0) > 0) ++options.seed;  // below
  BareCell in(options);
  in.cell.layout.T_T_C.translation().z() -= 0.045;  // the camera has it at z = 0
  EXPECT_THAT(in.problem(),
              testing::AllOf(HasSubstr("met nothing"), HasSubstr("point 1 of 3"), HasSubstr("layout.T_F_T")));
  EXPECT_EQ(in.arm.descents, 1) << "it does not go on";
  const Pose T_W_T = in.cell.layout.T_W_R * forward(in.robot, in.arm.state().q) * in.arm.T_F_T;
  EXPECT_GT(T_W_T.translation().z(), 0.05);
  EXPECT_TRUE(in.arm.state().can_move);
  EXPECT_GE(in.arm.stops, 1);
}

TEST(TouchTable, PointsThatTheGripperCannotReachAreSaidBeforeItGoesDown) {
  BareCell in;
  Obstacle shelf;
  shelf.name = "shelf";
  shelf.pieces = {make_box({1.0, 1.2, 0.02})};
  shelf.T_W_O = make_pose({0.7, -0.1, 0.20});
  in.cell.layout.obstacles.push_back(shelf);
  EXPECT_THAT(in.problem(), testing::AllOf(HasSubstr("no three points"), HasSubstr("clear the field")));
  EXPECT_EQ(in.arm.descents, 0);
}

TEST(TouchTable, AStopEndsItWithTheExitCodeOfOne) {
  BareCell in;
  in.arm.stopped_at = 1;
  EXPECT_THAT(in.problem(), HasSubstr("a person came near"));
  EXPECT_EQ(in.arm.descents, 2);
  EXPECT_GE(in.arm.stops, 1);
}

TEST(TouchTable, TheResultIsJson) {
  TouchedTable table;
  table.apart = {0.007, 0.01};
  table.problems = {"the camera sees it elsewhere"};
  const auto json = nlohmann::json::parse(touched_table_json(table));
  EXPECT_EQ(json["schema"], "stonestack.table/1");
  EXPECT_EQ(json["points"].size(), 3U);
  EXPECT_NEAR(json["apart"]["height_mm"].get<double>(), 7.0, 1e-9);
  EXPECT_NEAR(json["apart"]["tilt_deg"].get<double>(), 0.573, 1e-3);
  EXPECT_FALSE(json["agree"].get<bool>());
  EXPECT_EQ(json["T_W_R"]["qw"], 1.0);
}

}  // namespace
}  // namespace stonestack::stacking
