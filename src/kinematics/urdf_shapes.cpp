#include "kinematics/urdf_shapes.hpp"

#include <urdf_model/link.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "geometry/capsule_cover.hpp"
#include "geometry/surface_tree.hpp"
#include "kinematics/mesh_uri.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/geometry/mesh.hpp"

namespace stonestack::kinematics {
namespace {

constexpr double kShapesLongest = 10.0;  // m
constexpr double kMinMesh = 0.005;       // m
constexpr std::size_t kMaxCapsulesPerMesh = 6;
constexpr std::size_t kMaxCapsules = 48;  // 64 movers of a collision check, less gripper and held stone

void check_size(double size, const std::string& link, const std::string& path) {
  if (!std::isfinite(size) || size < 0 || size > kShapesLongest)
    throw FileError(path, concat("link '", link, "' has a collision shape of size ", size, " m"),
                    concat("sizes are from 0 to ", kShapesLongest, " m"));
}

LinkCapsule on_link(const Capsule& capsule) {
  return {0, capsule.a, capsule.b, capsule.radius};
}

/// How far the capsules reach beyond the mesh, by points of their surfaces: what planning loses by them.
double reach_beyond(const std::vector<Capsule>& capsules, const Mesh& mesh) {
  const SurfaceTree surface(mesh);
  const Mesh ball = make_sphere(1.0, 2);
  double max = 0.0;
  for (const Capsule& capsule : capsules)
    for (const auto& n : ball.vertices)
      for (const double along : {0.0, 0.25, 0.5, 0.75, 1.0}) {
        const Eigen::Vector3d p = capsule.a + along * (capsule.b - capsule.a) + capsule.radius * n;
        const auto within = [&](const Capsule& other) { return distance(other, p) < -1e-9; };
        if (std::none_of(capsules.begin(), capsules.end(), within))
          max = std::max(max, std::abs(surface.nearest(p).distance));
      }
  return max;
}

std::vector<LinkCapsule> around_mesh(const urdf::Mesh& shape, const std::string& link,
                                     const std::string& path) {
  const std::string file = find_mesh(shape.filename, link, path);
  Mesh mesh = read_mesh(file);
  const Eigen::Vector3d scale(shape.scale.x, shape.scale.y, shape.scale.z);
  if (!scale.allFinite() || scale.cwiseAbs().minCoeff() <= 0.0)
    throw FileError(path, concat("link '", link, "' scales its mesh by (", scale.transpose(), ")"),
                    "give three numbers that are not zero");
  for (auto& v : mesh.vertices) v = scale.cwiseProduct(v);
  const double size = mesh.faces.empty() ? 0.0 : bounds(mesh).diagonal().norm();
  if (!(size >= kMinMesh && size <= kShapesLongest))
    throw FileError(file, concat("is a collision mesh ", size, " m across, of link '", link, "' in ", path),
                    concat("it must be ", kMinMesh, " to ", kShapesLongest,
                           " m across; scale=\"0.001 0.001 0.001\" where it is in millimetres"));
  const std::vector<Capsule> capsules = cover_by_capsules(mesh, kMaxCapsulesPerMesh);
  log_info(concat(link, ": ", std::filesystem::path(file).filename().string(), " is covered by ",
                  capsules.size(), " capsules, at most ", std::lround(1000 * reach_beyond(capsules, mesh)),
                  " mm beyond it"));
  std::vector<LinkCapsule> list;
  for (const Capsule& capsule : capsules) list.push_back(on_link(capsule));
  return list;
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

std::vector<LinkCapsule> covering(const urdf::Geometry& geometry, const std::string& link,
                                  const std::string& path) {
  if (const auto* mesh = dynamic_cast<const urdf::Mesh*>(&geometry)) return around_mesh(*mesh, link, path);
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
    throw FileError(path, concat("link '", link, "' has a collision shape of unknown kind"),
                    "give a cylinder, sphere, box or mesh");
  }
  return {capsule};
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
                    "give each moving link <collision> shapes, as in data/robots/ur10.urdf: "
                    "what has none may run into anything");
  if (capsules.size() > kMaxCapsules)
    throw FileError(path, concat("has ", capsules.size(), " collision shapes"),
                    concat("at most ", kMaxCapsules, " are checked; cover several by one cylinder"));
}

}  // namespace stonestack::kinematics
