#include "stonestack/stone/model_stone.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

#include "stone/blame_file.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::stone {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

const Eigen::Vector3d kSize(0.10, 0.08, 0.06);

std::string problem_of(const Mesh& mesh, const ModelOptions& options = {}) {
  try {
    (void)model_stone(mesh, "rock", "rock.obj", options);
  } catch (const FileError& error) {
    return error.what();
  }
  return "";
}

TEST(ModelStone, WeighsABoxAndPutsItsOriginAtTheCentreOfMass) {
  const Mesh scan = transformed(make_box(kSize), make_pose({1.0, -2.0, 0.5}));
  const auto [stone, warnings] = model_stone(scan, "box", "box.obj");
  EXPECT_THAT(warnings, IsEmpty());
  const double mass = 2600.0 * kSize.prod();
  EXPECT_NEAR(stone.mass.mass, mass, 1e-9);
  EXPECT_NEAR(stone.mass.p_O_M.norm(), 0.0, 1e-12);
  for (int axis = 0; axis < 3; ++axis) {
    const double moment = mass / 12.0 * (kSize.squaredNorm() - kSize[axis] * kSize[axis]);
    EXPECT_NEAR(stone.mass.I_M(axis, axis), moment, 1e-9 * mass);
  }
  EXPECT_TRUE(bounds(stone.scan).sizes().isApprox(kSize, 1e-9));
  EXPECT_TRUE(stone.T_O_file.translation().isApprox(Eigen::Vector3d(-1.0, 2.0, -0.5), 1e-9));
  EXPECT_TRUE(stone.T_O_file.linear().isIdentity());
}

TEST(ModelStone, FileFrameScaledToMetresIsWhereTheFileStates) {
  Mesh scan = transformed(make_box(100.0 * kSize), make_pose({30.0, 0.0, 7.0}));  // cm
  ModelOptions options;
  options.units = "cm";
  const Stone stone = model_stone(scan, "box", "box.obj", options).stone;
  EXPECT_DOUBLE_EQ(stone.scale, 0.01);
  const Eigen::Vector3d p_O = stone.T_O_file * (stone.scale * scan.vertices[0]);
  EXPECT_NEAR((p_O - stone.scan.vertices[0]).norm(), 0.0, 1e-12);
}

TEST(ModelStone, AWeighedMassGivesTheDensity) {
  ModelOptions options;
  options.mass = 1.0;
  const Stone stone = model_stone(make_box(kSize), "box", "box.obj", options).stone;
  EXPECT_DOUBLE_EQ(stone.mass.mass, 1.0);
  EXPECT_NEAR(stone.density, 1.0 / kSize.prod(), 1e-6);
}

TEST(ModelStone, ReducesAndMeasuresWhatThatCosts) {
  const auto [stone, warnings] = model_stone(make_sphere(0.06, 4), "sphere", "sphere.obj");
  EXPECT_EQ(stone.scan.faces.size(), 5120U);
  EXPECT_LE(stone.mesh.faces.size(), 500U);
  EXPECT_TRUE(is_closed(stone.mesh));
  EXPECT_GT(stone.mesh_deviation.worst, 0.0);
  EXPECT_LT(stone.mesh_deviation.worst, 0.001);
  EXPECT_LT(stone.contact_deviation.median, 0.0002);
  EXPECT_LT(stone.contact_deviation.worst, 0.001);
  EXPECT_FALSE(stone.pieces.empty());
}

TEST(ModelStone, PointsThatNoFaceUsesDoNotCount) {
  Mesh scan = make_box(kSize);
  scan.vertices.emplace_back(500.0, 0.0, 0.0);
  EXPECT_TRUE(bounds(model_stone(scan, "box", "box.obj").stone.scan).sizes().isApprox(kSize, 1e-9));
}

TEST(ModelStone, RefusesOptionsOutOfRange) {
  ModelOptions options;
  options.friction = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW((void)model_stone(make_box(kSize), "box", "box.obj", options), InvalidArgument);
  options = {};
  options.density = -1.0;
  EXPECT_THROW((void)model_stone(make_box(kSize), "box", "box.obj", options), InvalidArgument);
}

TEST(ModelStone, RefusesWhatIsNoStone) {
  EXPECT_THAT(problem_of(Mesh{}), testing::AllOf(HasSubstr("rock.obj"), HasSubstr("no faces")));
  Mesh broken = make_box(kSize);
  broken.vertices[3].y() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(problem_of(broken), HasSubstr("not finite (point 3)"));
  broken = make_box(kSize);
  broken.faces[2][1] = 99;
  EXPECT_THAT(problem_of(broken), HasSubstr("corner 99 of 8"));
  EXPECT_THAT(problem_of(make_box({200.0, 150.0, 90.0})), HasSubstr("200 m long"));
  Mesh flat = make_box(kSize);
  for (Eigen::Vector3d& v : flat.vertices) v.z() = 0.0;
  EXPECT_THAT(problem_of(flat), HasSubstr("no volume"));
}

TEST(ModelStone, AnErrorOfTheMeshLibraryNamesTheFile) {
  const auto problem = [](const auto& throws) -> std::string {
    try {
      blame_file("rock.obj", [&]() -> int { throw throws; });
    } catch (const FileError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(problem(std::logic_error("CGAL error: precondition violation!\nExpr: p != q")),
              testing::AllOf(HasSubstr("rock.obj: "), HasSubstr("violation! Expr: p != q"),
                             HasSubstr("mesh editor")));
  EXPECT_THAT(problem(InvalidArgument("no face has an area")), HasSubstr("rock.obj: "));
  EXPECT_THAT(problem(std::bad_alloc()), HasSubstr("memory"));
  EXPECT_THROW(blame_file("rock.obj", []() -> int { throw Interrupted(); }), Interrupted);
}

}  // namespace
}  // namespace stonestack::stone
