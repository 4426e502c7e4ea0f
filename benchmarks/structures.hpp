#pragma once
#include "bench.hpp"

namespace stonestack::bench {

void add_structures(CLI::App& app);

}  // namespace stonestack::bench
