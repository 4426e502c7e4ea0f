#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "stonestack/core/options.hpp"
#include "stonestack/geometry/mesh.hpp"
#include "stonestack/stone/stone.hpp"

#pragma GCC visibility push(default)

namespace stonestack::stone {

/// Shape of a generated limestone. Ranges as measured on sixteen scanned rocks of this size.
struct LimestoneOptions {
  double min_extent = 0.09;    ///< longest extent [m]
  double max_extent = 0.20;    ///< [m]
  double widest = 0.125;       ///< second extent [m]: a gripper that opens 155 mm gets around it
  double min_fullness = 0.80;  ///< volume over the volume of the convex hull
  double max_fullness = 0.90;  ///< upper limit of the fullness
  int faces = 4000;            ///< at most, of the full-resolution scan
};

/// A closed mesh like a piece of limestone rubble: bedding planes and cleavage faces, broken edges and
/// chipped corners, dents, 0.3 to 0.5 mm of roughness. Longest extent along x, shortest along z, metres.
/// Star-shaped about the origin, so it never cuts itself. Same seed, same stone.
/// @throws InvalidArgument for options that no stone can meet.
[[nodiscard]] Mesh make_limestone(std::uint64_t seed, const LimestoneOptions& options = {});

/// How a scan becomes a stone.
struct ModelOptions {
  /// cm, mm or auto [m]: the unit that makes a stone of graspable size (scans come in all three).
  std::string units = "m";
  double scale = 1.0;       ///< further factor, e.g. 0.12 for boulders
  double density = 2600.0;  ///< limestone [kg/m^3]
  double mass = 0.0;        ///< 0 [kg]: from density
  double friction = 0.1;    ///< paper §4.1
  int faces = 500;          ///< at most, of the reduced mesh, paper §4.1
  int convex_pieces = 5;    ///< at most
  double contact_cell =
      0.0015;  ///< grid that the contact deviation is measured with [m]: physics' ShapeOptions
};
[[nodiscard]] FieldList fields(ModelOptions& options);

/// A stone, and what had to be done to the scan: holes closed, fragments dropped, odd size.
struct ModelResult {
  Stone stone;                        ///< stone that was made
  std::vector<std::string> warnings;  ///< holes closed, fragments dropped, odd size; for a person
};

/// From a mesh in file units. Holes are closed by CGAL with a warning.
/// @throws FileError (named `source`) for a mesh that cannot be a stone: empty, not finite, encloses nothing,
/// size out of 2 cm to 2 m after units.
[[nodiscard]] ModelResult model_stone(const Mesh& scan, const std::string& name, const std::string& source,
                                      const ModelOptions& options = {});
/// The generated limestone `number` (from 1) of a seed, named limestone_NUMBER. Units and scale of the
/// options are not for it.
[[nodiscard]] ModelResult model_limestone(std::uint64_t seed, int number, const ModelOptions& options = {});
/// Name for the stone of a scan: the file's stem with '_' for each character that a name may not hold.
[[nodiscard]] std::string stone_name_of(const std::string& file);

}  // namespace stonestack::stone

#pragma GCC visibility pop
