#pragma once
#include "bench.hpp"

namespace stonestack::bench {

void add_walls(CLI::App& app);
void add_tasks(CLI::App& app);

}  // namespace stonestack::bench
