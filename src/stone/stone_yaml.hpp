#pragma once
#include <string>

#include "stone/symmetry.hpp"
#include "stonestack/stone/stone.hpp"

namespace stonestack::stone {

/// `stone.yaml`: all of a stone but its meshes, with units as comments. Symmetries are left out where there
/// are none.
[[nodiscard]] std::string stone_to_yaml(const Stone& stone, const Symmetries& symmetries = {});

/// Content of `stone.yaml`. Throws FileError naming file, key and value for a key that is missing, unknown,
/// not a number or out of its range.
struct StoneFile {
  Stone stone;    ///< without meshes
  int faces = 0;  ///< of mesh.ply
  int pieces = 0;
  Symmetries symmetries;
};
[[nodiscard]] StoneFile read_stone_yaml(const std::string& path);

}  // namespace stonestack::stone
