#include "search/detect_missing.hpp"

#include <algorithm>

namespace stonestack::search {
namespace {

constexpr double kAcceptScore = 0.75;  // design choice; measured: bench site

}  // namespace

DetectionResult detect_missing(const DepthImage& image, const DetectionModels& models,
                               const DetectionResult& first, const DetectionOptions& options) {
  SceneKnowledge known;
  known.table_C = first.table_C;
  for (const Detection& found : first.detections) known.stones.push_back({found.stone, found.T_C_O});
  DetectionOptions lenient = options;
  lenient.accept_score = std::min(options.accept_score, kAcceptScore);
  const DetectionResult more = detect_stones(image, models, {}, lenient, known);
  DetectionResult all = first;
  all.detections.insert(all.detections.end(), more.detections.begin(), more.detections.end());
  return all;
}

}  // namespace stonestack::search
