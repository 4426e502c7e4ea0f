#pragma once
#include <vector>

#include "stonestack/simulation/simulated_cell.hpp"

namespace stonestack::simulation {

/// The stones as the simulated world has them: each surface lies beside its scan, along its normal, by a
/// smooth error of `options.scan_error` (root of the mean square over the vertices). With none they are the
/// scans.
[[nodiscard]] std::vector<Stone> as_they_are(const std::vector<Stone>& scanned,
                                             const SimulationOptions& options);

}  // namespace stonestack::simulation
