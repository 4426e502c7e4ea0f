#pragma once
#include <string>
#include <vector>

#include "rooms.hpp"
#include "detection_scenes.hpp"

/// Counts of `bench detection`.
namespace stonestack::bench {

/// Counts and samples of one method on one kind of scene.
struct DetectionTally {
  int scenes = 0, present = 0, right = 0, wrong = 0, absent = 0, false_accepts = 0, calibrated = 0;
  std::vector<double> degrees, millimetres, chi2, right_scores, bad_scores;
  double wall = 0, cpu = 0;  ///< s, all scenes
};

/// Compares what was found with the truth. Right: within 5 deg and 5 mm. A stone counts as present if the
/// kind's share of what faces the first camera is not hidden. With `list`, prints every detection, miss and
/// false accept.
void judge(const DetectionResult& result, const BenchScene& scene, const SceneKind& kind, int models,
           bool list, DetectionTally& tally);

void print_heading();
void print_row(const std::string& method, const std::string& kind, const DetectionTally& tally);

}  // namespace stonestack::bench
