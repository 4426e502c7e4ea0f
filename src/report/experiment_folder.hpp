#pragma once
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "stonestack/experiment/experiment.hpp"

/// Private to report/: files of an experiment's record.
namespace stonestack::report {

/// experiment.json in the record's folder.
[[nodiscard]] std::string experiment_file(const std::string& folder);
/// Options of all runs; they have the experiment's seed.
[[nodiscard]] std::string options_file(const std::string& folder);
/// Folder of run `k` of the record.
[[nodiscard]] std::string folder_of_run(const std::string& folder, int k);

/// Runs by number, as the file of an experiment holds them: to the last digit, and nothing omitted.
using RunTexts = std::map<int, nlohmann::json>;
/// Runs of a file that experiment_json wrote.
[[nodiscard]] RunTexts run_texts(const nlohmann::json& file);
/// Content of a file that experiment_json wrote; see `read_experiment`. `path` is named in errors. Throws
/// FileError.
[[nodiscard]] Experiment experiment_of(const nlohmann::json& file, const std::string& path);

/// Writes table, figure 5, report and the runs as CSV and JSON. Runs among `as_read` are written as they
/// were read. Throws FileError.
void write_record(const Experiment& experiment, const RunTexts& as_read, const std::string& folder);

/// "2, 4 to 7": numbers in rising order.
[[nodiscard]] std::string listed_runs(const std::vector<int>& numbers);

/// First line in which two texts differ, of each; both are empty where there is none.
[[nodiscard]] std::pair<std::string, std::string> first_difference(const std::string& a,
                                                                   const std::string& b);

}  // namespace stonestack::report
