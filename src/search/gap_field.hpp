#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "search/height_raster.hpp"
#include "stonestack/geometry/mesh.hpp"

namespace stonestack::search {

/// Surface that a new stone may come to lie on, seen from above: heights in W and, per node, whether the
/// surface may be touched. What must not be touched (lower stones, the table) is raised by a clearance.
struct TopSurface {
  HeightRaster heights;
  std::vector<std::uint8_t> may_touch;  ///< 1: the top stone (or the table for an empty stack)
};

/// Nodes that are laid over a surface together: so many neighbours of one row.
inline constexpr int kRun = 8;

/// The underside of a stone in one orientation: nodes on multiples of the cell from its centre of mass, near
/// its lowest point only, in runs of kRun neighbours. Nodes of a run that do not count are infinitely high.
struct Underside {
  Eigen::Matrix3d R_W_O;
  double lowest = 0.0;     ///< lowest point under the centre of mass (negative) [m]
  double run_reach = 0.0;  ///< from a run's middle to its ends along x [m]
  std::vector<int> step;   ///< each run's first node: index from the centre's in a raster of the given stride
  std::vector<float> middle_x, row_y;  ///< each run's
  std::vector<float> x, y, z;          ///< each node's
};

/// Which nodes of the underside count: up to `cut` above the lowest point.
struct UndersideOptions {
  double cell = 0.004;
  int stride = 0;  ///< of the TopSurface that it will be laid over
  double cut = 0.035;
};

/// `vertices_M`: of the scan, relative to the centre of mass, axes of O.
[[nodiscard]] Underside make_underside(const std::vector<Eigen::Vector3d>& vertices_M,
                                       const std::vector<Eigen::Vector3i>& faces,
                                       const Eigen::Matrix3d& R_W_O, const UndersideOptions& options);

/// The gap D(x, y) = top height - underside height, x and y from the centre of mass. Buffers are reused; the
/// underside must outlive it.
struct GapField {
  const Underside* underside = nullptr;
  int centre = 0;                ///< node of the TopSurface below the centre of mass
  std::vector<float> d;          ///< each node's of the underside
  std::vector<float> highest_d;  ///< each run's
  std::vector<int> runs;         ///< that may touch, the last repeated up to a multiple of kRun, and of each
  std::vector<float> active_d, active_x, active_y;  ///< its highest d, its middle's x and its row's y
  float highest = kNoSurface;

  [[nodiscard]] int node(std::size_t cell) const {
    return centre + underside->step[cell / kRun] + static_cast<int>(cell % kRun);
  }
  /// x, y and gap of a node of the underside.
  [[nodiscard]] Eigen::Vector3d point(int cell) const {
    const auto k = static_cast<std::size_t>(cell);
    return {static_cast<double>(underside->x[k]), static_cast<double>(underside->y[k]),
            static_cast<double>(d[k])};
  }
};
/// Lays the underside over the surface with the centre of mass above node (i, j), which must be at least the
/// underside's extent (and kRun nodes) away from the raster's rim. Keeps runs within `active` of the largest
/// gap: the others cannot touch while the tilt stays small.
void lay(const TopSurface& top, const Underside& underside, int i, int j, double active, GapField* field);

/// The three artificial cells, in the places of cells: node k of the underside is k, the j-th of these -1 -
/// j.
inline constexpr std::array<int, 3> kArtificial{-1, -2, -3};

/// The plane c + a x + b y that rests on the gap field: the least height of the centre of mass, with tilt
/// free.
struct GapRest {
  bool rests = false;       ///< three cells carry it and they enclose the centre of mass; false: it tips over
  bool clean = false;       ///< and all three may be touched
  double height = 0.0;      ///< c, m
  double a = 0.0, b = 0.0;  ///< tilt that is still needed, rise over run
  std::array<int, 3> cells = kArtificial;  ///< nodes of the underside
};
/// min c subject to c + a x + b y >= D everywhere: a linear programme in three variables, by the dual simplex
/// method. Its basis is the upper hull facet of D above the centre of mass, so the contacts enclose it. Tilts
/// up to about `max_slope`: three artificial cells far out bear what would tilt further. `start`: the
/// cells of a rest of the same underside, say on the node beside, where the search for these begins; they
/// enclose the centre of mass whatever lies below them. The result does not depend on it, but for ties.
[[nodiscard]] GapRest solve_rest(const GapField& field, const TopSurface& top, double max_slope,
                                 const std::array<int, 3>& start = kArtificial);

/// How well a resting pose is carried.
struct GapContact {
  double margin = 0.0;  ///< centre of mass to the rim of the cells that nearly touch [m]
  double height = 0.0;  ///< centre of mass over the mean contact [m]
};
/// Cells within `tolerance` of the resting plane count as touching.
[[nodiscard]] GapContact contact_of(const GapField& field, const GapRest& rest, const TopSurface& top,
                                    double tolerance);

}  // namespace stonestack::search
