#include "stonestack/geometry/obstacle.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "stonestack/core/error.hpp"
#include "stonestack/geometry/mesh.hpp"
#include "temporary_folder.hpp"

namespace stonestack::geometry {
namespace {

using testing::HasSubstr;

const std::string kPose = ", T_W_O: {x: 1, y: 2, z: 3, qx: 0, qy: 0, qz: 0, qw: 1}}\n";

std::string problem_of(const std::string& text) {
  try {
    (void)parse_obstacles(text, "cell.yaml", "layout.obstacles");
  } catch (const FileError& error) {
    return error.what();
  }
  return "";
}

TEST(Obstacle, HasANameOfItsOwn) {
  const std::string wall = "- {name: wall, box: {x: 0.1, y: 2, z: 1.5}" + kPose;
  EXPECT_EQ(problem_of(wall), "");
  EXPECT_THAT(problem_of(wall + wall), HasSubstr("'wall' stands for another obstacle, too"));
  EXPECT_THAT(problem_of("- {name: table, box: {x: 0.1, y: 2, z: 1.5}" + kPose), HasSubstr("is 'table'"));
}

TEST(Obstacle, ReadsBoxesAndRoundShapes) {
  const auto list = parse_obstacles("- {name: wall, box: {x: 0.1, y: 2, z: 1.5}" + kPose +
                                        "- {name: post, cylinder: {radius: 0.1, length: 1}" + kPose +
                                        "- {name: lamp, sphere: {radius: 0.1}" + kPose,
                                    "cell.yaml", "obstacles");
  ASSERT_EQ(list.size(), 3u);
  EXPECT_EQ(list[0].name, "wall");
  EXPECT_TRUE(bounds(list[0].pieces.at(0)).sizes().isApprox(Eigen::Vector3d(0.1, 2, 1.5)));
  EXPECT_TRUE(list[0].T_W_O.translation().isApprox(Eigen::Vector3d(1, 2, 3)));
  for (std::size_t i : {1u, 2u}) {  // around the shape, hardly larger
    EXPECT_GE(bounds(list[i].pieces.at(0)).sizes().x(), 0.2 - 1e-12);
    EXPECT_LE(bounds(list[i].pieces.at(0)).sizes().x(), 0.204);
  }
  EXPECT_TRUE(parse_obstacles("", "cell.yaml", "obstacles").empty());
}

TEST(Obstacle, ReadsAMeshBesideTheFile) {
  const std::string folder = test::temporary_folder() + "obstacle_mesh";
  std::filesystem::create_directories(folder);
  write_mesh(folder + "/stand.ply", make_box({0.1, 0.2, 0.3}));
  const auto list =
      parse_obstacles("- {name: stand, mesh: stand.ply" + kPose, folder + "/cell.yaml", "obstacles");
  ASSERT_EQ(list.size(), 1u);
  ASSERT_FALSE(list[0].pieces.empty());
  EXPECT_NEAR(bounds(list[0].pieces[0]).sizes().z(), 0.3, 1e-6);
  write_mesh(folder + "/stand.ply", make_box({100, 200, 300}));
  EXPECT_THROW((void)parse_obstacles("- {name: stand, mesh: stand.ply" + kPose, folder + "/cell.yaml", ""),
               FileError)
      << "in millimetres";
  std::filesystem::remove_all(folder);
}

TEST(Obstacle, RefusesWithFileKeyAndValue) {
  EXPECT_THAT(problem_of("wall"), HasSubstr("cell.yaml: layout.obstacles is not a list"));
  EXPECT_THAT(problem_of("- {name: wall" + kPose), HasSubstr("layout.obstacles[0].box is missing"));
  EXPECT_THAT(problem_of("- {name: a, box: {x: 1, y: 1, z: 1}, sphere: {radius: 1}" + kPose),
              HasSubstr("box and sphere"));
  EXPECT_THAT(problem_of("- {name: a, box: {x: 1, y: -1, z: 1}" + kPose), HasSubstr("box.y is -1"));
  EXPECT_THAT(problem_of("- {name: a, box: {x: 1, y: 1}" + kPose), HasSubstr("box.z is missing"));
  EXPECT_THAT(problem_of("- {name: a, sphere: {radius: 0.1}}"), HasSubstr("T_W_O is missing"));
  EXPECT_THAT(problem_of("- {sphere: {radius: 0.1}" + kPose), HasSubstr("[0].name is missing"));
  EXPECT_THAT(problem_of("- {name: a, cone: {}, sphere: {radius: 0.1}" + kPose), HasSubstr("cone"));
  EXPECT_THAT(problem_of("- {name: a, mesh: nowhere.stl" + kPose), HasSubstr("nowhere.stl"));
}

}  // namespace
}  // namespace stonestack::geometry
