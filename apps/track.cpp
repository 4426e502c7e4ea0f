#include <algorithm>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "common_options.hpp"
#include "detection_json.hpp"
#include "geometry/json_file.hpp"
#include "scene_input.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/detection/track_stones.hpp"

namespace stonestack::apps {
namespace {

struct TrackCommand {
  CommonOptions common;
  std::string input, expect, camera_pose, held;
  DepthInput depth;
  DetectionOptions detection;
  TrackOptions limits;
};

Pose pose_in(const nlohmann::json& entry, const std::string& key, const std::string& path) {
  const auto& pose = entry.at(key);
  const auto number = [&](const char* name) { return number_of(pose, name, -1e3, 1e3, path); };
  const Eigen::Quaterniond q(number("qw"), number("qx"), number("qy"), number("qz"));
  if (std::abs(q.norm() - 1.0) > 0.01)
    throw FileError(path, concat("the rotation of ", key, " has length ", q.norm()), "it must be 1");
  return make_pose({number("x"), number("y"), number("z")}, q);
}

/// Reads the poses that an earlier `detect --json` or `track --json` found.
std::vector<NamedPose> poses_of_result(const std::string& path) {
  const auto content = read_json(path);
  const char* key = content.is_object() && content.contains("tracked") ? "tracked" : "detections";
  if (!content.is_object() || !content.contains(key) || !content.at(key).is_array())
    throw FileError(path, "holds no detections", "give a scene file, or what detect --json printed");
  std::vector<NamedPose> poses;
  for (const auto& entry : content.at(key)) {
    if (!entry.is_object() || !entry.contains("stone") || !entry.at("stone").is_string())
      throw FileError(path, "has an entry without a stone", "give what detect --json printed");
    if (entry.contains("T_W_O"))
      poses.push_back({entry.at("stone").get<std::string>(), pose_in(entry, "T_W_O", path)});
    else if (key == std::string("detections"))
      throw FileError(path, "has no T_W_O: the camera's pose was not known",
                      "detect again with --camera-pose, so that the camera may move");
  }
  return poses;
}

std::vector<NamedPose> expected_poses(const std::string& path) {
  if (!is_scene_file(path)) return poses_of_result(path);
  const SceneFile scene = read_scene_file(path);
  std::vector<NamedPose> poses = scene.stack;
  poses.insert(poses.end(), scene.stones.begin(), scene.stones.end());
  return poses;
}

nlohmann::json tracked_json(const Catalogue& catalogue, const TrackedStone& t, const Pose& T_W_C) {
  nlohmann::json entry = {{"stone", catalogue.stones[static_cast<std::size_t>(t.stone)].name}};
  if (t.detection) {
    entry = detection_json(catalogue, *t.detection, T_W_C);
    entry["moved_m"] = t.moved.translation;
    entry["turned_rad"] = t.moved.angle;
  }
  entry["status"] = to_text(t.status);
  return entry;
}

void print_table(const Catalogue& catalogue, const std::vector<TrackedStone>& all) {
  std::printf("%-20s %-9s %9s %8s %6s\n", "stone", "status", "moved mm", "deg", "score");
  for (const auto& t : all) {
    std::printf("%-20s %-9s", catalogue.stones[static_cast<std::size_t>(t.stone)].name.c_str(),
                to_text(t.status).c_str());
    if (t.detection)
      std::printf(" %9.1f %8.1f %6.3f", 1000.0 * t.moved.translation, t.moved.angle * 180.0 / M_PI,
                  t.detection->score);
    std::printf("\n");
  }
}

/// The stones to look for, in C; those in the hand are left out.
std::vector<KnownStone> expected_stones(const TrackCommand& command, const Catalogue& catalogue,
                                        const Pose& T_W_C) {
  std::vector<int> held;
  if (!command.held.empty())
    for (const auto& name : split(command.held, ',')) held.push_back(catalogue.index(name));
  std::vector<KnownStone> expected;
  for (const auto& [name, T_W_O] : expected_poses(command.expect)) {
    const int stone = catalogue.index(name);
    if (std::find(held.begin(), held.end(), stone) == held.end())
      expected.push_back({stone, T_W_C.inverse() * T_W_O});
  }
  if (expected.empty())
    throw FileError(command.expect, "expects no stone on the table",
                    "list stones with T_W_O, not all --held");
  return expected;
}

void track(TrackCommand& command) {
  command.common.begin();
  command.detection.seed = command.common.seed;
  command.common.settings.apply(
      join({nest("detection", fields(command.detection)), nest("tracking", fields(command.limits))}));
  const Catalogue catalogue = command.common.read();
  const SceneView view = read_view(command.input, command.camera_pose, false, command.depth);
  if (!view.T_W_C)
    throw FileError(command.input, "has no camera pose",
                    "add T_W_C or give --camera-pose: stones are expected in the world frame");
  const auto expected = expected_stones(command, catalogue, *view.T_W_C);
  const DetectionModels models(catalogue.stones, command.detection);
  const auto [tracked, note] =
      track_stones(view.image, models, expected, command.detection, {}, command.limits);
  if (command.common.json) {
    nlohmann::json list = nlohmann::json::array();
    for (const auto& t : tracked) list.push_back(tracked_json(catalogue, t, *view.T_W_C));
    std::cout << nlohmann::json{{"schema", "stonestack.track/1"}, {"tracked", list}, {"note", note}}.dump(2)
              << '\n';
  } else {
    print_table(catalogue, tracked);
  }
  if (std::none_of(tracked.begin(), tracked.end(), [](const auto& t) { return t.detection.has_value(); }))
    throw Error(command.input + ": none of the expected stones is seen" + (note.empty() ? "" : ": " + note),
                ExitCode::kNothingDetected);
}

}  // namespace

void add_track(CLI::App& app) {
  auto command = std::make_shared<TrackCommand>();
  CLI::App* sub =
      app.add_subcommand("track", "Look whether stones are where they were: in place, moved, fallen, unseen");
  sub->add_option("SCENE", command->input,
                  "What the camera sees now: scene file, cloud, depth PNG or recording, as for detect")
      ->required();
  sub->add_option(
         "--expect", command->expect,
         "Where the stones were: a scene file (its stack and stones), or what detect --json or track "
         "--json printed")
      ->required()
      ->type_name("FILE");
  sub->add_option("--camera-pose", command->camera_pose, "T_W_C: x,y,z,qx,qy,qz,qw or a scene file");
  sub->add_option("--held", command->held, "In the hand, comma-separated: not searched on the table");
  register_depth_input(*sub, command->depth);
  command->common.register_on(*sub);
  sub->footer(
      "Examples:\n"
      "  stonestack detect before/scene.yaml --json > before.json\n"
      "  stonestack track after/scene.yaml --expect before.json --held limestone_2\n"
      "  stonestack track cloud.ply --camera-pose 0.7,0,0.7,1,0,0,0 --expect scene.yaml --json\n"
      "  stonestack track scene.yaml --expect scene.yaml --set tracking.moved_shift=0.002\n"
      "A stone has fallen when its centre is lower by tracking.fallen_drop, and moved when it is elsewhere.");
  sub->callback([command] { track(*command); });
}

}  // namespace stonestack::apps
