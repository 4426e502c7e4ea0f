#pragma once
#include "bench.hpp"

namespace stonestack::bench {

void add_walls(CLI::App& app);
void add_wall_growth(CLI::App& app);

}  // namespace stonestack::bench
