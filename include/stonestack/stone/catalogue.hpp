#pragma once
#include <string>
#include <vector>

#include "stonestack/stone/stone.hpp"

#pragma GCC visibility push(default)

namespace stonestack::stone {

/// Stones in a folder: `DIR/NAME/stone.yaml`, `DIR/NAME/mesh.ply` (reduced), `DIR/NAME/scan.ply` (full) and
/// `DIR/NAME/pieces/1.ply` and so on (convex). Metres, frame O.
struct Catalogue {
  std::string path;           ///< folder
  std::vector<Stone> stones;  ///< sorted by name

  /// Stone of an index.
  /// @throws InvalidArgument for one that is not in the catalogue.
  [[nodiscard]] const Stone& operator[](StoneIndex stone) const { return at(stones, stone); }
  /// Index of the stone with that name; throws InvalidArgument naming the nearest.
  [[nodiscard]] StoneIndex index(const std::string& name) const;
};

/// Reads every stone; throws FileError naming file and value, also for a folder without stones.
[[nodiscard]] Catalogue read_catalogue(const std::string& path);
/// True for what may be a stone's name and so a folder's: 1 to 64 letters, digits, '_', '-', '.', no '.'
/// first.
[[nodiscard]] bool is_stone_name(const std::string& name);
/// Writes one stone into its folder, whole or not at all, in the place of one of that name. Makes the
/// catalogue's folder.
/// @throws FileError InvalidArgument for a name that is none.
void write_stone(const std::string& catalogue_path, const Stone& stone);

}  // namespace stonestack::stone

#pragma GCC visibility pop
