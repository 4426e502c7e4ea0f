#pragma once
#include <string>
#include <vector>

#include "stonestack/core/rooms.hpp"

namespace stonestack::stone {

/// Size of a scan in metres, and a message about it.
struct FileScale {
  double metres_per_unit = 1.0;
  std::vector<std::string> warnings;
};

/// Metres per unit of the file times `scale`, for a mesh whose longest extent is `longest` file units.
/// `units`: m, cm, mm, or auto: of the three the one that makes the stone nearest to gripper size. Throws
/// FileError (named `source`) when the stone is not between 2 cm and 2 m, InvalidArgument for an unknown
/// unit.
[[nodiscard]] FileScale file_scale(double longest, const std::string& units, double scale,
                                   const std::string& source);

}  // namespace stonestack::stone
