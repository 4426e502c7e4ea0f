#pragma once
#include <string>

/// Private to report/: which cells have completed a run on hardware, by path and content of their file.
namespace stonestack::report {

/// File of this memory: $XDG_STATE_HOME/stonestack/cells.json, or below ~/.local/state.
[[nodiscard]] std::string known_cells_path();
/// True if the cell file, as it now is, was noted. A memory that cannot be read counts as none and is
/// reported.
/// @throws FileError for a cell file that cannot be read
[[nodiscard]] bool is_known_cell(const std::string& cell_path);
/// Notes the cell file as it now is. A memory that cannot be written is reported.
void note_known_cell(const std::string& cell_path);

}  // namespace stonestack::report
