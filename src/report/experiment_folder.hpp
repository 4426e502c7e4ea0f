#pragma once
#include <string>
#include <utility>

#include "stonestack/experiment/experiment.hpp"

/// Private to report/: files of an experiment's record.
namespace stonestack::report {

/// experiment.json in the record's folder.
[[nodiscard]] std::string experiment_file(const std::string& folder);
/// Options of all runs; they have the experiment's seed.
[[nodiscard]] std::string options_file(const std::string& folder);
/// Folder of run `k` of the record.
[[nodiscard]] std::string folder_of_run(const std::string& folder, int k);

/// Writes table, figure 5, report and the runs as CSV and JSON. Throws FileError.
void write_record(const Experiment& experiment, const std::string& folder);

/// First line in which two texts differ, of each; both are empty where there is none.
[[nodiscard]] std::pair<std::string, std::string> first_difference(const std::string& a,
                                                                   const std::string& b);

}  // namespace stonestack::report
