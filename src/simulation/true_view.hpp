#pragma once
#include "simulation/true_world.hpp"
#include "stonestack/simulation/sensor_noise.hpp"

namespace stonestack {

/// The sensor that the options ask for; without noise only its range, counts and intrinsics are left.
[[nodiscard]] SensorModel choose_sensor(const SimulationOptions& options);

/// Table, full-resolution stones and hand as the sensor at T_W_C reports them.
[[nodiscard]] DepthImage true_view(const TrueWorld& world, const std::vector<Stone>& stones,
                                   const Pose& T_W_C, const SensorModel& sensor, Random& random);

}  // namespace stonestack
