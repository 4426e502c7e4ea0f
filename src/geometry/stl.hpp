#pragma once
#include <string>
#include <string_view>

#include "stonestack/geometry/mesh.hpp"

namespace stonestack::geometry {

/// Strict STL, ASCII or binary; three vertices of its own for each face. `path` is for messages. Throws
/// FileError.
[[nodiscard]] Mesh parse_stl(const std::string& path, std::string_view content);

}  // namespace stonestack::geometry
