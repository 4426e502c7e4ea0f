#include "stone/repair_mesh.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "stone/geodesic.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/geometry/mesh.hpp"
#include "temporary_folder.hpp"

namespace stonestack::stone {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Every face with corners of its own, as STL has it.
Mesh torn(const Mesh& mesh) {
  Mesh soup;
  for (const Eigen::Vector3i& face : mesh.faces) {
    const int first = static_cast<int>(soup.vertices.size());
    for (const int corner : face) soup.vertices.push_back(mesh.vertices[static_cast<std::size_t>(corner)]);
    soup.faces.emplace_back(first, first + 1, first + 2);
  }
  return soup;
}

/// Several meshes in one, sharing no vertex.
Mesh joined(const std::vector<Mesh>& meshes) {
  Mesh all;
  for (const Mesh& mesh : meshes) {
    const auto first = static_cast<int>(all.vertices.size());
    all.vertices.insert(all.vertices.end(), mesh.vertices.begin(), mesh.vertices.end());
    for (const Eigen::Vector3i& face : mesh.faces) all.faces.emplace_back(face.array() + first);
  }
  return all;
}

Mesh moved(const Mesh& mesh, const Eigen::Vector3d& by) {
  return transformed(mesh, make_pose(by));
}

TEST(RepairMesh, LeavesASoundMeshAsItIs) {
  const Mesh box = make_box({0.1, 0.2, 0.3});
  const RepairedMesh repaired = repair_mesh(box, "box");
  EXPECT_THAT(repaired.warnings, IsEmpty());
  EXPECT_EQ(repaired.mesh.faces.size(), box.faces.size());
  EXPECT_DOUBLE_EQ(volume(repaired.mesh), volume(box));
}

TEST(RepairMesh, JoinsASoupOfMixedOrientation) {
  const Mesh sphere = scaled(make_geodesic(6), 0.1);
  Mesh soup = torn(sphere);
  Random random(4);
  for (Eigen::Vector3i& face : soup.faces)
    if (random.uniform() < 0.5) std::swap(face[0], face[1]);
  const RepairedMesh repaired = repair_mesh(soup, "sphere");
  EXPECT_TRUE(is_closed(repaired.mesh));
  EXPECT_NEAR(volume(repaired.mesh), volume(sphere), 1e-12);
}

TEST(RepairMesh, TurnsAMeshThatLooksInwards) {
  Mesh box = make_box({0.1, 0.1, 0.1});
  for (Eigen::Vector3i& face : box.faces) std::swap(face[0], face[1]);
  EXPECT_NEAR(volume(repair_mesh(box, "box").mesh), 0.001, 1e-12);
}

TEST(RepairMesh, KeepsTheLargestPartAndReportsIt) {
  const Mesh scan = joined({scaled(make_geodesic(5), 0.1), moved(make_box({0.01, 0.01, 0.01}), {0.3, 0, 0})});
  const RepairedMesh repaired = repair_mesh(scan, "scan");
  EXPECT_EQ(repaired.mesh.faces.size(), 500U);
  EXPECT_THAT(repaired.warnings, ElementsAre(HasSubstr("1 loose part with 12 of 512 faces")));
}

TEST(RepairMesh, ClosesTheSideThatTheStoneLayOn) {
  const Mesh sphere = scaled(make_geodesic(10), 0.1);
  Mesh open = sphere;
  std::erase_if(open.faces, [&](const Eigen::Vector3i& face) {
    return sphere.vertices[static_cast<std::size_t>(face[0])].z() < -0.08;
  });
  const RepairedMesh repaired = repair_mesh(open, "sphere");
  EXPECT_TRUE(is_closed(repaired.mesh));
  EXPECT_NEAR(volume(repaired.mesh) / volume(sphere), 0.972, 0.02) << "without a cap of 0.2 of the radius";
  EXPECT_THAT(repaired.warnings, ElementsAre(HasSubstr("closed 1 hole")));
}

TEST(RepairMesh, WrapsTwoBodiesThatShareAnEdgeOrCutThroughEachOther) {
  const Mesh a = scaled(make_geodesic(5), 0.1);
  Mesh crossed = joined({a, moved(a, {0.08, 0, 0})});
  // Joined by a bridge of faces, so that neither is a loose part.
  crossed.faces.emplace_back(0, 10, static_cast<int>(a.vertices.size()));
  const RepairedMesh repaired = repair_mesh(crossed, "crossed");
  EXPECT_TRUE(is_closed(repaired.mesh));
  EXPECT_GT(volume(repaired.mesh), 0.0);
  EXPECT_THAT(repaired.warnings, Not(IsEmpty()));
}

/// Two boxes that share an edge, as a scan may touch itself: split there, and still split after a file.
TEST(RepairMesh, SplitsAnEdgeOfFourFacesForGood) {
  const Mesh scan = joined({make_box({0.1, 0.1, 0.1}), moved(make_box({0.1, 0.1, 0.1}), {0.1, 0.1, 0.0}),
                            moved(make_box({0.1, 0.1, 0.1}), {0.0, 0.1, 0.1})});
  const std::string path = test::temporary_folder() + "repair_mesh_test.ply";
  write_mesh(path, repair_mesh(read_mesh((write_mesh(path, scan), path)), "boxes").mesh);
  EXPECT_TRUE(is_closed(read_mesh(path)));
}

TEST(RepairMesh, RefusesASheet) {
  Mesh sheet;
  sheet.vertices = {{0, 0, 0}, {0.1, 0, 0}, {0.1, 0.1, 0}, {0, 0.1, 0}};
  sheet.faces = {{0, 1, 2}, {0, 2, 3}};
  try {
    (void)repair_mesh(sheet, "sheet.obj");
    FAIL() << "a sheet is no stone";
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), testing::AllOf(HasSubstr("sheet.obj"), HasSubstr("no volume")));
  }
}

}  // namespace
}  // namespace stonestack::stone
