#include "modelling/rest_on_table.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "geometry/polygon.hpp"
#include "physics/settle.hpp"
#include "physics/shape.hpp"
#include "stonestack/physics/stack.hpp"

namespace stonestack::modelling {
namespace {

using namespace geometry;

/// An ellipsoid, inclined, of which views from above show the upper half; it touches the table at one point.
ObjectModel inclined_pebble() {
  ObjectModel model;
  model.mesh = make_sphere(1.0, 4);
  const Eigen::Matrix3d R_W_O = Eigen::AngleAxisd(0.5, Eigen::Vector3d::UnitY()).toRotationMatrix();
  double lowest = 1.0;
  for (Eigen::Vector3d& p : model.mesh.vertices) {
    p = R_W_O * p.cwiseProduct(Eigen::Vector3d(0.05, 0.035, 0.02));
    lowest = std::min(lowest, p.z());
  }
  for (Eigen::Vector3d& p : model.mesh.vertices) p.z() -= lowest;
  for (const Eigen::Vector3d& n : vertex_normals(model.mesh)) model.seen.push_back(n.z() > 0.0 ? 1 : 0);
  model.sigma.assign(model.seen.size(), 0.001);
  return model;
}

/// How far an object turns before it rests on a table [rad]; 10: it does not rest.
double turn_to_rest(const Mesh& mesh) {
  const physics::ShapeList shapes{physics::make_contact_shape(mesh, mass_properties(mesh, 2600.0), "pebble")};
  const auto settled = physics::settle(shapes, {}, 0_stone, Pose(Eigen::Translation3d(0, 0, 0.001)), {});
  return settled.rests ? difference(settled.T_W_O, Pose::Identity()).angle : 10.0;
}

TEST(RestOnTable, AModelRestsAsItsObjectDoes) {
  const ObjectModel before = inclined_pebble();
  ObjectModel model = before;
  rest_on_table(model);
  EXPECT_GT(turn_to_rest(before.mesh), 0.2) << "as it was completed it falls on its flat side";
  EXPECT_LT(turn_to_rest(model.mesh), 0.02);
  EXPECT_TRUE(is_closed(model.mesh));
  for (std::size_t k = 0; k < model.seen.size(); ++k) {
    if (model.seen[k] != 0) {
      EXPECT_EQ(model.mesh.vertices[k], before.mesh.vertices[k]) << "what was seen is as it was";
    }
    EXPECT_GE(model.mesh.vertices[k].z(), 0.0);
  }
}

TEST(RestOnTable, NoMoreOfTheUndersideIsSetOnTheTableThanCarriesTheObject) {
  ObjectModel model = inclined_pebble();
  rest_on_table(model);
  std::vector<Eigen::Vector2d> contact;
  for (const Eigen::Vector3d& p : model.mesh.vertices)
    if (p.z() == 0.0) contact.push_back(p.head<2>());
  const double within = margin(convex_hull(contact), mass_properties(model.mesh, 1.0).p_O_M.head<2>());
  EXPECT_GT(within, 0.006);
  EXPECT_LT(within, 0.012);
}

TEST(RestOn, AModelRestsOnWhatIsBelowIt) {
  constexpr double kTop = 0.05, kHalf = 0.03;  // m, of a box
  ObjectModel model = inclined_pebble();
  for (Eigen::Vector3d& p : model.mesh.vertices) p.z() += kTop;
  const Mesh before = model.mesh;
  rest_on(model, [&](const Eigen::Vector2d& p_W) {
    return p_W.cwiseAbs().maxCoeff() < kHalf ? std::optional(kTop) : std::nullopt;
  });
  std::vector<Eigen::Vector2d> contact;
  for (std::size_t k = 0; k < before.vertices.size(); ++k) {
    const Eigen::Vector3d& p = model.mesh.vertices[k];
    if (p == before.vertices[k]) continue;
    EXPECT_EQ(model.seen[k], 0);
    EXPECT_DOUBLE_EQ(p.z(), kTop);
    EXPECT_LT(p.head<2>().cwiseAbs().maxCoeff(), kHalf);
    contact.push_back(p.head<2>());
  }
  EXPECT_GT(margin(convex_hull(contact), mass_properties(model.mesh, 1.0).p_O_M.head<2>()), 0.006);
}

TEST(RestOnTable, SurfaceThatWasSeenFromBelowStays) {
  ObjectModel model = inclined_pebble();
  std::fill(model.seen.begin(), model.seen.end(), 1);
  const Mesh before = model.mesh;
  rest_on_table(model);
  EXPECT_EQ(model.mesh.vertices, before.vertices);
}

}  // namespace
}  // namespace stonestack::modelling
