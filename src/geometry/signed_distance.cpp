#include "geometry/signed_distance.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <memory>
#include <vector>

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
constexpr double kMaxNodes = 64e6;

constexpr int node_index(int x, int y, int z) {
  return (z * kBrickNodes + y) * kBrickNodes + x;
}

}  // namespace

/// Cells in bricks of 4 x 4 x 4, each filled when a query first meets it: of a stone's shape most are never
/// asked for, and filling all of them is dear. A query touches one brick, 500 bytes (float: 1 nm in 12 mm).
/// The values of a brick depend neither on earlier queries nor on the thread.
struct SignedDistance::Grid {
  using Brick = std::array<float, kBrickValues>;

  SurfaceTree tree;
  Eigen::AlignedBox3d box;
  double cell = 0.0;
  double cells_per_metre = 0.0;
  double band = 0.0;
  Eigen::Array3i cells = Eigen::Array3i::Zero();
  Eigen::Array3i bricks = Eigen::Array3i::Zero();
  Brick outside{}, inside{};  ///< of all bricks that lie further from the surface than the band
  mutable std::vector<std::atomic<const Brick*>> brick;  ///< null: not filled yet

  explicit Grid(const Mesh& mesh) : tree(mesh) {}
  Grid(const Grid&) = delete;
  Grid& operator=(const Grid&) = delete;
  ~Grid() {
    for (const auto& one : brick) drop(one.load());
  }

  void drop(const Brick* one) const {
    if (one != &outside && one != &inside) delete one;
  }
  [[nodiscard]] const Brick& at(const Eigen::Array3i& index) const;
  [[nodiscard]] const Brick* filled(const Eigen::Array3i& index) const;
};

const SignedDistance::Grid::Brick& SignedDistance::Grid::at(const Eigen::Array3i& index) const {
  auto& kept = brick[static_cast<std::size_t>((index.z() * bricks.y() + index.y()) * bricks.x() + index.x())];
  const Brick* there = kept.load(std::memory_order_acquire);
  if (there != nullptr) return *there;
  const Brick* made = filled(index);
  if (kept.compare_exchange_strong(there, made, std::memory_order_acq_rel)) return *made;
  drop(made);  // another thread was quicker, with the same values
  return *there;
}

const SignedDistance::Grid::Brick* SignedDistance::Grid::filled(const Eigen::Array3i& index) const {
  const double half_side = 0.5 * kBrickCells * cell;
  const Eigen::Vector3d corner = box.min() + (index.cast<double>() * kBrickCells * cell).matrix();
  const SurfacePoint nearest_to_middle = tree.nearest(corner + Eigen::Vector3d::Constant(half_side));
  if (std::abs(nearest_to_middle.distance) > band + std::sqrt(3.0) * half_side)
    return nearest_to_middle.distance > 0.0 ? &outside : &inside;
  auto result = std::make_unique<Brick>();
  int likely_face = nearest_to_middle.face;
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
          const Eigen::Array3i node = index * kBrickCells + Eigen::Array3i(x, y, z);
          nodes.push_back(static_cast<std::size_t>(node_index(x, y, z)));
          points.emplace_back(box.min() + (node.cast<double>() * cell).matrix());
        }
      }
    }
    const std::vector<SurfacePoint> nearest = tree.nearest(points, likely_face);
    for (std::size_t i = 0; i < nodes.size(); ++i)
      (*result)[nodes[i]] = static_cast<float>(std::clamp(nearest[i].distance, -band, band));
    likely_face = nearest.back().face;
  }
  return result.release();
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
  const auto grid = std::make_shared<Grid>(mesh);
  grid->cell = cell;
  grid->cells_per_metre = 1.0 / cell;
  grid->band = static_cast<double>(static_cast<float>(band));  // what the nodes hold
  grid->bricks = bricks.cast<int>();
  grid->cells = grid->bricks * kBrickCells;
  const Eigen::Vector3d half = (0.5 * cell * grid->cells.cast<double>()).matrix();
  grid->box = {around.center() - half, around.center() + half};
  grid->outside.fill(static_cast<float>(band));
  grid->inside.fill(static_cast<float>(-band));
  grid->brick = std::vector<std::atomic<const Grid::Brick*>>(static_cast<std::size_t>(grid->bricks.prod()));
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
  const Grid::Brick& brick = grid.at(index.unaryExpr([](int i) { return i >> kBrickShift; }));
  if (&brick == &grid.outside || &brick == &grid.inside) return brick.front();

  const int first =
      node_index(index.x() & (kBrickCells - 1), index.y() & (kBrickCells - 1), index.z() & (kBrickCells - 1));
  const float* v = brick.data() + first;
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
