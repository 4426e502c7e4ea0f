#pragma once
#include <optional>

#include "stonestack/geometry/depth_image.hpp"

#pragma GCC visibility push(default)

namespace stonestack::geometry {

/// Pinhole intrinsics that explain an organised cloud in C (least squares of u on x/z and of v on y/z). Empty
/// for a cloud that is not organised, has fewer than 100 points, or does not fit a pinhole within a pixel
/// (median).
[[nodiscard]] std::optional<CameraIntrinsics> fit_camera(const Cloud& organised_C);

/// A pinhole camera for a cloud in C without rows: wide enough for all but a hundredth of the points (up to
/// 56 deg off the axis), its pixels far enough apart for the points to fill them: 475 px of focal length, or
/// as much less, down to a sixth, as a thinned cloud needs.
[[nodiscard]] CameraIntrinsics camera_for(const Cloud& cloud_C);

/// True for an organised cloud of which one image axis, but not both, runs against x or y: it shows things as
/// a mirror would.
[[nodiscard]] bool is_mirrored(const Cloud& organised_C);

}  // namespace stonestack::geometry

#pragma GCC visibility pop
