#pragma once
#include <CLI/CLI.hpp>

#include "rooms.hpp"

/// `stonestack bench NAME`: one function a benchmark, each in a file of its own. Every benchmark prints its
/// seed and settings and compares in one run.
namespace stonestack::apps {

void add_bench_kinematics(CLI::App& bench);
void add_bench_motion(CLI::App& bench);
void add_bench_collision(CLI::App& bench);
void add_bench_cartesian(CLI::App& bench);
void add_bench_timing(CLI::App& bench);
void add_bench_descent(CLI::App& bench);
void add_bench_grasp(CLI::App& bench);
void add_bench_hold(CLI::App& bench);
void add_bench_rest(CLI::App& bench);
void add_bench_search(CLI::App& bench);
void add_bench_calibration(CLI::App& bench);
void add_bench_equilibrium(CLI::App& bench);
void add_bench_detection(CLI::App& bench);
void add_bench_rtde(CLI::App& bench);

}  // namespace stonestack::apps
