#include "scene_input.hpp"

#include <charconv>
#include <cmath>
#include <filesystem>

#include "stonestack/core/error.hpp"
#include "stonestack/geometry/cloud_file.hpp"
#include "stonestack/geometry/fit_camera.hpp"

namespace stonestack::apps {
namespace {

constexpr double kCameraHeight = 0.8;  // m above the middle of a world-frame cloud

std::vector<double> parse_numbers(const std::string& text, std::size_t count, const char* form) {
  std::vector<double> numbers;
  for (const auto& part : split(text, ',')) {
    double value = 0.0;
    const auto [end, error] = std::from_chars(part.data(), part.data() + part.size(), value);
    require(error == std::errc() && end == part.data() + part.size() && std::isfinite(value), "'", part,
            "' in '", text, "' is not a number; expected ", form);
    numbers.push_back(value);
  }
  require(numbers.size() == count, "'", text, "' has ", numbers.size(), " numbers; expected ", form);
  return numbers;
}

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

SceneView view_of_cloud(const std::string& path, const std::string& camera_pose, bool world) {
  const Cloud cloud = read_cloud(path);
  const Cloud solid = without_gaps(cloud);
  if (solid.points.empty()) throw FileError(path, "has no finite point", "record the scene again");
  SceneView view;
  const auto camera = fit_camera(cloud);
  if (world || (camera_pose.empty() && !camera)) {
    view.T_W_C = camera_pose.empty() ? camera_above(solid) : parse_pose(camera_pose);
    view.image = to_depth_image(transformed(solid, view.T_W_C->inverse()), CameraIntrinsics{});
  } else {
    if (!camera_pose.empty()) view.T_W_C = parse_pose(camera_pose);
    view.image = to_depth_image(cloud, camera.value_or(CameraIntrinsics{}));
  }
  return view;
}

}  // namespace

std::vector<std::string> split(const std::string& list, char separator) {
  std::vector<std::string> parts;
  for (std::size_t from = 0; from <= list.size();) {
    const auto to = std::min(list.find(separator, from), list.size());
    parts.push_back(list.substr(from, to - from));
    from = to + 1;
  }
  return parts;
}

bool is_scene_file(const std::string& path) {
  const auto extension = std::filesystem::path(path).extension();
  return extension == ".yaml" || extension == ".yml";
}

Pose parse_pose(const std::string& text) {
  if (is_scene_file(text)) {
    const SceneFile scene = read_scene_file(text);
    if (!scene.T_W_C)
      throw FileError(text, "has no T_W_C", "add the camera's pose or give it as x,y,z,qx,qy,qz,qw");
    return *scene.T_W_C;
  }
  const auto v = parse_numbers(text, 7, "x,y,z,qx,qy,qz,qw");
  const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
  require(std::abs(q.norm() - 1.0) < 0.01, "the rotation of '", text, "' has length ", q.norm(),
          "; it must be 1");
  return make_pose({v[0], v[1], v[2]}, q);
}

Eigen::Vector2d parse_point(const std::string& text) {
  const auto v = parse_numbers(text, 2, "x,y");
  return {v[0], v[1]};
}

SceneView read_view(const std::string& path, const std::string& camera_pose, bool world) {
  if (!is_scene_file(path)) return view_of_cloud(path, camera_pose, world);
  const SceneFile scene = read_scene_file(path);
  SceneView view;
  view.T_W_C = scene.T_W_C;
  if (!camera_pose.empty()) view.T_W_C = parse_pose(camera_pose);
  const CameraIntrinsics camera = scene.camera.value_or(CameraIntrinsics{});
  if (!scene.depth_file.empty()) {
    if (!scene.camera)
      throw FileError(path, "has a depth image but no camera", "add the camera's intrinsics");
    view.image = read_depth_png(scene.depth_file, camera, scene.depth_unit);
  } else if (!scene.cloud_file.empty()) {
    const Cloud cloud = read_cloud(scene.cloud_file);
    view.image = to_depth_image(cloud, scene.camera ? *scene.camera : fit_camera(cloud).value_or(camera));
  } else {
    throw FileError(path, "has neither depth nor cloud",
                    "add one, or give the stones' poses to `stonestack search`");
  }
  return view;
}

Pose camera_over_table(const std::optional<Plane>& table_C, const std::string& path) {
  if (!table_C) throw FileError(path, "shows no table and has no camera pose", "give --camera-pose");
  const Eigen::Vector3d z_C = table_C->normal;
  const Eigen::Vector3d x_C = (Eigen::Vector3d::UnitX() - z_C.x() * z_C).normalized();
  Pose T_C_W = Pose::Identity();
  T_C_W.linear() << x_C, z_C.cross(x_C), z_C;
  T_C_W.translation() = table_C->offset * z_C;
  return T_C_W.inverse();
}

}  // namespace stonestack::apps
