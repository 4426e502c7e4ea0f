#pragma once
#include <string>

#include "stonestack/geometry/mesh.hpp"

#pragma GCC visibility push(default)

namespace stonestack::geometry {

/// Reads PLY, OBJ and STL with strict readers of our own (counts checked before allocation, indices and
/// finiteness checked, no second file opened). Exactly equal vertices become one (texture seams and STL
/// repeat them), then faces with a repeated corner and vertices without a face are dropped. Coordinates are
/// as in the file: no unit is applied. glTF (.glb, .gltf), Collada (.dae, in metres by its own unit), 3DS,
/// OFF and FBX are read by assimp in a process of its own with limits, which opens no second file
/// either; their nodes' transformations are applied. Throws FileError, also for other formats.
[[nodiscard]] Mesh read_mesh(const std::string& path);
/// Binary little-endian PLY, or OBJ, by extension; atomic. Throws FileError.
void write_mesh(const std::string& path, const Mesh& mesh);

}  // namespace stonestack::geometry

#pragma GCC visibility pop
