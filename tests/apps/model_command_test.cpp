// What `stonestack model` and `scan --cell` make of views of stones that nobody scanned, and what they
// refuse.
#include "commands.hpp"
#include "stonestack/stone/catalogue.hpp"

namespace stonestack {
namespace {

class ModelCommand : public Commands {};

TEST_F(ModelCommand, MakesACatalogueThatOtherCommandsRead) {
  ASSERT_EQ(run("render --out scene --seed 3 --stones limestone_1,limestone_4").code, 0);
  const Outcome made = run("model scene/scene.yaml --catalogue rocks --json");
  ASSERT_EQ(made.code, 0) << made.err;
  const json data = made.data();
  EXPECT_EQ(data["schema"], "stonestack.model/1");
  ASSERT_EQ(data["stones"].size(), 2u);
  for (const json& stone : data["stones"]) {
    EXPECT_GT(stone["seen_share"].get<double>(), 0.2);
    EXPECT_LT(stone["seen_share"].get<double>(), 0.8) << "one view shows one side";
    EXPECT_GT(stone["mass"].get<double>(), 0.2);
    EXPECT_TRUE(fs::exists(folder_ + "/rocks/" + stone["name"].get<std::string>() + "/uncertainty.ply"));
  }
  const Catalogue rocks = read_catalogue(folder_ + "/rocks");
  ASSERT_EQ(rocks.stones.size(), 2U);
  EXPECT_TRUE(is_closed(rocks.stones.front().scan));
  for (const Stone& rock : rocks.stones) {
    ASSERT_TRUE(rock.surface.has_value()) << "its underside was completed";
    EXPECT_EQ(rock.surface->seen.size(), rock.scan.vertices.size());
    EXPECT_GT(std::count(rock.surface->seen.begin(), rock.surface->seen.end(), 0), 0);
    ASSERT_EQ(rock.surface->up_O_at_rest.size(), 1U);
    const Eigen::Vector3d up_file = rock.T_O_file.linear().transpose() * rock.surface->up_O_at_rest.front();
    EXPECT_NEAR(up_file.z(), 1.0, 1e-6) << "the file's frame is that of the table";
  }
  EXPECT_EQ(run("search --catalogue rocks --stones stone_1,stone_2 --method paper --budget 5").code, 0);
}

TEST_F(ModelCommand, ReplacesNothingWithoutForce) {
  ASSERT_EQ(run("render --out scene --seed 3 --stones limestone_1").code, 0);
  ASSERT_EQ(run("model scene/scene.yaml --catalogue rocks").code, 0);
  expect_refusal("model scene/scene.yaml --catalogue rocks", 2, {"stone_1", "already", "--force"});
  EXPECT_EQ(run("model scene/scene.yaml --catalogue rocks --force").code, 0);
  EXPECT_EQ(run("model scene/scene.yaml --catalogue rocks --prefix other").code, 0);
}

TEST_F(ModelCommand, RefusesWhatCannotBeModelled) {
  expect_refusal("model missing.yaml --catalogue rocks", 3, {"missing.yaml"});
  ASSERT_EQ(run("render --out scene --seed 3 --stones limestone_1").code, 0);
  expect_refusal("model scene/scene.yaml --catalogue rocks --prefix a/b", 2, {"a/b"});
  EXPECT_FALSE(fs::exists(folder_ + "/rocks/stone_1"));
}

TEST_F(ModelCommand, DryRunsAndSavingNeedWhatTheyNeed) {
  expect_refusal("run --unseen --dry-run", 2, {"--dry-run", "--unseen"});
  expect_refusal("run --save-catalogue rocks", 2, {"--unseen"});
}

TEST_F(ModelCommand, StonesThatAreThereAreNotReplacedByModelledOnes) {
  fs::create_directories(folder_ + "/rocks/stone_1");
  expect_refusal("run --unseen --save-catalogue rocks --out run", 2, {"stone_1", "rocks", "already"});
  EXPECT_FALSE(fs::exists(folder_ + "/run")) << "refused before anything is done";
  expect_refusal("scan --cell loopback-ur10 --catalogue rocks", 2, {"stone_1", "already"});
}

TEST_F(ModelCommand, ACellsOwnScanTakesNoOptionsOfMeshes) {
  for (const char* option : {"rock.ply", "--density 3000", "--generate 2", "--name rock"}) {
    const Outcome refused = run(concat("scan --cell loopback-ur10 --catalogue rocks ", option));
    EXPECT_EQ(refused.code, 2) << option;
    EXPECT_THAT(refused.err, HasSubstr("--cell")) << option;
  }
}

}  // namespace
}  // namespace stonestack
