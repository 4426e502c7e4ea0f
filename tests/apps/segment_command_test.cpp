// What `stonestack segment` prints and writes, and what it refuses.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "commands.hpp"
#include "stonestack/geometry/cloud.hpp"
#include "stonestack/geometry/depth_image.hpp"

namespace stonestack {
namespace {

class SegmentCommand : public Commands {
 protected:
  void SetUp() override {
    Commands::SetUp();
    ASSERT_EQ(run("render --out scene --seed 3 --stones limestone_1,limestone_4").code, 0);
  }
};

TEST_F(SegmentCommand, GivesATableJsonCloudsLabelsAndAPicture) {
  const Outcome text = run("segment scene/scene.yaml --out objects --picture picture.png");
  EXPECT_EQ(text.code, 0) << text.err;
  EXPECT_THAT(text.out, HasSubstr("confidence"));
  for (const char* file :
       {"objects/object_1.ply", "objects/object_2.ply", "objects/labels_1.png", "picture.png"})
    EXPECT_TRUE(std::filesystem::exists(folder_ + "/" + file)) << file;
  const auto found = run("segment scene/scene.yaml --json").data();
  EXPECT_EQ(found["schema"], "stonestack.segment/1");
  ASSERT_EQ(found["objects"].size(), 2u);
  const auto& first = found["objects"][0];
  EXPECT_EQ(first["object"], 1);
  EXPECT_GT(first["confidence"].get<double>(), 0.8);
  EXPECT_EQ(first["cut_off"], false);
  EXPECT_LT(std::abs(first["p_W_middle"]["z"].get<double>()), 0.15) << "the camera's pose is known";
  EXPECT_GT(read_cloud(folder_ + "/objects/object_1.ply").points.size(), 500u);
  const DepthImage labels = read_depth_png(folder_ + "/objects/labels_1.png", {}, 1.0);
  EXPECT_EQ(std::count(labels.z.begin(), labels.z.end(), 1.0F), first["pixels"].get<int>());
}

TEST_F(SegmentCommand, TakesACloudAndSeveralViews) {
  EXPECT_EQ(run("segment scene/cloud.ply --json").data()["objects"].size(), 2u);
  const auto twice = run("segment scene/scene.yaml scene/scene.yaml --json").data();
  ASSERT_EQ(twice["objects"].size(), 2u);
  EXPECT_EQ(twice["objects"][0]["views"], 2);
}

TEST_F(SegmentCommand, RefusesWhatCannotBeSegmented) {
  expect_refusal("segment missing.ply", 3, {"missing.ply"});
  expect_refusal("segment scene/cloud.ply scene/cloud.ply", 3, {"cloud.ply", "camera pose"});
  expect_refusal("segment scene/scene.yaml --min-width 0", 2, {"--min-width"});
  Cloud wall = read_cloud(folder_ + "/scene/cloud.ply");
  for (auto& p : wall.points) p.setConstant(std::numeric_limits<float>::quiet_NaN());
  write_cloud(folder_ + "/nan.ply", wall);
  expect_refusal("segment nan.ply", 3, {"nan.ply", "no point with coordinates"});
  const Outcome bare = run("segment scene/scene.yaml --min-width 0.5 --json");
  EXPECT_EQ(bare.code, 4);
  EXPECT_EQ(bare.data()["objects"].size(), 0u);
  EXPECT_THAT(bare.err, HasSubstr("nothing stands on the table"));
}

}  // namespace
}  // namespace stonestack
