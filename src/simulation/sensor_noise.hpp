#pragma once
#include "geometry/depth_render.hpp"
#include "geometry/sensor_model.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::simulation {

/// The image that the sensor reports of a perfect view taken from T_W_C. Order of effects: no return at
/// grazing angles, shadow, edges (jitter, flying pixels, holes), bias, noise, holes and blobs, range, steps
/// of disparity, counts.
[[nodiscard]] DepthImage add_noise(const RenderedView& view, const Pose& T_W_C, const SensorModel& model,
                                   Random& random);

}  // namespace stonestack::simulation
