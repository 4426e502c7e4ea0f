#pragma once
#include <functional>
#include <string>

#include "stonestack/hardware/devices.hpp"

/// Private to hardware/: what drivers of force sensors have in common.
namespace stonestack::hardware {

/// Throws DeviceError that names the sensor when a force or torque on an axis reaches its limit (N, Nm).
void require_in_range(const std::string& sensor, const Wrench& wrench, double max_force, double max_torque);

/// Mean of the next `kZeroSamples` readings; `next` returns one that was not returned before.
/// @throws DeviceError that names the sensor when they spread too far or come too slowly.
[[nodiscard]] Wrench mean_at_rest(const std::string& sensor, const std::function<Wrench()>& next);

}  // namespace stonestack::hardware
