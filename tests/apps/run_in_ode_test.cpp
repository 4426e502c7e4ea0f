// A whole run whose true world is stepped by ODE, while the planner counts on Bullet.
#include "commands.hpp"

namespace stonestack {
namespace {

TEST_F(Commands, ARunInOdeBuildsATowerThatBothEnginesLetStand) {
  const std::string small = "run --per-run 2 --seed 1 --json --set search.perturbations=2 ";
  const Outcome done = run(small + "--set simulation.engine=ode --out ode");
  ASSERT_EQ(done.code, 0) << done.err;
  const json result = done.data();
  EXPECT_EQ(result["height"], 2) << result["reason"];
  EXPECT_TRUE(result["truth"]["stands"]) << result["truth"];
  ASSERT_EQ(result["truth"]["engines"].size(), 2U);
  for (const auto& verdict : result["truth"]["engines"]) EXPECT_EQ(verdict["height"], 2) << verdict;
  EXPECT_THAT(read_file(folder_ + "/ode/options.yaml", 1 << 20), HasSubstr("engine: ode"));
  // Another engine, another course: the same stones come to rest elsewhere.
  const json in_bullet = run(small + "--height 1 --out bullet").data();
  EXPECT_NE(in_bullet["placements"][0]["T_W_O_measured"], result["placements"][0]["T_W_O_measured"]);
  expect_refusal("run --set simulation.engine=mujoco", 2, {"mujoco", "bullet and ode"});
}

}  // namespace
}  // namespace stonestack
