#include "stone/stone_check.hpp"

#include <algorithm>

#include "geometry/convex_pieces.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::stone {
namespace {

constexpr const char* kScanAgain = "scan the stone again with `stonestack scan`";
constexpr std::size_t kMaxFaces = 500;                // paper §4.1
constexpr double kCheckMin = 0.001, kCheckMax = 2.0;  // m

void check_surface(const Mesh& mesh, const std::string& path) {
  if (!is_closed(mesh)) throw FileError(path, "is not a closed surface", kScanAgain);
  if (volume(mesh) <= 0.0)
    throw FileError(path, concat("encloses ", volume(mesh), " m^3, so its faces look inwards"), kScanAgain);
  const double size = bounds(mesh).sizes().maxCoeff();
  if (size < kCheckMin || size > kCheckMax)
    throw FileError(path, concat("is ", size, " m long, it must be 1 mm to 2 m"), "the unit is metres");
}

/// True if `p` lies inside the hull of the points, or on it.
bool inside_hull(const Mesh& mesh, const Eigen::Vector3d& p) {
  const Mesh hull = convex_hull(mesh);
  const std::vector<Eigen::Vector3d> normals = face_normals(hull);
  for (std::size_t f = 0; f < hull.faces.size(); ++f)
    if (normals[f].dot(p - hull.vertices[static_cast<std::size_t>(hull.faces[f][0])]) > 1e-6) return false;
  return true;
}

void check_mass(const Stone& stone, const std::string& path) {
  const Eigen::Vector3d& c = stone.mass.p_O_M;
  if (!inside_hull(stone.scan, c))
    throw FileError(
        path,
        concat("centre_of_mass {x: ", c.x(), ", y: ", c.y(), ", z: ", c.z(), "} lies outside the stone"),
        "it is in metres in the frame of scan.ply");
  if (const std::string wrong = check(stone.mass); !wrong.empty())
    throw FileError(path, concat("inertia cannot be: ", wrong), kScanAgain);
  double reach = 0.0;
  for (const Eigen::Vector3d& v : stone.scan.vertices) reach = std::max(reach, (v - c).squaredNorm());
  const double polar = stone.mass.I_M.trace() / 2.0;  // the sum of m r^2
  if (polar > stone.mass.mass * reach)
    throw FileError(path,
                    concat("inertia cannot be: half its trace is ", polar,
                           " kg m^2, the whole mass at the"
                           " furthest point gives ",
                           stone.mass.mass * reach),
                    kScanAgain);
}

/// The reduced mesh is the scan with fewer faces: it fills the same box, within a tenth.
void check_agreement(const Stone& stone, const std::string& path) {
  const Eigen::AlignedBox3d scan = bounds(stone.scan), mesh = bounds(stone.mesh);
  const double off = std::max((scan.min() - mesh.min()).cwiseAbs().maxCoeff(),
                              (scan.max() - mesh.max()).cwiseAbs().maxCoeff());
  if (off > 0.1 * scan.sizes().maxCoeff())
    throw FileError(path, concat("lies ", off, " m off scan.ply, they must be the same stone"), kScanAgain);
}

}  // namespace

void check_stone(const Stone& stone, const std::string& folder) {
  check_surface(stone.scan, folder + "/scan.ply");
  check_surface(stone.mesh, folder + "/mesh.ply");
  if (stone.mesh.faces.size() > kMaxFaces)
    throw FileError(folder + "/mesh.ply",
                    concat("has ", stone.mesh.faces.size(),
                           " faces, at most 500 are"
                           " taken"),
                    kScanAgain);
  check_agreement(stone, folder + "/mesh.ply");
  for (std::size_t n = 0; n < stone.pieces.size(); ++n)
    check_surface(stone.pieces[n], concat(folder, "/pieces/", n + 1, ".ply"));
  check_mass(stone, folder + "/stone.yaml");
}

}  // namespace stonestack::stone
