#include "stonestack/stone/model_stone.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>

#include "stone/blame_file.hpp"
#include "stone/file_units.hpp"
#include "stone/mesh_deviation.hpp"
#include "stone/reduce_mesh.hpp"
#include "stone/repair_mesh.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/stone/catalogue.hpp"

namespace stonestack::stone {
namespace {

constexpr double kSampleSpacing = 0.002;  // m, of the points that deviations are measured at
constexpr double kBand = 0.012;           // m, as physics has it
constexpr double kMaxGridNodes = 3e7;

void check(const Mesh& scan, const std::string& source) {
  if (scan.faces.empty())
    throw FileError(source, concat("has ", scan.vertices.size(), " points and no faces"),
                    "give a mesh; make one from a cloud with the scanner's program");
  const auto count = static_cast<int>(scan.vertices.size());
  for (const Eigen::Vector3i& face : scan.faces)
    if (face.minCoeff() < 0 || face.maxCoeff() >= count)
      throw FileError(source, concat("has a face with corner ", face.maxCoeff(), " of ", count, " points"),
                      "export the mesh again");
  for (std::size_t v = 0; v < scan.vertices.size(); ++v)
    if (!scan.vertices[v].allFinite())
      throw FileError(source, concat("has a coordinate that is not finite (point ", v, ")"),
                      "export the mesh again");
}

/// Every option in its range, whoever set it; throws InvalidArgument.
void check(ModelOptions options) {
  const FieldList list = fields(options);
  for (const Field& one : list) set_field(list, one.name + "=" + field_text(one));
}

/// Points that no face uses may lie anywhere: they must not count for the size.
double longest_extent(const Mesh& scan) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3i& face : scan.faces)
    for (const int corner : face) box.extend(scan.vertices[static_cast<std::size_t>(corner)]);
  return box.sizes().maxCoeff();
}

Mesh reduced(const Mesh& scan, int faces, std::vector<std::string>& warnings) {
  Mesh mesh = reduce_mesh(scan, faces);
  if (mesh.faces.empty() || !is_closed(mesh) || volume(mesh) <= 0.0) {
    warnings.push_back(
        concat("could not be reduced to ", faces, " faces as it is; the reduced mesh is its hull"));
    return reduce_mesh(convex_hull(scan), faces);
  }
  if (const int crossing = count_self_intersections(mesh); crossing > 0)
    warnings.push_back(
        concat("the reduced mesh has ", crossing, " pairs of faces that cut through each other"));
  return mesh;
}

/// Returns the piece with its vertices and faces sorted: hulls come in an order that depends on addresses,
/// and the same scan shall give the same files.
Mesh ordered(const Mesh& piece) {
  const auto before = [](const auto& a, const auto& b) {
    return std::lexicographical_compare(a.data(), a.data() + 3, b.data(), b.data() + 3);
  };
  std::vector<int> order(piece.vertices.size()), place(piece.vertices.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](int i, int j) {
    return before(piece.vertices[static_cast<std::size_t>(i)], piece.vertices[static_cast<std::size_t>(j)]);
  });
  Mesh result;
  for (const int vertex : order) {
    place[static_cast<std::size_t>(vertex)] = static_cast<int>(result.vertices.size());
    result.vertices.push_back(piece.vertices[static_cast<std::size_t>(vertex)]);
  }
  for (Eigen::Vector3i face : piece.faces) {
    for (int& corner : face) corner = place[static_cast<std::size_t>(corner)];
    while (face[0] != face.minCoeff()) face = Eigen::Vector3i(face[1], face[2], face[0]);
    result.faces.push_back(face);
  }
  std::sort(result.faces.begin(), result.faces.end(), before);
  return result;
}

/// Convex pieces in an order of their own too, by their first vertex.
std::vector<Mesh> ordered_pieces(const Mesh& mesh, int max_pieces) {
  std::vector<Mesh> pieces = convex_pieces(mesh, {.max_pieces = max_pieces});
  for (Mesh& piece : pieces) piece = ordered(piece);
  std::sort(pieces.begin(), pieces.end(),
            [](const Mesh& a, const Mesh& b) { return a.vertices[0].x() < b.vertices[0].x(); });
  return pieces;
}

