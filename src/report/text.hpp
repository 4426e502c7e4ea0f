#pragma once
#include <cstdio>
#include <nlohmann/json.hpp>
#include <string>

#include "geometry/pose_json.hpp"
#include "stonestack/experiment/experiment.hpp"
#include "stonestack/stone/catalogue.hpp"

/// Private to report/: text and JSON that several reports share.
namespace stonestack::report {

/// Text as printf makes it, of any length.
template <class... Values>
[[nodiscard]] std::string format(const char* pattern, Values... values) {
  std::string text(static_cast<std::size_t>(std::snprintf(nullptr, 0, pattern, values...)), ' ');
  std::snprintf(text.data(), text.size() + 1, pattern, values...);
  return text;
}

[[nodiscard]] inline const std::string& name_of(const Catalogue& catalogue, StoneIndex stone) {
  return catalogue[stone].name;
}

/// "lab", or "lab, but friction=0.2" where options were set beside those of the named cell; "real" without
/// one.
[[nodiscard]] inline std::string cell_text(const RunReport& report) {
  std::string text = report.cell.empty() ? "real" : report.cell;
  for (const auto& change : report.cell_changes)
    text += (&change == &report.cell_changes.front() ? ", but " : ", ") + change;
  return text;
}

/// {stone, T_W_O}
[[nodiscard]] inline nlohmann::json placed_json(const Catalogue& catalogue, StoneIndex stone,
                                                const Pose& T_W_O) {
  return {{"stone", name_of(catalogue, stone)}, {"T_W_O", pose_json(T_W_O)}};
}

/// Kind of structure: "tower", "wall" or "bridge".
[[nodiscard]] const char* structure_name(const std::optional<WallMetrics>& wall);
/// Kind of structure that was built, or before the first stone stands was ordered.
[[nodiscard]] std::string structure_name(const RunReport& report);
/// "Wall of 3".
[[nodiscard]] std::string run_title(const RunReport& report);
/// Figures of a wall as JSON.
[[nodiscard]] nlohmann::json wall_figures(const WallMetrics& metrics);
/// Text of the figures in lines; the last has no line end.
[[nodiscard]] std::string wall_figures_text(const WallMetrics& metrics);

/// The document as a command prints it.
[[nodiscard]] inline std::string document(const nlohmann::json& json, int indent = 2) {
  return json.dump(indent) + "\n";
}

}  // namespace stonestack::report
