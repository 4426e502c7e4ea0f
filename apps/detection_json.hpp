#pragma once
#include <nlohmann/json.hpp>
#include <optional>

#include "rooms.hpp"
#include "stonestack/detection/detect_stones.hpp"
#include "stonestack/stone/catalogue.hpp"

namespace stonestack::apps {

/// A detection as `detect` and `track` print it: stone, T_C_O, score, inlier_ratio, visible, covariance_C
/// (six rows of translation m, rotation rad), and T_W_O if the camera's pose is known.
[[nodiscard]] nlohmann::json detection_json(const Catalogue& catalogue, const Detection& found,
                                            const std::optional<Pose>& T_W_C);

}  // namespace stonestack::apps
