#pragma once
#include <string>

#include "report/run_record.hpp"

/// Private to report/: the files that a recorded run is exported as.
namespace stonestack::report {

/// Binary glTF 2.0: the stones where they lie at the end, and an animation of the run.
[[nodiscard]] std::string to_glb(const RunRecord& record);
/// MCAP without compression: topics /joints, /gripper, /stones, /placements and /log, JSON with schemas.
[[nodiscard]] std::string to_mcap(const RunRecord& record);
/// COMPAS JSON of a compas_assembly: blocks in W, the table as their support; sequence and trajectories are
/// attributes.
[[nodiscard]] std::string to_compas(const RunRecord& record);

}  // namespace stonestack::report
