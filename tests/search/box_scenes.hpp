#pragma once
#include "physics/shape.hpp"
#include "stonestack/search/find_next_pose.hpp"

/// Boxes to stack, and a search that is quick.
namespace stonestack::search {

inline std::shared_ptr<const ContactShape> box(const std::string& name, const Eigen::Vector3d& size) {
  ShapeOptions options;
  options.cell = 0.003;
  options.spacing = 0.006;
  const Mesh mesh = make_box(size);
  return make_contact_shape(mesh, mass_properties(mesh, 2600.0), name, options);
}

inline const ShapeList& boxes() {
  static const ShapeList list = {box("base", {0.12, 0.11, 0.06}), box("middle", {0.10, 0.09, 0.05}),
                                 box("top", {0.08, 0.07, 0.04})};
  return list;
}

inline Pose at(double x, double y, double z) {
  return make_pose(Eigen::Vector3d(x, y, z));
}

/// The base stands at the origin; the other two lie beside it.
inline SearchProblem base_stands() {
  SearchProblem problem;
  problem.shapes = &boxes();
  problem.stack.stones = {{0_stone, at(0, 0, 0.03)}};
  problem.available = {{1_stone, at(0.4, 0, 0.025)}, {2_stone, at(0.4, 0.3, 0.02)}};
  return problem;
}

inline SearchOptions quick() {
  SearchOptions options;
  options.max_tilt = M_PI;
  options.placement_sigma_translation = 0.001;
  options.placement_sigma_rotation = 0.0087266;
  options.com_sigma = 0.0;
  options.directions = 30;
  options.yaws = 3;
  options.settled = 6;
  options.alternatives = 2;
  options.verdict_seconds = 1.0;
  options.perturbations = 2;
  options.perturbed_seconds = 0.5;
  options.threads = 2;
  return options;
}

}  // namespace stonestack::search
