// `stonestack plan` on scenes that can be read but cannot be.
#include "commands.hpp"

namespace stonestack::apps {
namespace {

constexpr const char* kStone =
    "  - stone: limestone_3\n    T_W_O: {x: 0.8779, y: -0.3412, z: 0.04204, qx: 0.3275739, qy: 0.9444004, "
    "qz: -0.017231, qw: 0.0225038}\n";
constexpr const char* kPlan = "plan scene.yaml --stone limestone_3 --target 0.7,0.28,0.06,0,0,0,1";

TEST_F(Commands, PlanRefusesStonesThatLieInEachOther) {
  write("scene.yaml", concat("schema: stonestack.scene/1\nstones:\n", kStone,
                             "  - stone: limestone_1\n    T_W_O: {x: 0.89, y: -0.34, z: 0.042, qx: 0, qy: 0, "
                             "qz: 0, qw: 1}\n"));
  expect_refusal(kPlan, 6, {"no plan", "limestone_3 and limestone_1 overlap by", "mm"});
}

TEST_F(Commands, PlanRefusesAStartInsideAnObstacle) {
  write("scene.yaml",
        concat("schema: stonestack.scene/1\nstones:\n", kStone,
               "obstacles:\n  - {name: cupboard, box: {x: 0.5, y: 0.5, z: 0.3}, T_W_O: {x: 0.5, y: "
               "0, z: 0.6, qx: 0, qy: 0, qz: 0, qw: 1}}\n"));
  expect_refusal(kPlan, 6, {"no plan", "at the start the arm stands in something", "cupboard"});
}

}  // namespace
}  // namespace stonestack::apps
