#include "report/experiment_page.hpp"

#include "report/text.hpp"
#include "stonestack/report/record_run.hpp"

namespace stonestack::report {

double mean_height(const Experiment& experiment) {
  double sum = 0.0;
  for (const ExperimentRun& run : experiment.runs) sum += judged_height(run);
  return experiment.runs.empty() ? 0.0 : sum / static_cast<double>(experiment.runs.size());
}

std::string experiment_data(const Experiment& experiment, int total) {
  nlohmann::json runs = nlohmann::json::array();
  for (const ExperimentRun& run : experiment.runs) {
    const RunResult& result = run.report.result;
    runs.push_back({{"run", run.number},
                    {"seed", run.report.seed},
                    {"height", judged_height(run)},
                    {"reported", result.height},
                    {"paper_height", paper_height(run.report)},
                    {"seconds", result.seconds.motion},
                    {"ended", result.ended}});
  }
  return nlohmann::json{{"title", title_of(experiment)},
                        {"total", total},
                        {"mean_height", mean_height(experiment)},
                        {"heights", heights(experiment)},
                        {"paper_heights", paper_heights(experiment)},
                        {"runs", runs},
                        {"figure5", figure5_svg(experiment)},
                        {"table", experiment_table(experiment)}}
      .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

std::string experiment_html(const Experiment& experiment) {
  return experiment_page(experiment_data(experiment, static_cast<int>(experiment.runs.size())),
                         experiment_table(experiment));
}

std::string live_experiment_page(const Experiment& experiment, int total) {
  std::string data = experiment_data(experiment, total);
  data.insert(data.size() - 1, ",\"live\":true");
  return experiment_page(data, "The page of an experiment that is under way.");
}

}  // namespace stonestack::report
