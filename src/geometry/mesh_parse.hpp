#pragma once
#include <string>
#include <string_view>

#include "stonestack/geometry/mesh.hpp"

namespace stonestack::geometry {

/// The part of `path` after its last dot, in lower case; empty without one.
[[nodiscard]] std::string lower_case_extension(const std::string& path);

/// Reads a mesh file that lies in memory: "ply", "stl" or "obj". `path` is for messages. Throws FileError.
[[nodiscard]] Mesh parse_mesh(const std::string& path, const std::string& extension,
                              std::string_view content);

}  // namespace stonestack::geometry
