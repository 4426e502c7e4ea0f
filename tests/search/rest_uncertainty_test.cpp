#include "search/rest_uncertainty.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "box_scenes.hpp"

namespace stonestack::search {
namespace {

/// A box whose underside rises along x by `slope`, or lies `lower` than that of the box that is known.
std::shared_ptr<const ContactShape> box_with_underside(const Eigen::Vector3d& size, double slope,
                                                       double lower) {
  ShapeOptions options;
  options.cell = 0.003;
  options.spacing = 0.006;
  Mesh mesh = make_box(size);
  for (Eigen::Vector3d& p : mesh.vertices)
    if (p.z() < 0.0) p.z() += slope * p.x() - lower;
  return make_contact_shape(mesh, mass_properties(mesh, 2600.0), "possible", options);
}

/// The middle box on the base, touching at four points.
struct MiddleOnBase {
  SearchProblem problem = base_stands();
  SearchOptions options = quick();
  std::vector<ShapeList> possible;
  PlacedStone middle{1_stone, at(0, 0, 0.085)};

  [[nodiscard]] double sigma() {
    problem.possible_shapes = &possible;
    const SearchContext context = make_context(problem, options, {});
    std::vector<Contact> contacts;
    for (const double x : {-0.04, 0.04})
      for (const double y : {-0.035, 0.035})
        contacts.push_back({0, 1, {x, y, 0.06}, Eigen::Vector3d::UnitZ(), 0.0, 0.0});
    return rest_uncertainty(context, problem.stack, middle, contacts);
  }
};

TEST(RestUncertainty, IsTheTurnThatPossibleUndersidesLeave) {
  MiddleOnBase in;
  EXPECT_EQ(in.sigma(), 0.0) << "all is known";
  const Eigen::Vector3d size(0.10, 0.09, 0.05);
  for (const double slope : {0.03, -0.03})
    in.possible.push_back({nullptr, box_with_underside(size, slope, 0.0), nullptr});
  EXPECT_NEAR(in.sigma(), 0.03, 0.003);
  in.possible = {{nullptr, box_with_underside(size, 0.0, 0.004), nullptr}};
  EXPECT_LT(in.sigma(), 0.001) << "it stands lower, and level";
}

TEST(RestUncertainty, CountsTheStoneBelowToo) {
  MiddleOnBase in;
  for (const double slope : {0.02, -0.02}) {  // upside down: its upper side is the uncertain one
    in.possible.push_back({box_with_underside({0.12, 0.11, 0.06}, slope, 0.0), nullptr, nullptr});
    in.problem.stack.stones[0].T_W_O = at(0, 0, 0.03) * Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX());
  }
  EXPECT_NEAR(in.sigma(), 0.02, 0.003);
}

TEST(RestUncertainty, IsNoneWhereTheStoneLayOnTheTable) {
  std::vector<Stone> stones(1);
  stones[0].name = "pebble";
  stones[0].scan = make_sphere(0.06, 4);
  for (Eigen::Vector3d& p : stones[0].scan.vertices) p.z() = std::clamp(p.z(), -0.025, 0.025);
  stones[0].mass = mass_properties(stones[0].scan, 2600.0);
  const std::vector<double> sigma(stones[0].scan.vertices.size(), 0.004);
  stones[0].surface = SurfaceKnowledge{sigma, std::vector<char>(sigma.size(), 0), {Eigen::Vector3d::UnitZ()}};
  const ShapeList shapes = make_contact_shapes(stones);
  const std::vector<ShapeList> possible = make_possible_shapes(stones);
  SearchProblem problem;
  problem.shapes = &shapes;
  problem.possible_shapes = &possible;
  problem.available = {{0_stone, at(0.4, 0, 0.025)}};
  const SearchOptions options = quick();
  const SearchContext context = make_context(problem, options, {});
  std::vector<Contact> contacts;
  for (const double x : {-0.03, 0.03})
    for (const double y : {-0.03, 0.03})
      contacts.push_back({kTable, 0, {x, y, 0.0}, Eigen::Vector3d::UnitZ(), 0.0, 0.0});
  EXPECT_LT(rest_uncertainty(context, {}, {0_stone, at(0, 0, 0.025)}, contacts), 0.005);
  const Pose upside_down = at(0, 0, 0.025) * Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX());
  EXPECT_GT(rest_uncertainty(context, {}, {0_stone, upside_down}, contacts), 0.02);
}

}  // namespace
}  // namespace stonestack::search
