#pragma once
#include <map>
#include <set>
#include <string>
#include <vector>

#include "physics/coupled_analysis.hpp"
#include "stonestack/geometry/mesh.hpp"

namespace stonestack::physics {

/// A rigid block of an assembly.
struct AssemblyBlock {
  std::string name;      ///< key of its node in the file
  Mesh mesh;             ///< closed; W
  bool support = false;  ///< does not move
  double density = 1.0;
};

/// A plane polygon in which two blocks touch.
struct AssemblyInterface {
  int below = 0, above = 0;                        ///< blocks
  std::vector<Eigen::Vector3d> corners_W;          ///< in order around the polygon
  Eigen::Vector3d n_W = Eigen::Vector3d::UnitZ();  ///< unit, from `below` to `above`
};

/// Blocks with the interfaces that the file names (empty: find them).
struct BlockAssembly {
  std::vector<AssemblyBlock> blocks;
  std::vector<AssemblyInterface> interfaces;
};

/// Reads an assembly of COMPAS (compas_assembly, compas_cra: JSON).
/// @throws FileError that names block, value and remedy: missing keys, numbers that are not finite, meshes
/// that are not closed or enclose no volume, more than 10,000 blocks.
[[nodiscard]] BlockAssembly read_assembly(const std::string& path);

/// Faces of two blocks that lie in one plane within `tolerance` (of the smaller block's size), face each
/// other and overlap: their intersections.
[[nodiscard]] std::vector<AssemblyInterface> find_interfaces(const std::vector<AssemblyBlock>& blocks,
                                                             double tolerance = 1e-3);

/// An assembly as statics sees it.
struct AssemblyStatics {
  std::vector<StaticBody> bodies;      ///< blocks that are no supports
  std::vector<int> blocks;             ///< block of each body
  std::vector<BlockContact> contacts;  ///< corners of the interfaces; those between two supports are left out
};
[[nodiscard]] AssemblyStatics statics_of(const BlockAssembly& assembly);

}  // namespace stonestack::physics
