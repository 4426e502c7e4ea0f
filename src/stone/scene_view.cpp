#include "stonestack/stone/scene_file.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "geometry/depth_sequence.hpp"
#include "geometry/sensor_model.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/geometry/cloud.hpp"
#include "stonestack/geometry/depth_image.hpp"

namespace stonestack::stone {
namespace {

constexpr float kAboutTable = 0.10F;   // m from z = 0: where most of a world-frame cloud lies
constexpr double kBehind = 0.01;       // share of points behind the camera that noise may explain
constexpr double kCameraHeight = 0.8;  // m above the middle of a world-frame cloud
constexpr double kMaxTilt = 0.35;      // rad, of the table in W: more is another frame

/// A camera that looks straight down on a cloud in W.
Pose camera_above(const Cloud& cloud_W) {
  Eigen::AlignedBox3f box;
  for (const auto& p : cloud_W.points) box.extend(p);
  Pose T_W_C = Pose::Identity();
  T_W_C.linear() = Eigen::Vector3d(1, -1, -1).asDiagonal();
  const Eigen::Vector3d centre = box.center().cast<double>();
  T_W_C.translation() = Eigen::Vector3d(centre.x(), centre.y(), box.max().z() + kCameraHeight);
  return T_W_C;
}

/// A camera sees nothing nearer than 10 cm; a table at z = 0 has most of a cloud nearer than that to z = 0.
bool in_world_frame(const Cloud& solid) {
  const auto near = std::count_if(solid.points.begin(), solid.points.end(),
                                  [](const Eigen::Vector3f& p) { return std::abs(p.z()) < kAboutTable; });
  return 2 * static_cast<std::size_t>(near) > solid.points.size();
}

/// Refuses a cloud that no camera at its origin, looking along z, can have seen.
void refuse_behind_camera(const Cloud& cloud, const std::string& path) {
  float lowest = std::numeric_limits<float>::infinity(), highest = -lowest;
  std::size_t behind = 0, all = 0;
  for (const auto& p : cloud.points) {
    if (!p.allFinite()) continue;
    lowest = std::min(lowest, p.z()), highest = std::max(highest, p.z());
    behind += p.z() <= 0.0F ? 1 : 0;
    ++all;
  }
  if (static_cast<double>(behind) <= kBehind * static_cast<double>(all)) return;
  const std::string range = concat("z runs from ", 0.01 * std::round(100.0 * lowest), " to ",
                                   0.01 * std::round(100.0 * highest), " m");
  if (behind == all)
    throw FileError(path,
                    concat("lies behind the camera: ", range, "; its axes are OpenGL's (y up, z backwards)"),
                    "change the sign of y and z, which gives the optical frame (x right, y down, z forward)");
  throw FileError(
      path,
      concat("is neither in the camera's frame nor in the world's: ", range, ", ",
             std::lround(100.0 * static_cast<double>(behind) / static_cast<double>(all)),
             " % of it behind the camera, and most of it not about z = 0"),
      "give it in the camera's optical frame (x right, y down, z forward), or with z up and the table "
      "at z = 0");
}

/// A cloud in metres.
Cloud cloud_in(const std::string& path, const DepthInput& input) {
  require(input.unit == 0.0 && input.camera.empty() && input.distortion.empty() && input.frame == 0, path,
          " is a cloud: --depth-unit, --camera, --distortion and --frame are for depth PNGs and recordings");
  Cloud cloud = read_cloud(path);
  const float metres = input.units == "mm" ? 1e-3F : input.units == "cm" ? 1e-2F : 1.0F;
  for (auto& p : cloud.points) p *= metres;
  return cloud;
}

void refuse_mirrored(const Cloud& cloud, const std::string& path) {
  if (is_mirrored(cloud))
    throw FileError(path, "is mirrored: x or y runs against the image",
                    "export it right-handed (x right, y down, z forward); no stone fits its mirror image");
}

SceneView view_of_cloud(const std::string& path, const std::string& camera_pose, bool world,
                        const DepthInput& input) {
  const Cloud cloud = cloud_in(path, input);
  const Cloud solid = without_gaps(cloud);
  if (solid.points.empty()) throw FileError(path, "has no finite point", "record the scene again");
  SceneView view;
  const auto camera = fit_camera(cloud);
  if (!world) refuse_mirrored(cloud, path);
  if (world || (camera_pose.empty() && !camera && in_world_frame(solid))) {
    if (!world) log_info(path + ": most of it lies about z = 0; taken as in the world frame");
    view.world = true;
    view.T_W_C = camera_pose.empty() ? camera_above(solid) : parse_pose(camera_pose);
    const Cloud cloud_C = transformed(solid, view.T_W_C->inverse());
    view.image = to_depth_image(cloud_C, camera_for(cloud_C));
  } else {
    refuse_behind_camera(solid, path);
    if (!camera_pose.empty()) view.T_W_C = parse_pose(camera_pose);
    view.image = to_depth_image(cloud, camera ? *camera : camera_for(cloud));
  }
  return view;
}

/// The camera with the lens distortion that was given, if any was.
CameraIntrinsics with_distortion(CameraIntrinsics camera, const DepthInput& input) {
  const auto colon = input.distortion.find(':');
  const std::string kind = input.distortion.substr(0, colon);
  if (kind.empty()) return camera;
  camera.distortion = CameraIntrinsics::Distortion::kNone;
  if (kind == "none") return camera;
  require(kind == "brown_conrady" || kind == "inverse_brown_conrady", "distortion '", kind,
          "' is none of none, brown_conrady and inverse_brown_conrady");
  require(colon != std::string::npos, "distortion '", input.distortion, "' lacks :k1,k2,p1,p2,k3");
  camera.distortion = kind == "brown_conrady" ? CameraIntrinsics::Distortion::kBrownConrady
                                              : CameraIntrinsics::Distortion::kInverseBrownConrady;
  const auto k = parse_numbers(input.distortion.substr(colon + 1), 5, "k1,k2,p1,p2,k3");
  std::copy(k.begin(), k.end(), camera.k);
  return camera;
}

/// "fx,fy,cx,cy", and distortion if given; without a size.
CameraIntrinsics parse_camera(const DepthInput& input) {
  const auto v = parse_numbers(input.camera, 4, "fx,fy,cx,cy");
  CameraIntrinsics camera;
  camera.fx = v[0], camera.fy = v[1], camera.cx = v[2], camera.cy = v[3];
  require(camera.fx > 1 && camera.fy > 1, "the focal length in '", input.camera, "' is in pixels");
  return with_distortion(camera, input);
}

SceneView view_of_picture(const std::string& path, const DepthInput& input) {
  require(input.frame == 0, path, " is one picture: --frame is for recordings");
  if (input.camera.empty() && input.sensor.empty())
    throw FileError(path, "comes without the camera's intrinsics",
                    "give --camera fx,fy,cx,cy, or --sensor for a nominal lens");
  if (input.unit == 0.0 && input.sensor.empty())
    throw FileError(path, "does not say how many metres a count is",
                    "give --sensor, or --depth-unit (SR300: 0.000125, D435: 0.001)");
  const Eigen::Vector2i size = png_size(path);
  const double unit = input.unit > 0.0 ? input.unit : geometry::read_sensor(input.sensor).unit;
  CameraIntrinsics camera;
  if (input.camera.empty()) {
    camera = with_distortion(geometry::nominal_lens(geometry::read_sensor(input.sensor), size.x(), size.y()),
                             input);
    log_warning(concat(path, ": the nominal lens of ", input.sensor, " is assumed (--camera ", camera.fx, ",",
                       camera.fy, ",", camera.cx, ",", camera.cy, "); a camera's own differs by a percent"));
  } else {
    camera = parse_camera(input);
  }
  camera.width = size.x(), camera.height = size.y();
  check_principal_point(camera, path);
  return {read_depth_png(path, camera, unit), std::nullopt};
}

SceneView view_of_recording(const std::string& folder, const DepthInput& input) {
  DepthSequenceInput given;
  given.unit = input.unit;
  if (!input.camera.empty()) given.camera = parse_camera(input);
  const DepthSequence sequence = read_depth_sequence(folder, given);
  require(input.frame >= 0 && input.frame < static_cast<int>(sequence.records.size()), folder, " has ",
          sequence.records.size(), " frames, counted from 0; there is no ", input.frame);
  DepthRecord record = sequence.records[static_cast<std::size_t>(input.frame)];
  record.camera = with_distortion(record.camera, input);
  check_principal_point(record.camera, record.path);
  return {read_depth(record), record.T_W_C};
}

/// Any kind of file, with all of its depths.
SceneView whole_view(const std::string& path, const std::string& camera_pose, bool world,
                     const DepthInput& depth) {
  const bool folder = std::filesystem::is_directory(path);
  const bool cloud_file =
      !folder && !is_scene_file(path) && std::filesystem::path(path).extension() != ".png";
  require(cloud_file || depth.units == "m", path, " is no cloud: --units is of a cloud's coordinates");
  if (folder || std::filesystem::path(path).extension() == ".png") {
    SceneView view = folder ? view_of_recording(path, depth) : view_of_picture(path, depth);
    if (!camera_pose.empty()) view.T_W_C = parse_pose(camera_pose);
    return view;
  }
  if (cloud_file) return view_of_cloud(path, camera_pose, world, depth);
  require(depth.unit == 0.0 && depth.camera.empty() && depth.distortion.empty() && depth.frame == 0, path,
          " says itself what its camera is: --depth-unit, --camera, --distortion and --frame are not for it");
  const SceneFile scene = read_scene_file(path);
  SceneView view;
  view.T_W_C = scene.T_W_C;
  if (!camera_pose.empty()) view.T_W_C = parse_pose(camera_pose);
  if (!scene.depth_file.empty()) {
    if (!scene.camera)
      throw FileError(path, "has a depth image but no camera", "add the camera's intrinsics");
    view.image = read_depth_png(scene.depth_file, *scene.camera, scene.depth_unit);
  } else if (!scene.cloud_file.empty()) {
    const Cloud cloud = read_cloud(scene.cloud_file);
    refuse_mirrored(cloud, scene.cloud_file);
    refuse_behind_camera(cloud, scene.cloud_file);
    const auto fitted = scene.camera ? scene.camera : fit_camera(cloud);
    view.image = to_depth_image(cloud, fitted ? *fitted : camera_for(cloud));
  } else {
    throw FileError(path, "has neither depth nor cloud",
                    "add one, or give the stones' poses to `stonestack search`");
  }
  return view;
}

}  // namespace

SceneView read_view(const std::string& path, const std::string& camera_pose, bool world,
                    const DepthInput& depth) {
  std::optional<geometry::SensorModel> sensor;
  if (!depth.sensor.empty()) sensor = geometry::read_sensor(depth.sensor);  // before a large file is read
  SceneView view = whole_view(path, camera_pose, world, depth);
  if (sensor && !view.world)  // a cloud in the world frame is seen from anywhere
    for (float& z : view.image.z)
      if (z < sensor->nearest || z > sensor->farthest) z = 0.0F;
  return view;
}

void check_level(const SceneView& view, const std::optional<Plane>& table_C, const std::string& path) {
  if (!view.world || !table_C) return;
  const Eigen::Vector3d n_W = view.T_W_C->linear() * table_C->normal;
  const double tilt = std::acos(std::clamp(n_W.z(), -1.0, 1.0));
  if (tilt > kMaxTilt)
    throw FileError(
        path,
        concat("was taken as in the world frame, but its table leans ", std::lround(tilt * 57.3), " deg"),
        "give it in the camera's optical frame (x right, y down, z forward), or with z up");
}

}  // namespace stonestack::stone
