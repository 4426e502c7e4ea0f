#pragma once
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "detection_scenes.hpp"
#include "result_table.hpp"
#include "rooms.hpp"

/// Counts of `stonestack-bench detection`.
namespace stonestack::bench {

/// Counts and samples of one method on one kind of scene.
struct DetectionTally {
  int scenes = 0, present = 0, right = 0, wrong = 0, absent = 0, false_accepts = 0, calibrated = 0;
  std::vector<double> degrees, millimetres, chi2, right_scores, bad_scores;
  double wall = 0, cpu = 0;  ///< time of all scenes, s
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(DetectionTally, scenes, present, right, wrong, absent, false_accepts,
                                   calibrated, degrees, millimetres, chi2, right_scores, bad_scores, wall,
                                   cpu)
/// Adds the counts and samples of other scenes.
void add(DetectionTally& sum, const DetectionTally& more);

/// Compares what was found with the truth. Right: within 5 deg and 5 mm. A stone counts as present if the
/// kind's share of what faces the first camera is not hidden. `list` gets a note of every detection, miss and
/// false accept; null: none.
void judge(const DetectionResult& result, const BenchScene& scene, const SceneKind& kind, std::size_t models,
           Results* list, DetectionTally& tally);

/// Columns of a row: one method on one kind of scene.
[[nodiscard]] std::vector<Column> detection_columns();
[[nodiscard]] std::vector<TableValue> detection_cells(const std::string& method, const std::string& kind,
                                                      const DetectionTally& tally);

}  // namespace stonestack::bench
