#pragma once
#include <optional>
#include <string>
#include <vector>

#include "stonestack/geometry/depth_image.hpp"
#include "stonestack/geometry/obstacle.hpp"
#include "stonestack/geometry/pose.hpp"

#pragma GCC visibility push(default)

namespace stonestack::stone {

/// A stone in a scene file, by name.
struct NamedPose {
  std::string stone;              ///< name of the stone in its catalogue
  Pose T_W_O = Pose::Identity();  ///< pose of the stone
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
///   wall: [{stone: limestone_3, T_W_O: {...}}]   # instead of a stack: in the order in which it is built
///   stones:                                      # loose
///     - {stone: limestone_2, T_W_O: {...}}
///   obstacles: [{name: wall, box: {x: 0.02, y: 2, z: 1.5}, T_W_O: {...}}]  # parse_obstacles
///   padding: [{a: arm, b: wall, m: 0.05}]  # parse_pair_paddings
///
/// Every key but `schema` may be missing.
struct SceneFile {
  std::optional<CameraIntrinsics> camera;  ///< intrinsics of the depth image
  std::optional<Pose> T_W_C;               ///< pose of the camera
  std::string depth_file;                  ///< path, resolved against the scene file; empty: none
  double depth_unit = 0.0;                 ///< metres per count
  std::string cloud_file;           ///< path of the cloud, resolved against the scene file; empty: none
  std::vector<NamedPose> stack;     ///< stones of the stack, from the table up
  std::vector<NamedPose> wall;      ///< stones of a wall in the order in which it is built; not with a stack
  std::vector<NamedPose> stones;    ///< loose stones
  std::vector<Obstacle> obstacles;  ///< read, never written
  std::vector<PairPadding> paddings;  ///< the same
};

/// Throws FileError naming file, key and value: also for poses that are not finite or not rotations, unknown
/// keys.
[[nodiscard]] SceneFile read_scene_file(const std::string& path);
/// Depth and cloud files are written as given (relative paths stay relative). T_C_O is added to stones when
/// T_W_C is known.
void write_scene_file(const std::string& path, const SceneFile& scene);

/// A view that came from a file: the frame, and where the camera stood if that is known.
struct SceneView {
  DepthImage image;           ///< depth image, or a cloud turned into one
  std::optional<Pose> T_W_C;  ///< pose of the camera, if it is known
  bool world = false;         ///< of a cloud in W: no camera took it, T_W_C is one that is put above it
};

/// Data that a depth image, a recording or a cloud does not contain, as a user writes it.
struct DepthInput {
  double unit = 0.0;        ///< one count [m]; 0: it must stand in the files
  std::string camera;       ///< fx,fy,cx,cy
  std::string distortion;   ///< none, brown_conrady:k1,k2,p1,p2,k3 or inverse_brown_conrady:...
  int frame = 0;            ///< of a recording
  std::string units = "m";  ///< of a cloud's coordinates: m, cm, mm
  /// Kind of the depth camera: a name of data/sensors or a file of that form. Depths outside its range are
  /// left out; a depth PNG that comes without them has its count and its nominal lens. Empty: not said.
  std::string sensor;
};

/// A depth view from a scene file (depth image or cloud in it), a 16-bit depth PNG, a recording (folder in
/// the layout of BOP, Open3D or TUM), or from a cloud (PLY, PCD). A cloud is in the camera frame, unless
/// `world` says otherwise or it cannot be: not organised like a depth camera's, no `camera_pose` given, and
/// most of it within 10 cm of z = 0 (a table there).
/// @param camera_pose as `parse_pose` reads it; empty: that of the file, if it has one.
/// @throws FileError, also for a mirrored cloud and for one that lies behind the camera (OpenGL's axes), and
/// InvalidArgument for a part of `depth` that this kind of file has no use for.
[[nodiscard]] SceneView read_view(const std::string& path, const std::string& camera_pose, bool world = false,
                                  const DepthInput& depth = {});

/// Refuses a cloud that was taken as in W and whose table, seen from the camera above it, leans: its z does
/// not point up.
/// @throws FileError.
void check_level(const SceneView& view, const std::optional<Plane>& table_C, const std::string& path);

/// True for .yaml and .yml.
[[nodiscard]] bool is_scene_file(const std::string& path);

/// The parts of "a,b,c"; one empty part for an empty text.
[[nodiscard]] std::vector<std::string> split_list(const std::string& text);
/// `count` finite numbers with commas between; `form` says in errors what they are.
/// @throws InvalidArgument.
[[nodiscard]] std::vector<double> parse_numbers(const std::string& text, std::size_t count, const char* form);
/// "x,y,z,qx,qy,qz,qw", or the path of a scene file with T_W_C.
/// @throws InvalidArgument, FileError.
[[nodiscard]] Pose parse_pose(const std::string& text);
/// "x,y". @throws InvalidArgument.
[[nodiscard]] Eigen::Vector2d parse_point(const std::string& text);

}  // namespace stonestack::stone

#pragma GCC visibility pop
