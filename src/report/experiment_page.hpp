#pragma once
#include <string>

#include "stonestack/experiment/experiment.hpp"

/// Private to report/: the page of an experiment.
namespace stonestack::report {

/// Data of the page: heights, runs, figure 5, as one line of JSON. `total`: runs that were ordered.
[[nodiscard]] std::string experiment_data(const Experiment& experiment, int total);
/// The page around the data of an experiment that is done, one file without a network.
[[nodiscard]] std::string experiment_html(const Experiment& experiment);
/// Page of an experiment that goes on.
[[nodiscard]] std::string live_experiment_page(const Experiment& experiment, int total);
/// Title with the shard, unless it is the whole experiment.
[[nodiscard]] std::string title_of(const Experiment& experiment);
/// Mean of the judged heights; 0 without runs.
[[nodiscard]] double mean_height(const Experiment& experiment);

/// The page around `data`; `text` stands there for a browser without scripts.
[[nodiscard]] std::string experiment_page(const std::string& data, const std::string& text);

}  // namespace stonestack::report
