#pragma once
#include <filesystem>
#include <vector>

namespace stonestack::core {

/// Folders below which this program and this library may be installed, in the order in which to look: above
/// the folder of the program (bin), then above the folder of the library (lib, lib/x86_64-linux-gnu). The
/// build folder has the same layout. No path of the machine that compiled is among them.
[[nodiscard]] std::vector<std::filesystem::path> install_prefixes();

}  // namespace stonestack::core
