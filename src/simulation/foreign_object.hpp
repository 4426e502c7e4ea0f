#pragma once
#include <vector>

#include "stonestack/simulation/simulated_cell.hpp"

namespace stonestack::simulation {

/// The things that lie among the stones and are in no catalogue: boxes and cylinders in turn, as the options
/// ask for, each of its own size.
[[nodiscard]] std::vector<Stone> make_foreign_objects(const SimulationOptions& options);

}  // namespace stonestack::simulation
