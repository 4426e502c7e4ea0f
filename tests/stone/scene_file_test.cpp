#include "stonestack/stone/scene_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "temporary_folder.hpp"

namespace stonestack::stone {
namespace {

using ::testing::HasSubstr;

std::string problem_of(const std::string& text) {
  const std::string path = test::temporary_folder() + "scene_file_test.yaml";
  write_file(path, text);
  try {
    (void)read_scene_file(path);
  } catch (const FileError& error) {
    return error.what();
  }
  return "";
}

TEST(SceneFile, RoundTrip) {
  SceneFile scene;
  scene.camera = CameraIntrinsics{};
  scene.camera->distortion = CameraIntrinsics::Distortion::kInverseBrownConrady;
  scene.camera->k[4] = -0.1124;
  scene.T_W_C = make_pose({0.7, 0.1, 0.7}, {0, 1, 0, 0});
  scene.depth_file = "depth.png";
  scene.depth_unit = 0.000125;
  scene.stack = {{"a", make_pose({0.7, 0.28, 0.05})}};
  scene.stones = {{"b", make_pose({0.6, -0.2, 0.04}, {0.5, 0.5, 0.5, 0.5})}};
  const std::string path = test::temporary_folder() + "scene_file_round_trip.yaml";
  write_scene_file(path, scene);
  const SceneFile read = read_scene_file(path);
  EXPECT_EQ(read.camera->k[4], -0.1124);
  EXPECT_EQ(read.camera->distortion, scene.camera->distortion);
  EXPECT_LT(difference(*read.T_W_C, *scene.T_W_C).translation, 1e-9);
  EXPECT_EQ(read.depth_file, test::temporary_folder() + "depth.png");
  ASSERT_EQ(read.stack.size(), 1u);
  ASSERT_EQ(read.stones.size(), 1u);
  EXPECT_EQ(read.stones[0].stone, "b");
  EXPECT_LT(difference(read.stones[0].T_W_O, scene.stones[0].T_W_O).angle, 1e-6);
}

TEST(SceneFile, ReadsObstacles) {
  const std::string path = test::temporary_folder() + "scene_file_obstacles.yaml";
  write_file(path,
             "schema: stonestack.scene/1\nobstacles:\n  - name: wall\n    box: {x: 0.1, y: 1, z: 1}\n"
             "    T_W_O: {x: 0.4, y: 0, z: 0.5, qx: 0, qy: 0, qz: 0, qw: 1}\n");
  const SceneFile scene = read_scene_file(path);
  ASSERT_EQ(scene.obstacles.size(), 1u);
  EXPECT_EQ(scene.obstacles[0].name, "wall");
  EXPECT_THAT(problem_of("schema: stonestack.scene/1\nobstacles: [{name: wall}]\n"),
              HasSubstr("obstacles[0].box is missing"));
}

TEST(SceneFile, RefusesWithFileKeyAndRemedy) {
  const std::string head = "schema: stonestack.scene/1\n";
  EXPECT_THAT(problem_of("schema: other/1\n"), testing::AllOf(HasSubstr("is a other/1 file by its schema"),
                                                              HasSubstr("give a stonestack.scene/1 file")));
  EXPECT_THAT(problem_of(head + "stonez: []\n"), HasSubstr("stonez is not a key"));
  EXPECT_THAT(problem_of(head + "stones: 3\n"), HasSubstr("stones is not a list"));
  EXPECT_THAT(
      problem_of(head + "stones: [{stone: a, T_W_O: {x: 0, y: 0, z: nan, qx: 0, qy: 0, qz: 0, qw: 1}}]\n"),
      HasSubstr("stones[0].T_W_O.z must be a finite number"));
  EXPECT_THAT(problem_of(head + "T_W_C: {x: 0, y: 0, z: 0, qx: 0, qy: 0, qz: 0, qw: 0}\n"),
              HasSubstr("length 0"));
  EXPECT_THAT(
      problem_of(head +
                 "camera: {width: 640, height: 480, fx: 1, fy: 1, cx: 1, cy: 1, distortion: fisheye}\n"),
      HasSubstr("fisheye"));
  EXPECT_THAT(problem_of(head + "camera: {width: 640.5, height: 480, fx: 1, fy: 1, cx: 1, cy: 1}\n"),
              HasSubstr("camera.width is 640.5"));
}

TEST(SceneFile, ACloudIsNoSceneFile) {
  const std::string path = test::temporary_folder() + "no_scene.ply";
  write_file(path, "ply\n");
  try {
    (void)read_scene_file(path);
    FAIL();
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), HasSubstr("no_scene.ply: is not a scene file; give a .yaml file"));
  }
}

}  // namespace
}  // namespace stonestack::stone
