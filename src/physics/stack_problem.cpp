#include "stonestack/physics/stack.hpp"

#include <algorithm>
#include <cmath>

#include "physics/shape.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::physics {
namespace {

/// True if some direction separates the point from every vertex: Frank and Wolfe's walk to the nearest point
/// of the hull.
bool outside_hull(const std::vector<Eigen::Vector3d>& vertices, const Eigen::Vector3d& p) {
  Eigen::Vector3d nearest = vertices.front();
  for (int k = 0; k < 300; ++k) {
    const Eigen::Vector3d direction = p - nearest;
    const auto furthest =
        std::max_element(vertices.begin(), vertices.end(),
                         [&](const auto& v, const auto& w) { return v.dot(direction) < w.dot(direction); });
    if ((p - *furthest).dot(direction) > 0.0) return true;
    const Eigen::Vector3d step = *furthest - nearest;
    if (step.squaredNorm() < 1e-18) return false;
    nearest += std::clamp(step.dot(direction) / step.squaredNorm(), 0.0, 1.0) * step;
  }
  return false;
}

/// Deepest overlap of two stones of the stack, from samples of one in the other.
double overlap(const ContactShape& a, const Pose& T_W_A, const ContactShape& b, const Pose& T_W_B) {
  if ((T_W_A * a.mass.p_O_M - T_W_B * b.mass.p_O_M).norm() > a.radius + b.radius) return 0.0;
  const Pose T_A_B = T_W_A.inverse() * T_W_B;
  double deepest = 0.0;
  for (const SurfaceSample& sample : b.samples)
    deepest = std::max(deepest, -a.distance.distance(T_A_B * sample.point));
  return deepest;
}

}  // namespace

std::string impossible(const ContactShape& shape) {
  const std::string wrong = check(shape.mass);
  if (!wrong.empty()) return wrong;
  if (shape.scan.vertices.empty()) return "has no scan mesh";
  if (outside_hull(shape.scan.vertices, shape.mass.p_O_M))
    return concat("centre of mass (", shape.mass.p_O_M.transpose(), ") lies outside its hull");
  return {};
}

std::string overlap_of(const ShapeList& shapes, const Stack& stack, double allowed) {
  for (const PlacedStone& placed : stack.stones) {
    const ContactShape& shape = *at(shapes, placed.stone);
    double lowest = 0.0;
    for (const Eigen::Vector3d& v : shape.scan.vertices) lowest = std::min(lowest, (placed.T_W_O * v).z());
    if (lowest < -allowed)
      return concat("the given stack cannot be: ", shape.name, " reaches ", 0.1 * std::round(-1e4 * lowest),
                    " mm below the table");
  }
  for (std::size_t p = 0; p < stack.stones.size(); ++p)
    for (std::size_t q = p + 1; q < stack.stones.size(); ++q) {
      const auto &a = stack.stones[p], &b = stack.stones[q];
      const ContactShape& shape_a = *at(shapes, a.stone);
      const ContactShape& shape_b = *at(shapes, b.stone);
      const double depth =
          std::max(overlap(shape_a, a.T_W_O, shape_b, b.T_W_O), overlap(shape_b, b.T_W_O, shape_a, a.T_W_O));
      const double known = std::min(shape_a.distance.band(), shape_b.distance.band());
      if (depth > allowed)
        return concat("the given stack cannot be: ", shape_a.name, " and ", shape_b.name, " overlap by ",
                      0.1 * std::round(1e4 * depth), depth < known - 1e-6 ? " mm" : " mm or more");
    }
  return {};
}

}  // namespace stonestack::physics
