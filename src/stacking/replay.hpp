#pragma once
#include <string>

#include "stacking/journal.hpp"
#include "stonestack/stacking/build_tower.hpp"

/// Private to stacking/: a run that can be replayed.
namespace stonestack::stacking {

/// Folder, within a run's, of what its devices answered.
inline constexpr const char* kInputsFolder = "/inputs";

/// Writes what a run starts from, beside the answers of its devices.
/// @throws FileError
void write_start(const std::string& folder, const CellLayout& layout, const Catalogue& catalogue,
                 const RobotModel& robot, const BuildOptions& options, const Journal* journal);

}  // namespace stonestack::stacking
