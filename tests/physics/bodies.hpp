#pragma once
#include "physics/shape.hpp"
#include "rooms.hpp"
#include "stonestack/core/random.hpp"

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

/// A slab of full side lengths `size` with roughness of up to 0.6 mm.
inline Mesh rough_slab(const Eigen::Vector3d& size, std::uint64_t seed) {
  Random random = Random::stream(seed, "rough slab");
  Mesh mesh = make_sphere(1.0, 3);
  for (auto& v : mesh.vertices) {
    v = v.cwiseProduct(0.5 * size) / v.cwiseAbs().maxCoeff();
    v -= 0.0006 * random.uniform() * v.normalized();
  }
  return mesh;
}

/// A flattened lump with dents, 320 faces, concave in places.
inline std::shared_ptr<const ContactShape> lump(std::uint64_t seed) {
  Random random = Random::stream(seed, "lump");
  Mesh mesh = make_sphere(0.05, 2);
  for (auto& v : mesh.vertices) v *= random.uniform(0.92, 1.0);
  for (auto& v : mesh.vertices) v = {1.3 * v.x(), v.y(), 0.7 * v.z()};
  return body(mesh, "lump");
}

}  // namespace stonestack::test
