#pragma once
#include <vector>

#include "stonestack/simulation/simulated_cell.hpp"

namespace stonestack::simulation {

/// The stones as the simulated world has them: each surface lies beside its scan, along its normals, by two
/// smooth errors (root of the mean square over the vertices): `options.scan_error` in waves of 20 mm and
/// `options.scan_roughness` in waves of 3 mm, as far as the scan's vertices resolve them. With neither they
/// are the scans.
[[nodiscard]] std::vector<Stone> as_they_are(const std::vector<Stone>& scanned,
                                             const SimulationOptions& options);
/// True if a surface of `as_they_are` is not its scan.
[[nodiscard]] bool differs_from_scan(const SimulationOptions& options);

}  // namespace stonestack::simulation
