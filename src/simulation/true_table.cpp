#include "simulation/true_table.hpp"

#include <algorithm>
#include <cmath>

#include "core/constants.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::simulation {
namespace {

constexpr double kPlaneHalf = 3.0;                                   // m, of the plane that is seen
constexpr int kCells = 50;                                           // along each side of an uneven table
constexpr double kCell = 0.06;                                       // m
constexpr double kThickness = 0.02;                                  // m
constexpr double kShortestTableWave = 0.3, kLongestTableWave = 0.8;  // m, waves of a table top; design choice
constexpr int kTableWaves = 8;
constexpr double kTableDensity = 700.0;                 // kg/m^3; the table never moves
constexpr ShapeOptions kTableShape{0.02, 0.03, kCell};  // coarse: only contact features matter

std::size_t index(int column, int row) {
  return static_cast<std::size_t>(row) * (kCells + 1) + static_cast<std::size_t>(column);
}

/// Heights about the plane, scaled so that the largest is `size`.
std::vector<double> waves(double size, Random random) {
  std::vector<double> z((kCells + 1) * (kCells + 1), 0.0);
  for (int k = 0; k < kTableWaves; ++k) {
    const double number = kTwoPi / random.uniform(kShortestTableWave, kLongestTableWave);
    const double direction = random.uniform(0.0, kTwoPi), phase = random.uniform(0.0, kTwoPi);
    for (int row = 0; row <= kCells; ++row)
      for (int column = 0; column <= kCells; ++column)
        z[index(column, row)] +=
            std::cos(number * kCell * (std::cos(direction) * column + std::sin(direction) * row) + phase);
  }
  double largest = 0.0;
  for (const double value : z) largest = std::max(largest, std::abs(value));
  for (double& value : z) value *= size / largest;
  return z;
}

void add_quad(Mesh& mesh, int a, int b, int c, int d) {
  mesh.faces.emplace_back(a, b, c);
  mesh.faces.emplace_back(a, c, d);
}

/// The surface with a bottom and sides.
Mesh slab(const Mesh& top) {
  Mesh mesh = top;
  const int nodes = static_cast<int>(top.vertices.size());
  for (const auto& p : top.vertices) mesh.vertices.push_back(p - Eigen::Vector3d(0, 0, kThickness));
  for (const auto& face : top.faces)
    mesh.faces.emplace_back(face[0] + nodes, face[2] + nodes, face[1] + nodes);
  const auto at = [](int column, int row) { return static_cast<int>(index(column, row)); };
  const auto side = [&](int a, int b) { add_quad(mesh, a, a + nodes, b + nodes, b); };
  for (int k = 0; k < kCells; ++k) {
    side(at(k, 0), at(k + 1, 0));
    side(at(kCells, k), at(kCells, k + 1));
    side(at(k + 1, kCells), at(k, kCells));
    side(at(0, k + 1), at(0, k));
  }
  return mesh;
}

}  // namespace

TrueTable::TrueTable(const SimulationOptions& options, const Eigen::Vector2d& centre) {
  if (options.table_height <= 0.0 && options.table_tilt <= 0.0 && options.table_unevenness <= 0.0) return;
  const auto seed = static_cast<std::uint64_t>(options.seed);
  Random plane = Random::stream(seed, "true table");
  const double height = plane.uniform() < 0.5 ? -options.table_height : options.table_height;
  const double downhill = plane.uniform(0.0, kTwoPi), slope = std::tan(options.table_tilt);
  corner_ = centre.array() - 0.5 * kCells * kCell;
  z_ = waves(options.table_unevenness, Random::stream(seed, "true table's waves"));
  for (int row = 0; row <= kCells; ++row)
    for (int column = 0; column <= kCells; ++column) {
      const double x = (column - 0.5 * kCells) * kCell, y = (row - 0.5 * kCells) * kCell;
      z_[index(column, row)] += height - slope * (std::cos(downhill) * x + std::sin(downhill) * y);
    }
  const Mesh mesh = slab(surface());
  shape_ = make_contact_shape(mesh, mass_properties(mesh, kTableDensity), "table", kTableShape);
}

Eigen::Vector3d TrueTable::node(int column, int row) const {
  return {corner_.x() + column * kCell, corner_.y() + row * kCell, z_[index(column, row)]};
}

// On the triangle of `surface` over the place.
double TrueTable::height(double x, double y) const {
  if (z_.empty()) return 0.0;
  const double u = std::clamp((x - corner_.x()) / kCell, 0.0, static_cast<double>(kCells));
  const double v = std::clamp((y - corner_.y()) / kCell, 0.0, static_cast<double>(kCells));
  const int column = std::min(static_cast<int>(u), kCells - 1),
            row = std::min(static_cast<int>(v), kCells - 1);
  const double s = u - column, t = v - row;
  const double a = z_[index(column, row)], c = z_[index(column + 1, row + 1)];
  if (s >= t) {
    const double b = z_[index(column + 1, row)];
    return a + s * (b - a) + t * (c - b);
  }
  const double d = z_[index(column, row + 1)];
  return a + t * (d - a) + s * (c - d);
}

// The slope over a few centimetres, as a stone spans them.
TableSurface TrueTable::contact_surface() const {
  const auto tangent = [table = *this](const Eigen::Vector2d& p) {
    const double h = 0.5 * kCell;
    const double dx = (table.height(p.x() + h, p.y()) - table.height(p.x() - h, p.y())) / kCell;
    const double dy = (table.height(p.x(), p.y() + h) - table.height(p.x(), p.y() - h)) / kCell;
    const Eigen::Vector3d n_W = Eigen::Vector3d(-dx, -dy, 1.0).normalized();
    return Plane{n_W, n_W.dot(Eigen::Vector3d(p.x(), p.y(), table.height(p.x(), p.y())))};
  };
  return {shape_, tangent};
}

Mesh TrueTable::surface() const {
  Mesh mesh;
  if (z_.empty()) {
    mesh.vertices = {{-kPlaneHalf, -kPlaneHalf, 0},
                     {kPlaneHalf, -kPlaneHalf, 0},
                     {kPlaneHalf, kPlaneHalf, 0},
                     {-kPlaneHalf, kPlaneHalf, 0}};
    mesh.faces = {{0, 1, 2}, {0, 2, 3}};
    return mesh;
  }
  for (int row = 0; row <= kCells; ++row)
    for (int column = 0; column <= kCells; ++column) mesh.vertices.push_back(node(column, row));
  for (int row = 0; row < kCells; ++row)
    for (int column = 0; column < kCells; ++column)
      add_quad(mesh, static_cast<int>(index(column, row)), static_cast<int>(index(column + 1, row)),
               static_cast<int>(index(column + 1, row + 1)), static_cast<int>(index(column, row + 1)));
  return mesh;
}

}  // namespace stonestack::simulation
