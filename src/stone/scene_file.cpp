#include "stonestack/stone/scene_file.hpp"

#include <cmath>
#include <filesystem>

#include "core/yaml.hpp"
#include "geometry/pose_yaml.hpp"
#include "stonestack/core/file.hpp"

namespace stonestack::stone {
namespace {

constexpr const char* kSchema = "stonestack.scene/1";

std::string beside(const std::string& scene_path, const std::string& file) {
  const std::filesystem::path given(file);
  return given.is_absolute() ? file : (std::filesystem::path(scene_path).parent_path() / given).string();
}

int read_pixels(yaml::Map& map, const std::string& key) {
  const double count = map.number(key, 1, 10000);
  if (count != std::floor(count)) map.fail(key, concat("is ", count), "it must be a whole number");
  return static_cast<int>(count);
}

CameraIntrinsics read_camera(yaml::Map map) {
  CameraIntrinsics camera;
  camera.width = read_pixels(map, "width");
  camera.height = read_pixels(map, "height");
  camera.fx = map.number("fx", 1, 1e5);
  camera.fy = map.number("fy", 1, 1e5);
  camera.cx = map.number("cx", -1e5, 1e5);
  camera.cy = map.number("cy", -1e5, 1e5);
  if (map.has("distortion")) {
    const std::string kind = map.text("distortion");
    using Distortion = CameraIntrinsics::Distortion;
    if (kind == "brown_conrady")
      camera.distortion = Distortion::kBrownConrady;
    else if (kind == "inverse_brown_conrady")
      camera.distortion = Distortion::kInverseBrownConrady;
    else if (kind != "none")
      map.fail("distortion", concat("is '", kind, "'"),
               "it must be none, brown_conrady or inverse_brown_conrady");
  }
  if (map.has("k")) {
    const auto k = map.node("k");
    if (!k.IsSequence() || k.size() != 5)
      map.fail("k", "is not a list of five numbers", "give k1, k2, p1, p2, k3");
    for (std::size_t i = 0; i < 5; ++i)
      if (!YAML::convert<double>::decode(k[i], camera.k[i]) || !std::isfinite(camera.k[i]))
        map.fail("k", "has an entry that is not a number", "give k1, k2, p1, p2, k3");
  }
  map.finish();
  return camera;
}

std::vector<NamedPose> read_stones(yaml::Map& map, const std::string& key) {
  std::vector<NamedPose> stones;
  if (!map.has(key)) return stones;
  const auto list = map.node(key);
  if (!list.IsSequence()) map.fail(key, "is not a list", "write one '- {stone: NAME, T_W_O: {...}}' a stone");
  for (std::size_t i = 0; i < list.size(); ++i) {
    yaml::Map entry(list[i], map.path(), concat(key, "[", i, "]"));
    stones.push_back({entry.text("stone"), read_pose(entry.map("T_W_O"))});
    if (entry.has("T_C_O")) (void)entry.node("T_C_O");  // follows from T_W_C; written for people
    entry.finish();
  }
  return stones;
}

std::string write_stones(const char* key, const SceneFile& scene, const std::vector<NamedPose>& stones) {
  std::string text = stones.empty() ? "" : concat(key, ":\n");
  for (const auto& item : stones) {
    text += concat("  - stone: ", item.stone, "\n    T_W_O: ", to_text(item.T_W_O), "\n");
    if (scene.T_W_C) text += concat("    T_C_O: ", to_text(scene.T_W_C->inverse() * item.T_W_O), "\n");
  }
  return text;
}

std::string camera_text(const CameraIntrinsics& c) {
  static constexpr const char* kKinds[] = {"none", "brown_conrady", "inverse_brown_conrady"};
  std::string text = concat("camera: {width: ", c.width, ", height: ", c.height, ", fx: ", c.fx,
                            ", fy: ", c.fy, ", cx: ", c.cx, ", cy: ", c.cy,
                            ", distortion: ", kKinds[static_cast<int>(c.distortion)], ", k: [");
  for (int i = 0; i < 5; ++i) text += concat(i == 0 ? "" : ", ", c.k[i]);
  return text + "]}\n";
}

}  // namespace

bool is_scene_file(const std::string& path) {
  const auto extension = std::filesystem::path(path).extension();
  return extension == ".yaml" || extension == ".yml";
}

SceneFile read_scene_file(const std::string& path) {
  if (!is_scene_file(path))
    throw FileError(path, "is not a scene file",
                    "give a .yaml file with poses of stones, as `render` and `search --out` write");
  yaml::Map map(yaml::read_file(path), path);
  const std::string schema = map.text("schema");
  if (schema != kSchema)
    throw FileError(path, concat("is a ", schema, " file by its schema"),
                    concat("give a ", kSchema, " file, as `search --out` writes"));
  SceneFile scene;
  if (map.has("camera")) scene.camera = read_camera(map.map("camera"));
  if (map.has("T_W_C")) scene.T_W_C = read_pose(map.map("T_W_C"));
  if (map.has("depth")) {
    auto depth = map.map("depth");
    scene.depth_file = beside(path, depth.text("file"));
    scene.depth_unit = depth.number("unit", 1e-6, 0.1);
    depth.finish();
  }
  if (map.has("cloud")) scene.cloud_file = beside(path, map.text("cloud"));
  scene.stack = read_stones(map, "stack");
  scene.wall = read_stones(map, "wall");
  if (!scene.stack.empty() && !scene.wall.empty())
    map.fail("wall", "is given beside a stack", "give one of them");
  scene.stones = read_stones(map, "stones");
  if (map.has("obstacles"))
    scene.obstacles = parse_obstacles(YAML::Dump(map.node("obstacles")), path, "obstacles");
  if (map.has("padding")) {
    std::vector<std::string> names;
    for (const Obstacle& obstacle : scene.obstacles) names.push_back(obstacle.name);
    scene.paddings = parse_pair_paddings(YAML::Dump(map.node("padding")), path, "padding", names);
  }
  map.finish();
  return scene;
}

void write_scene_file(const std::string& path, const SceneFile& scene) {
  std::string text = concat("schema: ", kSchema, "\n");
  if (scene.camera) text += camera_text(*scene.camera);
  if (scene.T_W_C) text += concat("T_W_C: ", to_text(*scene.T_W_C), "\n");
  if (!scene.depth_file.empty())
    text += concat("depth: {file: ", scene.depth_file, ", unit: ", scene.depth_unit, "}\n");
  if (!scene.cloud_file.empty()) text += concat("cloud: ", scene.cloud_file, "\n");
  text += write_stones("stack", scene, scene.stack) + write_stones("wall", scene, scene.wall) +
          write_stones("stones", scene, scene.stones);
  write_file(path, text);
}

}  // namespace stonestack::stone
