#pragma once
#include <CLI/CLI.hpp>
#include <optional>
#include <string>
#include <vector>

#include "rooms.hpp"
#include "stonestack/geometry/depth_image.hpp"
#include "stonestack/geometry/pose.hpp"
#include "stonestack/stone/scene_file.hpp"

namespace stonestack::apps {

/// A view that came from a file: the frame, and where the camera stood if that is known.
struct SceneView {
  DepthImage image;
  std::optional<Pose> T_W_C;
  bool world = false;  ///< of a cloud in W: no camera took it, T_W_C is one that is put above it
};

/// Data that a depth image, a recording or a cloud does not contain.
struct DepthInput {
  double unit = 0.0;        ///< metres per count; 0: it must stand in the files
  std::string camera;       ///< fx,fy,cx,cy
  std::string distortion;   ///< none, brown_conrady:k1,k2,p1,p2,k3 or inverse_brown_conrady:...
  int frame = 0;            ///< of a recording
  std::string units = "m";  ///< of a cloud's coordinates: m, cm, mm
};
/// --depth-unit, --camera, --distortion, --frame, --units.
void register_depth_input(CLI::App& command, DepthInput& input);

/// `count` finite numbers with commas between; `form` says in errors what they are. Throws InvalidArgument.
[[nodiscard]] std::vector<double> parse_numbers(const std::string& text, std::size_t count, const char* form);
/// "x,y,z,qx,qy,qz,qw", or the path of a scene file with T_W_C. Throws InvalidArgument or FileError.
[[nodiscard]] Pose parse_pose(const std::string& text);
/// "x,y".
[[nodiscard]] Eigen::Vector2d parse_point(const std::string& text);

/// A depth view from a scene file (depth image or cloud in it), a 16-bit depth PNG, a recording (folder in
/// the layout of BOP, Open3D or TUM), or from a cloud (PLY, PCD). A cloud is in the camera frame, unless
/// `world` says otherwise or it cannot be: not organised like a depth camera's, no `camera_pose` given, and
/// most of it within 10 cm of z = 0 (a table there). Throws FileError, also for a mirrored cloud and for one
/// that lies behind the camera (OpenGL's axes), and InvalidArgument for a part of `depth` that this kind of
/// file has no use for.
[[nodiscard]] SceneView read_view(const std::string& path, const std::string& camera_pose, bool world = false,
                                  const DepthInput& depth = {});

/// Throws FileError for a cloud that was taken as in W and whose table, seen from the camera above it, leans:
/// its z does not point up.
void check_level(const SceneView& view, const std::optional<Plane>& table_C, const std::string& path);

/// Throws FileError unless a file or folder of that name is there and may be read: for a check before shapes
/// are built, which takes seconds.
void require_readable(const std::string& path);

/// True for .yaml and .yml.
[[nodiscard]] bool is_scene_file(const std::string& path);

/// The parts of "a,b,c".
[[nodiscard]] std::vector<std::string> split(const std::string& list, char separator);

}  // namespace stonestack::apps
