#pragma once
#include <CLI/CLI.hpp>
#include <functional>

#include "draws.hpp"
#include "result_table.hpp"
#include "rooms.hpp"

/// One function a benchmark, each in a file of its own: it registers a subcommand of stonestack-bench. Every
/// benchmark reports its seed and settings and compares in one run.
namespace stonestack::bench {

/// Gives a benchmark --json and --record, and runs it with results of its own, which are printed whether it
/// ends, fails or is interrupted. What --record names is written at the end, with the command.
void measure_by(CLI::App& sub, std::function<void(Results&)> measure);
/// Likewise a benchmark of independent draws, which gets --shard, --continue and --merge, too. What a shard
/// records holds the outcomes of its draws and the arguments; a merge parses these and makes the tables.
void measure_draws_by(CLI::App& sub, std::function<void(Results&, Draws&)> measure);

void add_faults(CLI::App& app);
void add_mount(CLI::App& app);
void add_kinematics(CLI::App& app);
void add_modelling(CLI::App& app);
void add_motion(CLI::App& app);
void add_collision(CLI::App& app);
void add_cartesian(CLI::App& app);
void add_timing(CLI::App& app);
void add_descent(CLI::App& app);
void add_grasp(CLI::App& app);
void add_grippers(CLI::App& app);
void add_hold(CLI::App& app);
void add_push(CLI::App& app);
void add_rest(CLI::App& app);
void add_resume(CLI::App& app);
void add_search(CLI::App& app);
void add_calibration(CLI::App& app);
void add_equilibrium(CLI::App& app);
void add_detection(CLI::App& app);
void add_segmentation(CLI::App& app);
void add_rtde(CLI::App& app);
void add_results(CLI::App& app);
void add_site(CLI::App& app);

}  // namespace stonestack::bench
