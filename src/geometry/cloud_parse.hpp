#pragma once
#include <string>
#include <string_view>

#include "stonestack/geometry/cloud.hpp"

namespace stonestack::geometry {

/// Reads a cloud file that lies in memory: "ply" or "pcd". `path` is for messages. Throws FileError.
[[nodiscard]] Cloud parse_cloud(const std::string& path, const std::string& extension,
                                std::string_view content);

}  // namespace stonestack::geometry
