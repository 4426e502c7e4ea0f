#pragma once
#include <string>

#include "stonestack/stone/stone.hpp"

namespace stonestack::stone {

/// `stone.yaml`: all of a stone but its meshes, with units as comments.
[[nodiscard]] std::string stone_to_yaml(const Stone& stone);

/// Content of `stone.yaml`. Throws FileError naming file, key and value for a key that is missing, unknown,
/// not a number or out of its range.
struct StoneFile {
  Stone stone;    ///< without meshes
  int faces = 0;  ///< of mesh.ply
  int pieces = 0;
};
[[nodiscard]] StoneFile read_stone_yaml(const std::string& path);

}  // namespace stonestack::stone
