#pragma once
#include <cmath>

#include "search/top_surface.hpp"

namespace stonestack::search {

/// A body for the gap field, without a contact shape.
inline StoneGeometry geometry_of(const Mesh& mesh, double mass = 1.0) {
  StoneGeometry stone;
  stone.vertices_M = mesh.vertices;
  stone.faces = mesh.faces;
  stone.mass = mass;
  for (const Eigen::Vector3d& v : mesh.vertices) stone.radius = std::max(stone.radius, v.norm());
  return stone;
}

inline BodyPose at(const StoneGeometry& stone, double x, double y, double z) {
  return {&stone, Eigen::Matrix3d::Identity(), {x, y, z}};
}

}  // namespace stonestack::search
