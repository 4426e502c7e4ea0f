#pragma once
#include <optional>
#include <string>
#include <vector>

#include "stonestack/core/options.hpp"
#include "stonestack/geometry/convex_pieces.hpp"
#include "stonestack/stone/stone.hpp"

namespace stonestack {

/// How a scan becomes a stone.
struct ModelOptions {
  std::string units =
      "m";             ///< m, cm, mm or auto (a stone is between 2 cm and 2 m; auto picks the unit that fits)
  double scale = 1.0;  ///< further factor, e.g. 0.12 for boulders
  double density = 2600.0;  ///< kg/m^3, limestone
  double mass = 0.0;        ///< kg; 0: from density
  double friction = 0.1;    ///< paper §4.1
  int faces = 500;          ///< of the reduced mesh, paper §4.1
  int convex_pieces = 5;    ///< at most
};
[[nodiscard]] FieldList fields(ModelOptions& options);

/// A stone and what had to be done to the scan, and how far its shapes lie from it.
struct ModelResult {
  Stone stone;
  std::vector<std::string> warnings;           ///< closed a hole, dropped fragments, flipped faces, odd size
  double mesh_median = 0.0, mesh_worst = 0.0;  ///< m: reduced mesh against scan (both ways)
  double contact_median = 0.0, contact_worst = 0.0;  ///< m: contact geometry against scan
};

/// From a mesh in file units. Holes are closed by CGAL with a warning. Throws FileError (named `source`) for
/// a mesh that cannot be a stone: empty, not a surface, no volume, size out of 2 cm to 2 m after units.
[[nodiscard]] ModelResult model_stone(const Mesh& scan, const std::string& name, const std::string& source,
                                      const ModelOptions& options = {});

}  // namespace stonestack
