#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cell_bench.hpp"
#include "simulation/true_world.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::simulation {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::vector<std::string> texts(SimulationOptions options) {
  std::vector<std::string> all;
  for (const Field& field : fields(options)) all.push_back(field.name + "=" + field_text(field));
  return all;
}

double number(SimulationOptions options, const std::string& name) {
  for (const Field& field : fields(options))
    if (field.name == name) return std::stod(field_text(field));
  ADD_FAILURE() << "no option " << name;
  return 0.0;
}

TEST(NamedCells, MildIsTheDefault) {
  EXPECT_EQ(texts(options_of_cell("mild")), texts({}));
}

TEST(NamedCells, OthersAreRefusedByName) {
  EXPECT_THROW((void)options_of_cell("factory"), InvalidArgument);
}

/// Every option of the list below is an error or belongs to one.
const std::vector<std::string> kErrors{
    "friction_spread",   "lens_focal",          "lens_centre",      "lens_distortion", "hand_eye_translation",
    "arm_repeatability", "hand_eye_rotation",   "base_translation", "base_rotation",   "table_height",
    "table_tilt",        "table_unevenness",    "force_delay",      "force_drift",     "mass_error",
    "com_error",         "scan_error",          "scan_roughness",   "arm_kinematics",  "arm_backlash",
    "arm_compliance",    "pad_friction_spread", "foreign_objects"};

TEST(NamedCells, IdealHasNoErrorLabHasAllAndHardHasThemTwice) {
  for (const auto& name : kErrors) {
    EXPECT_EQ(number(options_of_cell("ideal"), name), 0.0) << name;
    EXPECT_GT(number(options_of_cell("lab"), name), 0.0) << name;
    EXPECT_DOUBLE_EQ(number(options_of_cell("hard"), name), 2.0 * number(options_of_cell("lab"), name))
        << name;
  }
  EXPECT_FALSE(options_of_cell("ideal").sensor_noise);
  EXPECT_EQ(options_of_cell("ideal").pad_stiffness_spread, 1.0);
  EXPECT_EQ(options_of_cell("ideal").arm_residual, 0.0);
  EXPECT_EQ(options_of_cell("hard").sensor_scale, 2.0);
}

TEST(NamedCells, PaperIsASlipperyLab) {
  SimulationOptions paper = options_of_cell("paper");
  EXPECT_DOUBLE_EQ(paper.friction - paper.friction_spread, 0.1);
  EXPECT_DOUBLE_EQ(paper.friction + paper.friction_spread, 0.2);
  paper.cell = "lab";
  EXPECT_THAT(changed_in_cell(paper), ElementsAre("friction=0.15", "friction_spread=0.05"));
}

TEST(NamedCells, OptionsSetBesideTheCellAreNamed) {
  SimulationOptions options = options_of_cell("lab");
  options.seed = 7;
  EXPECT_THAT(changed_in_cell(options), IsEmpty());
  options.foreign_objects = 0;
  EXPECT_THAT(changed_in_cell(options), ElementsAre("foreign_objects=0"));
}

TEST(NamedCells, ASeedDrawsTheWholeLabAndTheSameSeedTheSame) {
  const std::vector<Stone> stones{make_pebble("a", 0.6), make_pebble("b", 1.0)};
  SimulationOptions options = options_of_cell("lab");
  const auto state = [&](int seed) {
    options.seed = seed;
    CellBench bench(stones, options);
    const auto pose = tool_down({0.7, 0.1, 0.3});
    std::vector<double> numbers;
    for (const Pose& T_W_O : bench.simulated.truth().T_W_O)
      for (const double value : T_W_O.matrix().reshaped()) numbers.push_back(value);
    for (const double value : bench.go(pose).q) numbers.push_back(value);
    for (const double value : bench.simulated.world().gripper_pose().T_W_T.matrix().reshaped())
      numbers.push_back(value);
    for (const double value : bench.cell.force_torque.read().force) numbers.push_back(value);
    for (const float z : bench.cell.camera.capture().image.z) numbers.push_back(z);
    for (const double x : {0.5, 0.9}) numbers.push_back(bench.simulated.world().table().height(x, 0.2));
    return numbers;
  };
  const auto first = state(1);
  EXPECT_EQ(first, state(1));
  EXPECT_NE(first, state(2));
}

}  // namespace
}  // namespace stonestack::simulation
