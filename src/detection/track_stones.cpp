#include "stonestack/detection/track_stones.hpp"

#include <algorithm>

#include "detection/models.hpp"
#include "detection/preprocess.hpp"

namespace stonestack {
namespace {

/// How a stone differs from where it was; `up_C` is the table's normal, zero if no table is seen.
void compare(TrackedStone& tracked, const Pose& before, const Eigen::Vector3d& centre_O,
             const Eigen::Vector3d& up_C, const TrackOptions& limits) {
  const Pose& now = tracked.detection->T_C_O;
  const Eigen::Vector3d shift = now * centre_O - before * centre_O;
  tracked.moved = {shift.norm(), difference(before, now).angle};
  const bool same = tracked.moved.translation < limits.moved_shift && tracked.moved.angle < limits.moved_turn;
  const bool lower = -up_C.dot(shift) > limits.fallen_drop;
  tracked.status = same    ? TrackedStone::Status::kInPlace
                   : lower ? TrackedStone::Status::kFallen
                           : TrackedStone::Status::kMoved;
}

}  // namespace

FieldList fields(TrackOptions& o) {
  return {
      field("moved_shift", o.moved_shift, {1e-4, 0.1}, "m", "ours: several times the error of a pose"),
      field("moved_turn", o.moved_turn, {1e-3, 1}, "rad", "ours"),
      field("fallen_drop", o.fallen_drop, {1e-3, 1}, "m", "ours"),
  };
}

std::string to_text(TrackedStone::Status status) {
  switch (status) {
    case TrackedStone::Status::kInPlace:
      return "in place";
    case TrackedStone::Status::kMoved:
      return "moved";
    case TrackedStone::Status::kFallen:
      return "fallen";
    case TrackedStone::Status::kUnseen:
      return "unseen";
  }
  return "unknown";
}

std::vector<TrackedStone> track_stones(const DepthImage& image, const DetectionModels& models,
                                       std::span<const KnownStone> expected, const DetectionOptions& options,
                                       const SceneKnowledge& known, const TrackOptions& limits) {
  std::vector<TrackedStone> all;
  SceneKnowledge rest = known;
  std::vector<int> missing;
  for (const auto& e : expected) {
    TrackedStone tracked{e.stone, TrackedStone::Status::kUnseen, {}, {}};
    tracked.detection = track_stone(image, models, e.stone, e.T_C_O, options, known);
    if (tracked.detection)
      rest.stones.push_back({e.stone, tracked.detection->T_C_O});
    else
      missing.push_back(e.stone);
    all.push_back(tracked);
  }
  std::optional<Plane> table_C = known.table_C;
  if (!missing.empty()) {
    const DetectionResult result = detect_stones(image, models, missing, options, rest);
    if (result.table_C) table_C = result.table_C;
    for (const auto& d : result.detections)
      std::find_if(all.begin(), all.end(), [&](const TrackedStone& t) {
        return t.stone == d.stone && !t.detection;
      })->detection = d;
  }
  if (!table_C) table_C = preprocess(image, {}, true, options).table_C;
  const Eigen::Vector3d up_C = table_C ? table_C->normal : Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < all.size(); ++i)
    if (all[i].detection)
      compare(all[i], expected[i].T_C_O, models.data().models[static_cast<std::size_t>(all[i].stone)].centre,
              up_C, limits);
  return all;
}

}  // namespace stonestack
