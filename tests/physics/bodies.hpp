#pragma once
#include "stonestack/physics/shape.hpp"

/// Test bodies of limestone.
namespace stonestack::test {

inline std::shared_ptr<const ContactShape> body(const Mesh& mesh, const std::string& name = "body") {
  return make_contact_shape(mesh, mass_properties(mesh, 2600.0), name);
}

inline std::shared_ptr<const ContactShape> box(double x, double y, double z) {
  return body(make_box({x, y, z}), "box");
}

inline Pose at(double x, double y, double z, double yaw = 0.0) {
  return make_pose({x, y, z}, Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ())));
}

}  // namespace stonestack::test
