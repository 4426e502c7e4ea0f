#pragma once
#include <string>

#include "report/record_folder.hpp"
#include "stonestack/report/record_run.hpp"

/// Private to report/: how a run was started, kept in its folder.
namespace stonestack::report {

/// File, within the folder of a run, of how it was started.
inline constexpr const char* kOrderFile = "/order.json";

/// Devices that another process finds again: those of a real cell, or a simulated cell of this process, which
/// is kept in the folder. Simulated devices on sockets end with their process.
[[nodiscard]] bool can_resume(const RunOrder& order);
/// Writes order.json.
/// @throws FileError
void write_order(const std::string& folder, const RunOrder& order, const Catalogue& catalogue);
/// Takes the folder of a run that is not under way.
/// @throws FileError
[[nodiscard]] RecordFolder take_resumed_folder(const std::string& folder);

}  // namespace stonestack::report
