#pragma once
#include <memory>
#include <string>

#include "physics/shape.hpp"
#include "stonestack/geometry/mesh.hpp"

namespace stonestack::stacking {

/// A box of limestone as physics sees it, about its centre.
inline std::shared_ptr<const ContactShape> box(const std::string& name, const Eigen::Vector3d& size) {
  const Mesh mesh = make_box(size);
  return make_contact_shape(mesh, mass_properties(mesh, 2600.0), name, {0.003, 0.015, 0.005});
}

}  // namespace stonestack::stacking
