#pragma once
#include <CLI/CLI.hpp>
#include <functional>
#include <string>

#include "rooms.hpp"
#include "stonestack/report/record_run.hpp"

/// One function a subcommand, each in a file of its own: it registers options, an example footer and a
/// callback that parses, calls the library and prints. Callbacks throw stonestack::Error; main turns it into
/// a line and an exit code.
namespace stonestack::apps {

void add_scan(CLI::App& app);
void add_render(CLI::App& app);
void add_detect(CLI::App& app);
void add_segment(CLI::App& app);
void add_model(CLI::App& app);
void add_track(CLI::App& app);
void add_search(CLI::App& app);
void add_check(CLI::App& app);
void add_plan(CLI::App& app);
void add_run(CLI::App& app);
void add_decide(CLI::App& app);
void add_inspect(CLI::App& app);
void add_replay(CLI::App& app);
void add_export(CLI::App& app);
void add_experiment(CLI::App& app);
/// Performs an experiment as `record_experiment` does, perhaps with other processes.
using RecordExperiment =
    std::function<RecordedExperiment(const ExperimentOrder& order, const Catalogue& catalogue,
                                     const std::function<void(const std::string& line)>& listener)>;
/// Adds `experiment` without --merge and examples, performed by `record`.
/// @return the subcommand
CLI::App& add_experiment_by(CLI::App& app, const RecordExperiment& record);
void add_simulate(CLI::App& app);
void add_doctor(CLI::App& app);
void add_record(CLI::App& app);
void add_rearm(CLI::App& app);
void add_setup(CLI::App& app);
void add_view(CLI::App& app);
void add_calibrate(CLI::App& app);
void add_config(CLI::App& app);
void add_completion(CLI::App& app);

}  // namespace stonestack::apps
