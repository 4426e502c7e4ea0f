#pragma once
#include "bench.hpp"

namespace stonestack::bench {

/// StoneBench (docs/stonebench.md): problems, answers of this library, and the scorer of any planner's
/// answers.
void add_problems(CLI::App& app);
void add_solve(CLI::App& app);
void add_score(CLI::App& app);

}  // namespace stonestack::bench
