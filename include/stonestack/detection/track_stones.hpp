#pragma once
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "stonestack/detection/detect_stones.hpp"

#pragma GCC visibility push(default)

namespace stonestack::detection {

/// Present state of a stone that was placed before.
struct TrackedStone {
  /// State of a stone against its expected pose.
  enum class Status {
    kInPlace,  ///< where it was
    kMoved,    ///< seen elsewhere, by the distance `moved`
    kFallen,   ///< seen elsewhere and lower
    kUnseen,   ///< hidden, or gone
  };
  StoneIndex stone = kNoStone;         ///< index into the models
  Status status = Status::kUnseen;     ///< state of the stone in the image
  std::optional<Detection> detection;  ///< empty with kUnseen
  PoseDifference moved;                ///< from where it was; of the bounding sphere's centre
};
[[nodiscard]] std::string to_text(TrackedStone::Status status);

/// Present state of all of them.
struct TrackResult {
  std::vector<TrackedStone> stones;  ///< one entry an expected stone, in their order
  std::string note;                  ///< why the search found none of those that are not there, for a person
};

/// When a stone counts as moved or fallen.
struct TrackOptions {
  double moved_shift = 0.003;  ///< [m]
  double fallen_drop = 0.015;  ///< of the centre, towards the table [m]
};
[[nodiscard]] FieldList fields(TrackOptions& options);

/// Refines every expected stone from its last pose (track_stone); those that are not there are searched for
/// in the rest of the scene. A stone that is expected several times is searched for in as many copies. Stones
/// of `known` (for example held ones) are neither searched nor allowed to explain anything else.
[[nodiscard]] TrackResult track_stones(const DepthImage& image, const DetectionModels& models,
                                       std::span<const KnownStone> expected,
                                       const DetectionOptions& options = {}, const SceneKnowledge& known = {},
                                       const TrackOptions& limits = {});

}  // namespace stonestack::detection

#pragma GCC visibility pop
