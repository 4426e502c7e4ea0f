#include "geometry/signed_distance.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "geometry/surface_tree.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::geometry {
namespace {

constexpr int kBrickCells = 4;  // a side; a power of two, so that cell -> brick is a shift
constexpr int kBrickShift = 2;
constexpr int kBrickNodes = kBrickCells + 1;  // neighbours repeat the shared nodes, so a query stays in one
constexpr int kRow = kBrickNodes;
constexpr int kLayer = kBrickNodes * kBrickNodes;
constexpr int kBrickValues = kBrickNodes * kLayer;
constexpr std::int32_t kFarOutside = -1;
constexpr std::int32_t kFarInside = -2;
constexpr double kMaxNodes = 64e6;

constexpr int node_index(int x, int y, int z) {
  return (z * kBrickNodes + y) * kBrickNodes + x;
}

}  // namespace

/// Cells in bricks of 4 x 4 x 4. Only bricks within the band hold values (float: 1 nm in 12 mm); the others
/// say on which side they are. A query touches one brick, 500 bytes.
struct SignedDistance::Grid {
  Eigen::AlignedBox3d box;
  double cell = 0.0;
  double cells_per_metre = 0.0;
  double band = 0.0;
  Eigen::Array3i cells = Eigen::Array3i::Zero();
  Eigen::Array3i bricks = Eigen::Array3i::Zero();
  std::vector<std::int32_t> brick;  ///< offset in `values`, kFarOutside or kFarInside
  std::vector<float> values;

  [[nodiscard]] std::size_t brick_index(int x, int y, int z) const {
    return static_cast<std::size_t>((z * bricks.y() + y) * bricks.x() + x);
  }
  void build(const SurfaceTree& tree);
  int fill(const SurfaceTree& tree, const Eigen::Array3i& at, int likely_face);
  [[nodiscard]] std::int32_t side_of_left_neighbour(const Eigen::Array3i& at) const;
  [[nodiscard]] const float* neighbour_value(const Eigen::Array3i& at, const Eigen::Array3i& node) const;
};

void SignedDistance::Grid::build(const SurfaceTree& tree) {
  brick.assign(static_cast<std::size_t>(bricks.prod()), kFarOutside);
  const double half_side = 0.5 * kBrickCells * cell;
  const double reach = band + std::sqrt(3.0) * half_side;
  int likely_face = -1;
  for (int z = 0; z < bricks.z(); ++z) {
    throw_if_interrupted();
    for (int y = 0; y < bricks.y(); ++y) {
      for (int x = 0; x < bricks.x(); ++x) {
        const Eigen::Array3i at(x, y, z);
        const Eigen::Vector3d middle =
            box.min() + (at.cast<double>() * kBrickCells * cell + half_side).matrix();
        const SurfacePoint nearest = tree.nearest(middle, reach, likely_face);
        if (nearest.face >= 0)
          likely_face = fill(tree, at, nearest.face);
        else
          brick[brick_index(x, y, z)] = side_of_left_neighbour(at);
      }
    }
  }
}

/// A brick without surface near it is on the side where it touches the brick before it.
std::int32_t SignedDistance::Grid::side_of_left_neighbour(const Eigen::Array3i& at) const {
  if (at.x() == 0) return kFarOutside;
  const std::int32_t left = brick[brick_index(at.x() - 1, at.y(), at.z())];
  if (left < 0) return left;
  return values[static_cast<std::size_t>(left + node_index(kBrickCells, 0, 0))] < 0.0F ? kFarInside
                                                                                       : kFarOutside;
}

/// The value of a node on a low face of the brick, where an earlier brick holds it already; else null.
const float* SignedDistance::Grid::neighbour_value(const Eigen::Array3i& at,
                                                   const Eigen::Array3i& node) const {
  for (int axis = 0; axis < 3; ++axis) {
    if (node[axis] != 0 || at[axis] == 0) continue;
    Eigen::Array3i other = at;
    --other[axis];
    const std::int32_t offset = brick[brick_index(other.x(), other.y(), other.z())];
    if (offset < 0) continue;
    Eigen::Array3i twin = node;
    twin[axis] = kBrickCells;
    return &values[static_cast<std::size_t>(offset + node_index(twin.x(), twin.y(), twin.z()))];
  }
  return nullptr;
}

