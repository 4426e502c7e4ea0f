#include "report/experiment_folder.hpp"

#include <iterator>
#include <sstream>

#include "report/experiment_page.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/report/record_run.hpp"

namespace stonestack::report {

std::string experiment_file(const std::string& folder) {
  return folder + "/experiment.json";
}

std::string options_file(const std::string& folder) {
  return folder + "/options.yaml";
}

std::string folder_of_run(const std::string& folder, int k) {
  return concat(folder, "/run-", k);
}

RunTexts run_texts(const nlohmann::json& file) {
  RunTexts runs;
  for (const nlohmann::json& run : file.at("runs")) {
    const int place = static_cast<int>(runs.size()) + 1;
    const int number = run.value("run", place);  // older records do not number their runs
    runs[number] = run;
    runs[number]["run"] = number;
  }
  return runs;
}

void write_record(const Experiment& experiment, const RunTexts& as_read, const std::string& folder) {
  std::string text = experiment_json(experiment);
  if (!as_read.empty()) {
    nlohmann::json whole = nlohmann::json::parse(text);
    for (nlohmann::json& run : whole["runs"])
      if (const auto read = as_read.find(run["run"].get<int>()); read != as_read.end()) run = read->second;
    text = whole.dump(2) + "\n";
  }
  write_file(experiment_file(folder), text);
  write_file(folder + "/runs.csv", runs_csv(experiment));
  write_file(folder + "/figure5.csv", figure5_csv(experiment));
  write_file(folder + "/figure5.svg", figure5_svg(experiment));
  write_file(folder + "/summary.txt", experiment_table(experiment));
  write_file(folder + "/report.html", experiment_html(experiment));
}

std::string listed_runs(const std::vector<int>& numbers) {
  std::string text;
  for (auto first = numbers.begin(), next = first; first != numbers.end(); first = next) {
    do ++next;
    while (next != numbers.end() && *next == *std::prev(next) + 1);
    text += concat(text.empty() ? "" : ", ", *first);
    const int last = *std::prev(next);
    if (last > *first) text += concat(last == *first + 1 ? ", " : " to ", last);
  }
  return text;
}

std::pair<std::string, std::string> first_difference(const std::string& a, const std::string& b) {
  std::istringstream in_a(a), in_b(b);
  std::string line_a, line_b;
  do {
    line_a.clear();
    line_b.clear();
    std::getline(in_a, line_a);
    std::getline(in_b, line_b);
  } while (line_a == line_b && (in_a || in_b));
  return {line_a, line_b};
}

}  // namespace stonestack::report