/// Grid cell for a stone: that of physics, wider for boulders that would not fit into memory.
double cell_for(const Mesh& scan, double cell, std::vector<std::string>& warnings) {
  const double volume_of_grid = (bounds(scan).sizes().array() + 2.0 * kBand).prod();
  const double min = std::cbrt(volume_of_grid / kMaxGridNodes);
  if (min <= cell) return cell;
  warnings.push_back(concat("is so large that its contact surface was measured on a grid of ",
                            std::round(min * 1e5) / 100.0, " mm"));
  return min;
}

MassProperties weigh(const Mesh& scan, const ModelOptions& options) {
  const double density = options.mass > 0.0 ? options.mass / volume(scan) : options.density;
  return mass_properties(scan, density);
}

ModelResult model_checked(const Mesh& scan, const std::string& name, const std::string& source,
                          const ModelOptions& options) {
  FileScale size = file_scale(longest_extent(scan), options.units, options.scale, source);
  ModelResult result;
  result.warnings = size.warnings;
  RepairedMesh whole = repair_mesh(scaled(scan, size.metres_per_unit), source);
  result.warnings.insert(result.warnings.end(), whole.warnings.begin(), whole.warnings.end());

  Stone& stone = result.stone;
  stone.name = name;
  stone.source = source;
  stone.friction = options.friction;
  stone.scale = size.metres_per_unit;
  const MassProperties in_file = weigh(whole.mesh, options);
  stone.T_O_file = make_pose(-in_file.p_O_M);
  stone.scan = transformed(whole.mesh, stone.T_O_file);
  stone.mass = weigh(stone.scan, options);
  stone.mass.p_O_M.setZero();  // the frame's origin, but for rounding
  stone.density = options.mass > 0.0 ? options.mass / volume(stone.scan) : options.density;
  stone.mesh = reduced(stone.scan, options.faces, result.warnings);
  stone.pieces = ordered_pieces(stone.mesh, options.convex_pieces);
  stone.mesh_deviation = deviation(stone.scan, stone.mesh, kSampleSpacing);
  const double cell = cell_for(stone.scan, options.contact_cell, result.warnings);
  stone.contact_deviation = grid_deviation(stone.scan, cell, std::max(kBand, 4.0 * cell), kSampleSpacing);
  return result;
}

}  // namespace

FieldList fields(ModelOptions& o) {
  return {field("units", o.units, "ours"),
          field("scale", o.scale, {1e-6, 1e6}, "", "ours"),
          field("density", o.density, {100.0, 25000.0}, "kg/m^3", "limestone"),
          field("mass", o.mass, {0.0, 10000.0}, "kg", "0: from density"),
          field("friction", o.friction, {0.001, 2.0}, "", "paper §4.1"),
          field("faces", o.faces, {20, 500}, "", "paper §4.1"),
          field("convex_pieces", o.convex_pieces, {1, 32}, "", "measured: more are 3 to 4 times slower"),
          field("contact_cell", o.contact_cell, {0.0002, 0.02}, "m", "physics: ShapeOptions::cell")};
}

ModelResult model_stone(const Mesh& scan, const std::string& name, const std::string& source,
                        const ModelOptions& options) {
  check(options);
  check(scan, source);
  return blame_file(source, [&] { return model_checked(scan, name, source, options); });
}

ModelResult model_limestone(std::uint64_t seed, int number, const ModelOptions& options) {
  ModelOptions in_metres = options;
  in_metres.units = "m";
  in_metres.scale = 1.0;
  const Mesh scan = make_limestone(Random::stream(seed, static_cast<std::uint64_t>(number)).bits());
  return model_stone(scan, concat("limestone_", number),
                     concat("generated: limestone, seed ", seed, ", number ", number), in_metres);
}

std::string stone_name_of(const std::string& file) {
  std::string name = std::filesystem::path(file).stem().string().substr(0, 64);
  for (char& c : name)
    if (!is_stone_name(std::string("x") + c)) c = '_';
  if (!name.empty() && name.front() == '.') name.front() = '_';
  return name;
}

}  // namespace stonestack::stone
