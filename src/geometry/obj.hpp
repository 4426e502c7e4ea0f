#pragma once
#include <string>
#include <string_view>

#include "stonestack/geometry/mesh.hpp"

namespace stonestack::geometry {

/// Strict reading of the `v` and `f` lines of an OBJ file; all other lines are passed over and no second file
/// is ever opened. `path` is for messages. Throws FileError.
[[nodiscard]] Mesh parse_obj(const std::string& path, std::string_view content);

}  // namespace stonestack::geometry
