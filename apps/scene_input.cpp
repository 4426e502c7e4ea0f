#include "scene_input.hpp"

#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "stonestack/core/error.hpp"

namespace stonestack::apps {

void register_depth_input(CLI::App& command, DepthInput& input) {
  command.add_option(
      "--sensor", input.sensor,
      "Kind of the depth camera, for its range, and count and nominal lens of a depth PNG: sr300, "
      "d435, d415, l515, xtion, kinect1, azure, f200 or a file (docs/formats.md, Sensors)");
  command.add_option("--depth-unit", input.unit, "m a count of a depth PNG; never guessed")
      ->check(CLI::Range(1e-6, 0.1));
  command.add_option("--camera", input.camera, "fx,fy,cx,cy of a depth PNG, pixels");
  command.add_option("--distortion", input.distortion,
                     "Of a depth PNG's or recording's lens: brown_conrady:k1,k2,p1,p2,k3 or "
                     "inverse_brown_conrady:... (SR300)");
  command.add_option("--frame", input.frame, "Of a recording, from 0")->check(CLI::NonNegativeNumber);
  command.add_option("--units", input.units, "Of a cloud's coordinates")
      ->check(CLI::IsMember({"m", "cm", "mm"}))
      ->capture_default_str();
}

void register_scene_inputs(CLI::App& command, SceneInputs& inputs) {
  command
      .add_option(
          "SCENE", inputs.paths,
          "Cloud (PLY, PCD) in the camera frame, scene file with depth or cloud, 16-bit depth PNG, or "
          "recording (folder: BOP, Open3D, TUM); several: views of one scene, judged together, "
          "results in the first one's camera frame")
      ->required();
  command
      .add_option("--camera-pose", inputs.camera_poses,
                  "T_W_C: x,y,z,qx,qy,qz,qw or a scene file; adds poses in W to the result; once a scene")
      ->allow_extra_args(false);
  command.add_flag("--world", inputs.world, "The cloud is in the world frame (z up, table at z = 0)");
  register_depth_input(command, inputs.depth);
}

std::vector<SceneView> read_views(const SceneInputs& inputs) {
  const auto& poses = inputs.camera_poses;
  require(poses.empty() || poses.size() == inputs.paths.size(), "give one --camera-pose a scene: there are ",
          inputs.paths.size(), " scenes and ", poses.size(), " poses");
  std::vector<SceneView> views;
  for (std::size_t i = 0; i < inputs.paths.size(); ++i) {
    views.push_back(read_view(inputs.paths[i], poses.empty() ? "" : poses[i], inputs.world, inputs.depth));
    if (inputs.paths.size() > 1 && !views.back().T_W_C)
      throw FileError(inputs.paths[i], "has no camera pose",
                      "several views need one each: add T_W_C or give --camera-pose for every scene");
  }
  return views;
}

std::vector<DepthView> depth_views_of(const std::vector<SceneView>& views) {
  std::vector<DepthView> depth;
  for (const auto& view : views) depth.push_back({view.image, view.T_W_C.value_or(Pose::Identity())});
  return depth;
}

void require_readable(const std::string& path) {
  if (::access(path.c_str(), R_OK) != 0) throw FileError(path, std::strerror(errno), "check the path");
}

}  // namespace stonestack::apps
