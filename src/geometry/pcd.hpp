#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "stonestack/geometry/cloud.hpp"

namespace stonestack::geometry {

/// Strict PCD (ASCII, binary, binary_compressed), fields x y z and, if present, normal_x normal_y normal_z;
/// other fields are skipped. Points as in the file, possibly not finite. `path` is for messages. Throws
/// FileError.
[[nodiscard]] Cloud parse_pcd(const std::string& path, std::string_view content);

/// Field `label` (unsigned, 4 bytes) of each point of a binary PCD. Throws FileError.
[[nodiscard]] std::vector<int> parse_pcd_labels(const std::string& path, std::string_view content);

}  // namespace stonestack::geometry
