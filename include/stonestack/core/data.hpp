#pragma once
#include <string>

#include "stonestack/core/rooms.hpp"

#pragma GCC visibility push(default)

namespace stonestack::core {

/// Path of a file or folder that comes with stonestack, e.g. `data_path("stones")`,
/// `data_path("robots/ur10.urdf")`. Looked for below STONESTACK_DATA, then beside the program as installed
/// (share/stonestack), then in the source tree. Throws FileError naming what was tried.
[[nodiscard]] std::string data_path(const std::string& name);

}  // namespace stonestack::core

#pragma GCC visibility pop
