#pragma once
#include "bench.hpp"

/// Benchmarks of long work on one machine and on many.
namespace stonestack::bench {

void add_schedule(CLI::App& app);
void add_soak(CLI::App& app);

}  // namespace stonestack::bench
