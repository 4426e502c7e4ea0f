#pragma once
#include <cstdint>

#include "stonestack/geometry/mesh.hpp"

#pragma GCC visibility push(default)

namespace stonestack::stone {

/// Shape of a generated limestone. Ranges as measured on sixteen scanned rocks of this size.
struct LimestoneOptions {
  double smallest = 0.09;    ///< longest extent [m]
  double largest = 0.20;     ///< [m]
  double widest = 0.125;     ///< second extent [m]: a gripper that opens 155 mm gets around it
  double least_full = 0.80;  ///< volume over the volume of the convex hull
  double most_full = 0.90;
  int faces = 4000;  ///< at most, of the full-resolution scan
};

/// A closed mesh like a piece of limestone rubble: bedding planes and cleavage faces, broken edges and
/// chipped corners, dents, 0.3 to 0.5 mm of roughness. Longest extent along x, shortest along z, metres.
/// Star-shaped about the origin, so it never cuts itself. Same seed, same stone. Throws InvalidArgument for
/// options that no stone can meet.
[[nodiscard]] Mesh make_limestone(std::uint64_t seed, const LimestoneOptions& options = {});

}  // namespace stonestack::stone

#pragma GCC visibility pop
