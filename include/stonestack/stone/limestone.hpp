#pragma once
#include <cstdint>

#include "stonestack/geometry/mesh.hpp"

namespace stonestack {

/// Shape of a generated limestone.
struct LimestoneOptions {
  double smallest = 0.09;  ///< m, longest extent
  double largest = 0.20;   ///< m
  int faces = 4000;        ///< of the full-resolution scan
};

/// A closed mesh like a piece of limestone rubble: cut faces, broken edges, dents, roughness; volume over
/// hull 0.8 to 0.9. Same seed, same stone.
[[nodiscard]] Mesh make_limestone(std::uint64_t seed, const LimestoneOptions& options = {});

}  // namespace stonestack
