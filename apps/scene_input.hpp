#pragma once
#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "rooms.hpp"
#include "stonestack/detection/detect_stones.hpp"
#include "stonestack/stone/scene_file.hpp"

namespace stonestack::apps {

/// --sensor, --depth-unit, --camera, --distortion, --frame, --units.
void register_depth_input(CLI::App& command, DepthInput& input);

/// Scenes of a command that takes one view or several of one scene.
struct SceneInputs {
  std::vector<std::string> paths;
  std::vector<std::string> camera_poses;  ///< one a scene, or none
  bool world = false;                     ///< the cloud is in the world frame
  DepthInput depth;
};
/// SCENE..., --camera-pose, --world and what register_depth_input adds.
void register_scene_inputs(CLI::App& command, SceneInputs& inputs);
/// Every scene with its camera pose; several need one each, so that they can be joined.
/// @throws InvalidArgument, FileError.
[[nodiscard]] std::vector<SceneView> read_views(const SceneInputs& inputs);
/// The views as detection takes them.
[[nodiscard]] std::vector<DepthView> depth_views_of(const std::vector<SceneView>& views);

/// Throws FileError unless a file or folder of that name is there and may be read: for a check before shapes
/// are built, which takes seconds.
void require_readable(const std::string& path);

}  // namespace stonestack::apps
