#include "stonestack/stone/scene_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "geometry/bop_folder.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "temporary_folder.hpp"

namespace stonestack::stone {
namespace {

TEST(SceneViewText, NumbersAreCountedAndFinite) {
  EXPECT_THAT(parse_numbers("1,-2.5,3e-3", 3, "a,b,c"), testing::ElementsAre(1.0, -2.5, 3e-3));
  for (const char* wrong : {"1,2", "1,2,3,4", "1,2,x", "1,2,", "1,2,nan", ""})
    EXPECT_THROW((void)parse_numbers(wrong, 3, "a,b,c"), InvalidArgument) << wrong;
  EXPECT_EQ(parse_point("0.7,-0.2"), Eigen::Vector2d(0.7, -0.2));
  EXPECT_THAT(split_list("a,,b"), testing::ElementsAre("a", "", "b"));
}

TEST(SceneViewText, APoseIsWrittenOutOrThatOfASceneFile) {
  EXPECT_EQ(parse_pose("1,2,3,1,0,0,0").translation(), Eigen::Vector3d(1, 2, 3));
  EXPECT_THROW((void)parse_pose("1,2,3,1,1,0,0"), InvalidArgument);  // no unit quaternion
  const std::string path =
      (std::filesystem::path(test::temporary_folder()) / "scene_view_test.yaml").string();
  SceneFile scene;
  write_scene_file(path, scene);
  EXPECT_THROW((void)parse_pose(path), FileError);  // no T_W_C
  scene.T_W_C = parse_pose("1,2,3,1,0,0,0");
  write_scene_file(path, scene);
  EXPECT_NEAR((parse_pose(path).translation() - Eigen::Vector3d(1, 2, 3)).norm(), 0.0, 1e-12);
}

TEST(SceneView, RefusesSettingsThatTheFileHasNoUseFor) {
  const std::string path =
      (std::filesystem::path(test::temporary_folder()) / "scene_view_empty.yaml").string();
  write_scene_file(path, SceneFile{});
  EXPECT_THROW((void)read_view(path, ""), FileError);  // neither depth nor cloud
  DepthInput with_units;
  with_units.units = "mm";
  EXPECT_THROW((void)read_view(path, "", false, with_units), InvalidArgument);
  DepthInput with_camera;
  with_camera.camera = "475,475,320,240";
  EXPECT_THROW((void)read_view(path, "", false, with_camera), InvalidArgument);
  EXPECT_THROW((void)read_view("depth.png", ""), FileError);  // no intrinsics
}

TEST(SceneView, ARecordingKeepsItsLensUnlessAnotherIsGiven) {
  using Distortion = CameraIntrinsics::Distortion;
  DepthImage image;
  image.camera.distortion = Distortion::kInverseBrownConrady;
  image.camera.k[0] = 0.1;
  image.z.assign(static_cast<std::size_t>(image.camera.width) * 480, 0.7F);
  const std::string folder = test::temporary_folder() + "scene_view_recording";
  BopFolder(folder).add(image, 0.0, std::nullopt);
  const auto camera = [&](const std::string& distortion) {
    DepthInput input;
    input.distortion = distortion;
    return read_view(folder, "", false, input).image.camera;
  };
  EXPECT_EQ(camera("").distortion, Distortion::kInverseBrownConrady);
  EXPECT_EQ(camera("").k[0], 0.1);
  EXPECT_EQ(camera("none").distortion, Distortion::kNone);
  EXPECT_EQ(camera("brown_conrady:0.2,0,0,0,0").distortion, Distortion::kBrownConrady);
  EXPECT_EQ(camera("brown_conrady:0.2,0,0,0,0").k[0], 0.2);
}

TEST(SceneView, ALeaningTableIsRefusedInTheWorldFrameAlone) {
  SceneView view;
  view.T_W_C = Pose::Identity();
  Plane leaning;
  leaning.normal = Eigen::Vector3d(1, 0, 1).normalized();
  EXPECT_NO_THROW(check_level(view, leaning, "cloud.ply"));
  view.world = true;
  EXPECT_THROW(check_level(view, leaning, "cloud.ply"), FileError);
  leaning.normal = Eigen::Vector3d::UnitZ();
  EXPECT_NO_THROW(check_level(view, leaning, "cloud.ply"));
}

}  // namespace
}  // namespace stonestack::stone