int SignedDistance::Grid::fill(const SurfaceTree& tree, const Eigen::Array3i& at, int likely_face) {
  const std::size_t offset = values.size();
  require(offset + kBrickValues < static_cast<std::size_t>(INT32_MAX), "the distance grid is too fine");
  values.resize(offset + kBrickValues);
  brick[brick_index(at.x(), at.y(), at.z())] = static_cast<std::int32_t>(offset);
  std::vector<Eigen::Vector3d> points;
  std::vector<std::size_t> nodes;
  for (int octant = 0; octant < 8; ++octant) {
    const Eigen::Array3i upper(octant & 1, (octant >> 1) & 1, octant >> 2);
    const Eigen::Array3i low = 3 * upper;  // nodes 0 1 2 and 3 4
    const Eigen::Array3i high = 3 + 2 * upper;
    points.clear();
    nodes.clear();
    for (int z = low.z(); z < high.z(); ++z) {
      for (int y = low.y(); y < high.y(); ++y) {
        for (int x = low.x(); x < high.x(); ++x) {
          const Eigen::Array3i node(x, y, z);
          const std::size_t index = offset + static_cast<std::size_t>(node_index(x, y, z));
          if (const float* known = neighbour_value(at, node)) {
            values[index] = *known;
            continue;
          }
          nodes.push_back(index);
          points.emplace_back(box.min() + ((at * kBrickCells + node).cast<double>() * cell).matrix());
        }
      }
    }
    const std::vector<SurfacePoint> nearest = tree.nearest(points, likely_face);
    for (std::size_t i = 0; i < nodes.size(); ++i)
      values[nodes[i]] = static_cast<float>(std::clamp(nearest[i].distance, -band, band));
    if (!nearest.empty()) likely_face = nearest.back().face;
  }
  return likely_face;
}

SignedDistance::SignedDistance(const Mesh& mesh, double cell, double band) {
  require(cell > 0.0 && std::isfinite(cell), "a distance grid needs a positive cell, got ", cell, " m");
  require(band >= cell && std::isfinite(band), "the band must be at least one cell of ", cell, " m, got ",
          band, " m");
  require(is_closed(mesh), "signed distance needs a closed mesh; this one of ", mesh.faces.size(),
          " faces is open");
  const Eigen::AlignedBox3d around = bounds(mesh);
  const Eigen::Array3d bricks =
      ((around.sizes().array() + 2.0 * (band + cell)) / (kBrickCells * cell)).ceil();
  const double nodes = bricks.prod() * kBrickCells * kBrickCells * kBrickCells;
  require(nodes <= kMaxNodes, "a cell of ", cell, " m and a mesh of ", around.sizes().transpose(), " m make ",
          nodes, " nodes, more than ", kMaxNodes);
  const auto grid = std::make_shared<Grid>();
  grid->cell = cell;
  grid->cells_per_metre = 1.0 / cell;
  grid->band = static_cast<double>(static_cast<float>(band));  // what the nodes hold
  grid->bricks = bricks.cast<int>();
  grid->cells = grid->bricks * kBrickCells;
  const Eigen::Vector3d half = (0.5 * cell * grid->cells.cast<double>()).matrix();
  grid->box = {around.center() - half, around.center() + half};
  grid->build(SurfaceTree(mesh));
  grid_ = grid;
}

double SignedDistance::band() const {
  return grid_->band;
}
const Eigen::AlignedBox3d& SignedDistance::box() const {
  return grid_->box;
}

double SignedDistance::distance(const Eigen::Vector3d& p) const {
  return distance(p, nullptr);
}

double SignedDistance::distance(const Eigen::Vector3d& p, Eigen::Vector3d* gradient) const {
  const Grid& grid = *grid_;
  if (gradient != nullptr) gradient->setZero();
  const Eigen::Array3d at = (p - grid.box.min()).array() * grid.cells_per_metre;
  if (!((at >= 0.0).all() && (at < grid.cells.cast<double>()).all())) return grid.band;
  const Eigen::Array3i index = at.cast<int>();
  const std::int32_t offset = grid.brick[grid.brick_index(index.x() >> kBrickShift, index.y() >> kBrickShift,
                                                          index.z() >> kBrickShift)];
  if (offset < 0) return offset == kFarOutside ? grid.band : -grid.band;

  const int first =
      node_index(index.x() & (kBrickCells - 1), index.y() & (kBrickCells - 1), index.z() & (kBrickCells - 1));
  const float* v = grid.values.data() + offset + first;
  const Eigen::Array3f t = (at - index.cast<double>()).cast<float>();
  // Along x, then y, then z; in this form equal corners give their very value.
  const float d00 = v[1] - v[0];
  const float d10 = v[kRow + 1] - v[kRow];
  const float d01 = v[kLayer + 1] - v[kLayer];
  const float d11 = v[kLayer + kRow + 1] - v[kLayer + kRow];
  const float x00 = v[0] + t.x() * d00;
  const float x10 = v[kRow] + t.x() * d10;
  const float x01 = v[kLayer] + t.x() * d01;
  const float x11 = v[kLayer + kRow] + t.x() * d11;
  const float y0 = x00 + t.y() * (x10 - x00);
  const float y1 = x01 + t.y() * (x11 - x01);
  if (gradient != nullptr) {
    const float d0 = d00 + t.y() * (d10 - d00);
    const float d1 = d01 + t.y() * (d11 - d01);
    const Eigen::Vector3f slope(d0 + t.z() * (d1 - d0), x10 - x00 + t.z() * (x11 - x01 - x10 + x00), y1 - y0);
    const float length = slope.norm();
    if (length > 0.0F) *gradient = (slope / length).cast<double>();
  }
  return static_cast<double>(y0 + t.z() * (y1 - y0));
}

}  // namespace stonestack::geometry
