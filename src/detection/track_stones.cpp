#include "stonestack/detection/detect_stones.hpp"

#include <algorithm>

#include "detection/constants.hpp"
#include "detection/features/models.hpp"

namespace stonestack::detection {
namespace {

/// How a stone differs from where it was; `up_C` is the table's normal, zero if no table is seen.
void compare(TrackedStone& tracked, const Pose& before, const Eigen::Vector3d& centre_O,
             const Eigen::Vector3d& up_C, const TrackOptions& limits) {
  const Pose& now = tracked.detection->T_C_O;
  const Eigen::Vector3d shift = now * centre_O - before * centre_O;
  tracked.moved = {shift.norm(), difference(before, now).angle};
  const bool same = tracked.moved.translation < limits.moved_shift && tracked.moved.angle < kMovedTurn;
  const bool lower = -up_C.dot(shift) > limits.fallen_drop;
  tracked.status = same    ? TrackedStone::Status::kInPlace
                   : lower ? TrackedStone::Status::kFallen
                           : TrackedStone::Status::kMoved;
}

/// Gives a stone that was found elsewhere to the nearest place that misses it; one too many is nobody's.
void give(std::vector<TrackedStone>& all, std::span<const KnownStone> expected, const Detection& d) {
  TrackedStone* to = nullptr;
  double nearest = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i].stone != d.stone || all[i].detection) continue;
    const double away = difference(expected[i].T_C_O, d.T_C_O).translation;
    if (to == nullptr || away < nearest) to = &all[i], nearest = away;
  }
  if (to != nullptr) to->detection = d;
}

/// The missing stones, each named as often as it is expected: so many copies there are.
std::vector<StoneIndex> to_search(const std::vector<TrackedStone>& all) {
  std::vector<StoneIndex> wanted;
  for (const auto& t : all)
    if (std::any_of(all.begin(), all.end(),
                    [&](const TrackedStone& other) { return other.stone == t.stone && !other.detection; }))
      wanted.push_back(t.stone);
  return wanted;
}

}  // namespace

FieldList fields(TrackOptions& o) {
  return {
      user(field("moved_shift", o.moved_shift, {1e-4, 0.1}, "m",
                 "stones that moved further are reported as moved; several times the error of a pose")),
      field("fallen_drop", o.fallen_drop, {1e-3, 1}, "m", "moved stones that are so much lower have fallen"),
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

TrackResult track_stones(const DepthImage& image, const DetectionModels& models,
                         std::span<const KnownStone> expected, const DetectionOptions& options,
                         const SceneKnowledge& known, const TrackOptions& limits) {
  TrackResult out;
  auto& all = out.stones;
  SceneKnowledge rest = known;
  for (const auto& e : expected) {
    TrackedStone tracked{e.stone, TrackedStone::Status::kUnseen, {}, {}};
    tracked.detection = track_stone(image, models, e.stone, e.T_C_O, options, known);
    if (tracked.detection) rest.stones.push_back({e.stone, tracked.detection->T_C_O});
    all.push_back(tracked);
  }
  std::optional<Plane> table_C = known.table_C;
  if (const auto wanted = to_search(all); !wanted.empty()) {
    const DetectionResult result = detect_stones(image, models, wanted, options, rest);
    out.note = result.note;
    if (result.table_C) table_C = result.table_C;
    for (const auto& d : result.detections) give(all, expected, d);
  }
  const bool sees_any =
      std::any_of(all.begin(), all.end(), [](const TrackedStone& t) { return t.detection.has_value(); });
  if (!table_C && sees_any) table_C = find_table(image, options);
  const Eigen::Vector3d up_C = table_C ? table_C->normal : Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < all.size(); ++i)
    if (all[i].detection)
      compare(all[i], expected[i].T_C_O, at(models.data().models, all[i].stone).centre, up_C, limits);
  return out;
}

}  // namespace stonestack::detection
