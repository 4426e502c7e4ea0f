#pragma once
#include "bench.hpp"

/// Benchmarks of the models of depth cameras.
namespace stonestack::bench {

void add_sensors(CLI::App& app);

}  // namespace stonestack::bench
