#pragma once
#include "simulation/sensor_noise.hpp"
#include "simulation/true_world.hpp"

namespace stonestack::simulation {

/// The sensor that the options ask for, with the lens that it has and the intrinsics that it reports; without
/// noise only these, its range and its counts are left.
[[nodiscard]] SensorModel choose_sensor(const SimulationOptions& options);

/// Where everything that can be seen stands, so that a picture can be taken while the world goes on.
struct SeenWorld {
  Mesh table;                                           ///< in W
  std::vector<std::pair<StoneIndex, Pose>> stones;      ///< index and T_W_O
  std::vector<std::pair<Eigen::Vector3d, Pose>> boxes;  ///< size and pose
};
[[nodiscard]] SeenWorld what_is_seen(const TrueWorld& world);

/// Table, full-resolution stones and gripper as the sensor at T_W_C reports them.
[[nodiscard]] DepthImage true_view(const SeenWorld& world, const std::vector<Stone>& stones,
                                   const Pose& T_W_C, const SensorModel& sensor, Random& random);

}  // namespace stonestack::simulation
