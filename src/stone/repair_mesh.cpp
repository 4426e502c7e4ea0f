#include "stone/repair_mesh.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "stone/mesh_deviation.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::stone {
namespace {

/// Alpha and offset of the wrap, of the stone's diagonal: bridges gaps of 3 mm and swells by 0.3 mm at 15 cm.
constexpr double kWrapAlpha = 1.0 / 50.0;
constexpr double kWrapOffset = 1.0 / 500.0;
/// Share of faces that may cut others before the surface is taken for a heap of triangles.
constexpr double kMaxCrossing = 0.02;
/// Least volume over that of the bounding box: less is a sheet, not a stone.
constexpr double kMinFullness = 0.01;

void append(std::vector<std::string>& list, const std::vector<std::string>& more) {
  list.insert(list.end(), more.begin(), more.end());
}

Mesh turned_inside_out(Mesh mesh) {
  for (Eigen::Vector3i& face : mesh.faces) std::swap(face[1], face[2]);
  return mesh;
}

/// Where a surface touches itself, its points were split into equal ones; moves those a millionth of the size
/// inwards, or whoever joins equal points would undo the split.
void part_equal_points(Mesh& mesh) {
  const std::vector<Eigen::Vector3d> normals = vertex_normals(mesh);
  const double step = 1e-6 * bounds(mesh).diagonal().norm();
  std::map<std::array<double, 3>, int> known;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    Eigen::Vector3d& p = mesh.vertices[v];
    const int before = known[{p.x(), p.y(), p.z()}]++;
    if (before > 0) p -= before * step * normals[v];
  }
}

RepairedMesh wrapped(const Mesh& mesh, const std::string& why) {
  const double diagonal = bounds(mesh).diagonal().norm();
  RepairedMesh result;
  result.mesh = wrap(mesh, diagonal * kWrapAlpha, diagonal * kWrapOffset);
  // A sheet wrapped is a skin around nothing: most of its volume is the offset.
  const double skin = diagonal * kWrapOffset * surface_area(result.mesh);
  if (volume(result.mesh) < 2.0 * skin) return {};
  const Deviation off = deviation(mesh, result.mesh, diagonal / 100.0);
  result.warnings.push_back(concat(why, ", so it was wrapped in a new surface, which lies ",
                                   std::round(off.median * 1e5) / 100.0, " mm (median) to ",
                                   std::round(off.worst * 1e5) / 100.0, " mm (worst) from the scan"));
  return result;
}

bool is_stone(const Mesh& mesh) {
  return is_closed(mesh) && std::abs(volume(mesh)) > kMinFullness * bounds(mesh).volume();
}

}  // namespace

RepairedMesh repair_mesh(const Mesh& mesh, const std::string& source) {
  RepairedMesh result = connect_faces(mesh);
  if (!result.mesh.faces.empty()) {
    RepairedMesh filled = close_holes(result.mesh);
    result.mesh = std::move(filled.mesh);
    append(result.warnings, filled.warnings);
  }
  const int crossing = is_stone(result.mesh) ? count_self_intersections(result.mesh) : 0;
  const bool heap = crossing > kMaxCrossing * static_cast<double>(result.mesh.faces.size());
  if (crossing > 0 && !heap)
    result.warnings.push_back(concat(crossing, " pairs of faces cut through each other; left as they are"));
  if (!is_stone(result.mesh) || heap)
    result = wrapped(mesh, heap ? concat("the surface cuts through itself (", crossing, " pairs of faces)")
                                : std::string("the faces could not be joined to one closed surface"));
  if (!is_stone(result.mesh))
    throw FileError(source, "encloses no volume",
                    "scan the stone from all sides, or close it in a mesh editor");
  if (volume(result.mesh) < 0.0) result.mesh = turned_inside_out(std::move(result.mesh));
  part_equal_points(result.mesh);
  return result;
}

}  // namespace stonestack::stone
