#include "report/experiment_folder.hpp"

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

void write_record(const Experiment& experiment, const std::string& folder) {
  write_file(experiment_file(folder), experiment_json(experiment));
  write_file(folder + "/runs.csv", runs_csv(experiment));
  write_file(folder + "/figure5.csv", figure5_csv(experiment));
  write_file(folder + "/figure5.svg", figure5_svg(experiment));
  write_file(folder + "/summary.txt", experiment_table(experiment));
  write_file(folder + "/report.html", experiment_html(experiment));
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
