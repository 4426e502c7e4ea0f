#pragma once
#include <string>

#include "stonestack/geometry/mesh.hpp"

namespace stonestack {

/// Reads PLY, OBJ and STL with strict readers of our own (counts checked before allocation, indices and
/// finiteness checked, no second file opened) and the formats that assimp knows in a helper process with
/// limits. Coordinates are as in the file: no unit is applied. Throws FileError.
[[nodiscard]] Mesh read_mesh(const std::string& path);
/// Binary little-endian PLY, or OBJ, by extension; atomic. Throws FileError.
void write_mesh(const std::string& path, const Mesh& mesh);

}  // namespace stonestack
