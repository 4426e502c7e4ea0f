#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/geometry/mesh.hpp"

namespace stonestack {
namespace {

using ::testing::Not;

/// `stonestack check` on cubes of 50 mm, whose figures are known.
class CheckCommand : public Commands {
 protected:
  void SetUp() override {
    Commands::SetUp();
    write_mesh(folder_ + "/cube.ply", make_box({0.05, 0.05, 0.05}));
    ASSERT_EQ(run("scan cube.ply --catalogue boxes").code, 0);
  }
  /// Cubes with their centres at these x and z.
  [[nodiscard]] Outcome check(const std::vector<std::pair<double, double>>& cubes,
                              const std::string& options) const {
    std::string text = "schema: stonestack.scene/1\nstack:\n";
    for (const auto& [x, z] : cubes)
      text +=
          concat("  - {stone: cube, T_W_O: {x: ", x, ", y: 0, z: ", z, ", qx: 0, qy: 0, qz: 0, qw: 1}}\n");
    write("cubes.yaml", text);
    return run("check cubes.yaml --catalogue boxes --seconds 1 " + options);
  }
};

TEST_F(CheckCommand, TheMarginOfACubeOnACubeIsTipOrSlideWhicheverIsLess) {
  for (const double friction : {0.1, 0.3, 0.8}) {
    const Outcome outcome = check({{0, 0.025}, {0, 0.075}}, concat("--json --friction ", friction));
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const double expected = std::min(friction, 0.5);  // half width over height of the common centre
    EXPECT_NEAR(outcome.data()["margin_g"].get<double>(), expected, 0.005 * expected);
  }
}

TEST_F(CheckCommand, DistinguishesAFallFromAnUncleanContact) {
  const Outcome beside = check({{0, 0.025}, {0.06, 0.025}}, "");
  EXPECT_EQ(beside.code, 5);
  EXPECT_THAT(beside.err, HasSubstr("the stack stands, but not cleanly: stone 1 (cube) touches the table"));
  const Outcome falls = check({{0, 0.025}, {0.06, 0.025}, {0.09, 0.075}}, "");
  EXPECT_EQ(falls.code, 5);
  EXPECT_THAT(falls.err, HasSubstr("the stack does not stand: stone 2 (cube) moved"));
  EXPECT_THAT(falls.err, HasSubstr("; stone 1 (cube) touches the table"));
  EXPECT_THAT(falls.err, Not(HasSubstr("e-0"))) << "digits that nobody needs";
}

TEST_F(CheckCommand, StonesThatCutIntoEachOtherAreRefused) {
  const Outcome outcome = check({{0, 0.025}, {0, 0.070}}, "");
  EXPECT_EQ(outcome.code, 3);
  EXPECT_THAT(outcome.err, HasSubstr("cube and cube overlap by 5 mm"));
}

}  // namespace
}  // namespace stonestack
