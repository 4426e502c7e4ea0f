#include "stonestack/geometry/mesh.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <numeric>

#include "geometry/byte_order.hpp"
#include "geometry/mesh_import.hpp"
#include "geometry/mesh_parse.hpp"
#include "geometry/obj.hpp"
#include "geometry/ply.hpp"
#include "geometry/stl.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"

namespace stonestack::geometry {
namespace {

constexpr std::size_t kMeshMaxFile = 64U << 20U;
constexpr double kMeshMaxCoordinate = 1e5;  // the unit is not known yet: 100 km, or 100 m in millimetres

void require_plausible(const std::string& path, const Mesh& mesh) {
  if (mesh.faces.empty())
    throw FileError(path, concat("has ", mesh.vertices.size(), " vertices, but no faces"),
                    "give a mesh, not a point cloud");
  for (const Eigen::Vector3d& p : mesh.vertices) {
    if (p.allFinite() && p.cwiseAbs().maxCoeff() <= kMeshMaxCoordinate) continue;
    throw FileError(path, concat("has a vertex at (", p.transpose(), ")"),
                    concat("coordinates must be finite and within ", kMeshMaxCoordinate));
  }
}

/// Which vertex each vertex becomes when exactly equal ones are one: the first of them.
std::vector<int> first_equal_vertex(const std::vector<Eigen::Vector3d>& vertices) {
  std::vector<int> order(vertices.size());
  std::iota(order.begin(), order.end(), 0);
  const auto at = [&](int i) -> const Eigen::Vector3d& { return vertices[static_cast<std::size_t>(i)]; };
  std::sort(order.begin(), order.end(), [&](int i, int j) {
    for (int k = 0; k < 3; ++k)
      if (at(i)[k] != at(j)[k]) return at(i)[k] < at(j)[k];
    return i < j;
  });
  std::vector<int> first(vertices.size());
  for (std::size_t k = 0; k < order.size(); ++k) {
    const bool repeats = k > 0 && at(order[k]) == at(order[k - 1]);
    first[static_cast<std::size_t>(order[k])] =
        repeats ? first[static_cast<std::size_t>(order[k - 1])] : order[k];
  }
  return first;
}

/// Joins equal vertices, then drops faces with a repeated corner and vertices without a face. Order is kept.
Mesh welded(const Mesh& mesh) {
  const std::vector<int> first = first_equal_vertex(mesh.vertices);
  Mesh result;
  std::vector<bool> used(mesh.vertices.size(), false);
  for (const Eigen::Vector3i& face : mesh.faces) {
    Eigen::Vector3i joined;
    for (int k = 0; k < 3; ++k) joined[k] = first[static_cast<std::size_t>(face[k])];
    if (joined[0] == joined[1] || joined[1] == joined[2] || joined[2] == joined[0]) continue;
    for (const int corner : joined) used[static_cast<std::size_t>(corner)] = true;
    result.faces.push_back(joined);
  }
  std::vector<int> place(mesh.vertices.size(), -1);
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    if (!used[v]) continue;
    place[v] = static_cast<int>(result.vertices.size());
    result.vertices.push_back(mesh.vertices[v]);
  }
  for (Eigen::Vector3i& face : result.faces)
    for (int& corner : face) corner = place[static_cast<std::size_t>(corner)];
  return result;
}

std::string ply_text(const Mesh& mesh) {
  std::string file =
      concat("ply\nformat binary_little_endian 1.0\ncomment stonestack\nelement vertex ",
             mesh.vertices.size(), "\nproperty double x\nproperty double y\nproperty double z\nelement face ",
             mesh.faces.size(), "\nproperty list uchar int vertex_indices\nend_header\n");
  file.reserve(file.size() + 24 * mesh.vertices.size() + 13 * mesh.faces.size());
  for (const Eigen::Vector3d& p : mesh.vertices)
    for (const double x : p) append_little(file, x);
  for (const Eigen::Vector3i& face : mesh.faces) {
    append_little(file, std::uint8_t{3});
    for (const int corner : face) append_little(file, static_cast<std::int32_t>(corner));
  }
  return file;
}

std::string obj_text(const Mesh& mesh) {
  std::string file;
  std::array<char, 32> digits{};
  for (const Eigen::Vector3d& p : mesh.vertices) {
    file += 'v';
    for (const double x : p)
      file.append(" ").append(digits.data(),
                              std::to_chars(digits.data(), digits.data() + digits.size(), x).ptr);
    file += '\n';
  }
  for (const Eigen::Vector3i& face : mesh.faces) {
    file += 'f';
    for (const int corner : face) file.append(" ").append(std::to_string(corner + 1));
    file += '\n';
  }
  return file;
}

}  // namespace

std::string lower_case_extension(const std::string& path) {
  const std::size_t dot = path.find_last_of("./");
  if (dot == std::string::npos || path[dot] == '/') return "";
  std::string extension = path.substr(dot + 1);
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

Mesh parse_mesh(const std::string& path, const std::string& extension, std::string_view content) {
  Mesh mesh;
  if (extension == "ply") {
    PlyContent ply = parse_ply(path, content);
    mesh = {std::move(ply.points), std::move(ply.faces)};
  } else if (extension == "stl") {
    mesh = parse_stl(path, content);
  } else if (extension == "obj") {
    mesh = parse_obj(path, content);
  } else {
    throw FileError(path, concat("has the extension '", extension, "'"),
                    "convert it to PLY, OBJ or STL (glTF, Collada, 3DS, OFF and FBX are read, too)");
  }
  require_plausible(path, mesh);
  Mesh result = welded(mesh);
  if (result.faces.empty()) throw FileError(path, "has no face with three different corners", "give a mesh");
  return result;
}

Mesh read_mesh(const std::string& path) {
  const std::string content = read_file(path, kMeshMaxFile);
  if (content.empty()) throw FileError(path, "is empty", "make it again");
  const std::string extension = lower_case_extension(path);
  if (is_imported(extension)) return parse_mesh(path, "ply", import_as_ply(path, extension, content));
  return parse_mesh(path, extension, content);
}

void write_mesh(const std::string& path, const Mesh& mesh) {
  const std::string extension = lower_case_extension(path);
  require(extension == "ply" || extension == "obj", "meshes are written as .ply or .obj, got '", path, "'");
  write_file(path, extension == "ply" ? ply_text(mesh) : obj_text(mesh));
}

}  // namespace stonestack::geometry
