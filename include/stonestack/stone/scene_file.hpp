#pragma once
#include <optional>
#include <string>
#include <vector>

#include "stonestack/geometry/depth_image.hpp"
#include "stonestack/geometry/obstacle.hpp"

#pragma GCC visibility push(default)

namespace stonestack::stone {

/// A stone in a scene file, by name.
struct NamedPose {
  std::string stone;
  Pose T_W_O = Pose::Identity();
};

/// A scene in a file: what stands, what lies loose, and how it was seen. YAML, schema "stonestack.scene/1":
///
///   schema: stonestack.scene/1
///   camera: {width: 640, height: 480, fx: 475, fy: 475, cx: 319.5, cy: 239.5,
///            distortion: none, k: [0, 0, 0, 0, 0]}
///   T_W_C: {x: 0.7, y: -0.18, z: 0.7, qx: 1, qy: 0, qz: 0, qw: 0}
///   depth: {file: depth.png, unit: 0.000125}     # metres a count; files are beside the scene file
///   cloud: cloud.ply                             # organised, camera frame
///   stack:                                       # from the table up
///     - {stone: limestone_1, T_W_O: {x: 0.7, y: 0.28, z: 0.05, qx: 0, qy: 0, qz: 0, qw: 1}}
///   stones:                                      # loose
///     - {stone: limestone_2, T_W_O: {...}}
///   obstacles: [{name: wall, box: {x: 0.02, y: 2, z: 1.5}, T_W_O: {...}}]  # parse_obstacles
///   padding: [{a: arm, b: wall, m: 0.05}]  # parse_pair_paddings
///
/// Every key but `schema` may be missing.
struct SceneFile {
  std::optional<CameraIntrinsics> camera;
  std::optional<Pose> T_W_C;
  std::string depth_file;   ///< path, resolved against the scene file; empty: none
  double depth_unit = 0.0;  ///< metres per count
  std::string cloud_file;
  std::vector<NamedPose> stack;
  std::vector<NamedPose> stones;
  std::vector<Obstacle> obstacles;    ///< read, never written
  std::vector<PairPadding> paddings;  ///< the same
};

/// Throws FileError naming file, key and value: also for poses that are not finite or not rotations, unknown
/// keys.
[[nodiscard]] SceneFile read_scene_file(const std::string& path);
/// Depth and cloud files are written as given (relative paths stay relative). T_C_O is added to stones when
/// T_W_C is known.
void write_scene_file(const std::string& path, const SceneFile& scene);

}  // namespace stonestack::stone

#pragma GCC visibility pop
