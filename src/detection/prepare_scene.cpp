#include "detection/prepare_scene.hpp"

#include <algorithm>

#include "detection/scene/supports.hpp"

namespace stonestack::detection {

DetectionScene prepare_scene(DetectionScene scene, const DetectionModels::Data& data,
                             const DetectionOptions& options, const SceneKnowledge& known) {
  if (scene.clusters == 0) return scene;
  scene = without_stones(std::move(scene), data, known.stones);
  if (known.table_C) return scene;  // a cell's table: there is no furniture on it
  double longest = 0.0;
  for (const auto& model : data.models) longest = std::max(longest, 2.0 * model.radius);
  return without_large_planes(std::move(scene), longest, options.seed);
}

}  // namespace stonestack::detection
