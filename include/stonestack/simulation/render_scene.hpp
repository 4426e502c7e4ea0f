#pragma once
#include <string>
#include <vector>

#include "stonestack/geometry/depth_image.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stone/stone.hpp"

#pragma GCC visibility push(default)

namespace stonestack::simulation {

/// Pose of the camera of a rendered scene: its axis passes through the middle of the field.
struct SceneOptions {
  SimulationOptions simulation;  ///< options of the simulated world
  double distance = 0.7;         ///< distance [m] from the camera to the viewed point
  double tilt = 0.174533;        ///< angle [rad] off the vertical (10 deg)
};
/// Without those of `simulation`, which have a list of their own.
[[nodiscard]] FieldList fields(SceneOptions& options);

/// A view of stones on a table, with the truth about it.
struct SimulatedScene {
  DepthImage depth;                 ///< depth image as the sensor gives it
  double depth_unit = 0.0;          ///< metres per count
  Pose T_W_C = Pose::Identity();    ///< true pose of the camera
  std::vector<PlacedStone> stones;  ///< true poses T_W_O
};

/// Scatters the stones `present` in the layout's field and takes one picture. Same seed, same scene.
[[nodiscard]] SimulatedScene render_scene(const std::vector<Stone>& stones,
                                          const std::vector<StoneIndex>& present, const CellLayout& layout,
                                          const SceneOptions& options = {});

/// Writes depth.png (16 bit), cloud.ply (organised, camera frame) and scene.yaml (intrinsics, T_W_C, stones
/// with T_W_O and T_C_O) into the folder.
/// @throws FileError
void write_scene(const std::string& folder, const SimulatedScene& scene, const std::vector<Stone>& stones);

}  // namespace stonestack::simulation

#pragma GCC visibility pop
