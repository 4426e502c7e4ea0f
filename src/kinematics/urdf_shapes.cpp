#include "kinematics/urdf_shapes.hpp"

#include <urdf_model/link.h>

#include <algorithm>
#include <cmath>

#include "stonestack/core/error.hpp"

namespace stonestack {
namespace {

constexpr double kLongest = 10.0;          // m
constexpr std::size_t kMostCapsules = 48;  // 64 movers of a collision check, less hand and held stone

void check_size(double size, const std::string& link, const std::string& path) {
  if (!std::isfinite(size) || size < 0 || size > kLongest)
    throw FileError(path, concat("link '", link, "' has a collision shape of size ", size, " m"),
                    concat("sizes are from 0 to ", kLongest, " m"));
}

[[noreturn]] void refuse_mesh(const urdf::Geometry& geometry, const std::string& link,
                              const std::string& path) {
  const auto* mesh = dynamic_cast<const urdf::Mesh*>(&geometry);
  throw FileError(
      path,
      concat("link '", link, "' has a mesh as collision shape",
             mesh != nullptr ? ": '" + mesh->filename + "'" : std::string()),
      concat("meshes are not read: replace it by the <collision> cylinders and spheres that '", link,
             "' has in data/robots/ur10.urdf or that of your model; visual meshes may stay. "
             "For a calibrated UR, a YAML with `robot: ur10` and its DH table does without a URDF"));
}

/// Drops capsules that lie in another one of the same link: the spheres at a cylinder's ends.
void drop_contained(std::vector<LinkCapsule>& capsules) {
  const auto inside = [](const Eigen::Vector3d& p, double radius, const LinkCapsule& c) {
    const Eigen::Vector3d along = c.b - c.a;
    const double length2 = along.squaredNorm();
    const double t = length2 > 0 ? std::clamp((p - c.a).dot(along) / length2, 0.0, 1.0) : 0.0;
    return (p - c.a - t * along).norm() + radius <= c.radius + 1e-9;
  };
  for (std::size_t i = capsules.size(); i-- > 0;) {
    const auto small = capsules[i];
    for (std::size_t j = 0; j < capsules.size(); ++j) {
      if (i == j || small.link != capsules[j].link) continue;
      if (inside(small.a, small.radius, capsules[j]) && inside(small.b, small.radius, capsules[j])) {
        capsules.erase(capsules.begin() + static_cast<std::ptrdiff_t>(i));
        break;
      }
    }
  }
}

}  // namespace

LinkCapsule covering(const urdf::Geometry& geometry, const std::string& link, const std::string& path) {
  LinkCapsule capsule;
  capsule.a = capsule.b = Eigen::Vector3d::Zero();
  if (const auto* sphere = dynamic_cast<const urdf::Sphere*>(&geometry)) {
    check_size(capsule.radius = sphere->radius, link, path);
  } else if (const auto* cylinder = dynamic_cast<const urdf::Cylinder*>(&geometry)) {
    check_size(capsule.radius = cylinder->radius, link, path);
    check_size(cylinder->length, link, path);
    capsule.b.z() = 0.5 * cylinder->length;
    capsule.a.z() = -capsule.b.z();
  } else if (const auto* box = dynamic_cast<const urdf::Box*>(&geometry)) {
    Eigen::Vector3d half = 0.5 * Eigen::Vector3d(box->dim.x, box->dim.y, box->dim.z);
    for (const double side : half) check_size(2.0 * side, link, path);
    Eigen::Index longest = 0;
    (void)half.maxCoeff(&longest);
    capsule.b[longest] = half[longest];
    capsule.a = -capsule.b;
    half[longest] = 0.0;
    capsule.radius = half.norm();
  } else {
    refuse_mesh(geometry, link, path);
  }
  return capsule;
}

void tidy_shapes(std::vector<LinkCapsule>& capsules, const std::vector<std::string>& moving_links,
                 const std::string& path) {
  drop_contained(capsules);
  std::string bare;
  for (std::size_t i = 0; i < moving_links.size(); ++i)
    if (std::none_of(capsules.begin(), capsules.end(),
                     [&](const LinkCapsule& c) { return c.link == static_cast<int>(i) + 1; }))
      bare += concat(bare.empty() ? "" : ", ", moving_links[i]);
  if (!bare.empty())
    throw FileError(path, "has no collision shape on " + bare,
                    "give each moving link <collision> cylinders or spheres, as in data/robots/ur10.urdf: "
                    "what has none may run into anything");
  if (capsules.size() > kMostCapsules)
    throw FileError(path, concat("has ", capsules.size(), " collision shapes"),
                    concat("at most ", kMostCapsules, " are checked; cover several by one cylinder"));
}

}  // namespace stonestack
