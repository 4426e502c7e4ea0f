#pragma once
#include <optional>

#include "stonestack/geometry/depth_image.hpp"

namespace stonestack {

/// Pinhole intrinsics that explain an organised cloud in C (least squares of u on x/z and of v on y/z). Empty
/// for a cloud that is not organised, has fewer than 100 points, or does not fit a pinhole within a pixel
/// (median).
[[nodiscard]] std::optional<CameraIntrinsics> fit_camera(const Cloud& organised_C);

/// True for an organised cloud of which one image axis, but not both, runs against x or y: it shows things as
/// a mirror would.
[[nodiscard]] bool is_mirrored(const Cloud& organised_C);

}  // namespace stonestack
