#pragma once
#include <string>
#include <vector>

#include "stonestack/experiment/experiment.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/report/picture.hpp"
#include "stonestack/stone/catalogue.hpp"

#pragma GCC visibility push(default)

namespace stonestack::report {

/// "stonestack.run/1" (README, "Output formats"): one JSON object, times included.
[[nodiscard]] std::string run_json(const RunReport& report);
/// The table that a person reads at the end of a run: stone, cost and its terms, planned and measured pose,
/// outcome, times.
[[nodiscard]] std::string run_table(const RunReport& report);
/// One self-contained HTML file: the cell in 3-D over the whole time of the run, decisions with the
/// placements that were compared, tables, times, the paper's figure 5, options. Without WebGL it shows the
/// picture `report.picture`. Throws FileError if that cannot be read.
[[nodiscard]] std::string run_html(const RunReport& report, const Catalogue& catalogue,
                                   const RobotModel& robot);
/// Meshes of stones at poses in stone-like colours, one a stone.
[[nodiscard]] std::vector<DrawnMesh> drawn_stones(const Catalogue& catalogue,
                                                  const std::vector<PlacedStone>& stones);
/// A view of everything at the site: from the front, high enough to see the table.
[[nodiscard]] View view_of_site(const Eigen::Vector2d& site, double top_height);

}  // namespace stonestack::report

#pragma GCC visibility pop
