#pragma once
#include <optional>
#include <string>
#include <vector>

#include "stonestack/report/picture.hpp"
#include "stonestack/stacking/build_tower.hpp"

namespace stonestack::report {

/// What the simulated cell's own truth says of the finished tower; the program under test never sees it.
struct TruthReport {
  int height = 0;         ///< stones that rest on the stone below and on nothing else
  bool stands = false;    ///< the tower that the run reports still stands after `seconds`
  double seconds = 60.0;  ///< simulated, with the arm away
  double shift = 0.0;     ///< m, largest movement of a tower stone in that time
  double turn = 0.0;      ///< rad, likewise
  std::string note;
};

/// Everything that is told of a run.
struct RunReport {
  RunResult result;
  std::string version;  ///< of the program that made it; empty: unknown
  std::string robot;
  std::string catalogue;
  int seed = 0;
  std::vector<std::string> present;  ///< names of the stones that were in the field
  std::optional<TruthReport> truth;  ///< simulated cell only
  std::string options_text;          ///< resolved options, YAML
  std::string picture;               ///< path of the PNG; empty: none. The JSON names it beside result.json
};

/// "stonestack.run/1" (README, "Output formats"): one JSON object, times included.
[[nodiscard]] std::string run_json(const RunReport& report);
/// The table that a person reads at the end of a run: stone, cost and its terms, planned and measured pose,
/// outcome, times.
[[nodiscard]] std::string run_table(const RunReport& report);
/// One self-contained HTML file with the picture, the table and the options.
[[nodiscard]] std::string run_html(const RunReport& report);
/// Meshes of stones at poses in stone-like colours, one a stone.
[[nodiscard]] std::vector<DrawnMesh> drawn_stones(const Catalogue& catalogue,
                                                  const std::vector<PlacedStone>& stones);
/// A view of everything at the site: from the front, high enough to see the table.
[[nodiscard]] View view_of_site(const Eigen::Vector2d& site, double top_height);

}  // namespace stonestack::report
