#pragma once
#include <string>
#include <vector>

#include "stonestack/stone/stone.hpp"

namespace stonestack {

/// Stones in a folder: `DIR/NAME/stone.yaml`, `DIR/NAME/mesh.ply`, `DIR/NAME/scan.ply`,
/// `DIR/NAME/pieces.ply`.
struct Catalogue {
  std::string path;
  std::vector<Stone> stones;  ///< sorted by name

  /// Index of the stone with that name; throws InvalidArgument naming the nearest.
  [[nodiscard]] int index(const std::string& name) const;
};

/// Reads every stone; throws FileError naming file and value, also for a folder without stones.
[[nodiscard]] Catalogue read_catalogue(const std::string& path);
/// Writes one stone into its folder, whole or not at all.
void write_stone(const std::string& catalogue_path, const Stone& stone);

}  // namespace stonestack
