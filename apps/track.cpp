#include <algorithm>
#include <iostream>

#include "commands.hpp"
#include "common_options.hpp"
#include "scene_input.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/report/results.hpp"

namespace stonestack::apps {
namespace {

struct TrackCommand {
  CommonOptions common;
  std::string input, expect, camera_pose, held;
  DepthInput depth;
  DetectionOptions detection;
  TrackOptions limits;
};

/// The stones to look for, in C; those in the gripper are left out.
std::vector<KnownStone> expected_stones(const TrackCommand& command, const Catalogue& catalogue,
                                        const Pose& T_W_C) {
  std::vector<StoneIndex> held;
  if (!command.held.empty())
    for (const auto& name : split_list(command.held)) held.push_back(catalogue.index(name));
  std::vector<KnownStone> expected;
  for (const auto& [name, T_W_O] : read_seen_poses(command.expect)) {
    const StoneIndex stone = catalogue.index(name);
    if (std::find(held.begin(), held.end(), stone) == held.end())
      expected.push_back({stone, T_W_C.inverse() * T_W_O});
  }
  if (expected.empty())
    throw FileError(command.expect, "expects no stone on the table",
                    "list stones with T_W_O, not all --held");
  return expected;
}

void track(TrackCommand& command) {
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
  const TrackResult result =
      track_stones(view.image, models, expected, command.detection, {}, command.limits);
  std::cout << (command.common.json ? tracking_json(result, catalogue, *view.T_W_C)
                                    : tracking_table(result, catalogue));
  const auto seen = [](const TrackedStone& stone) { return stone.detection.has_value(); };
  if (std::none_of(result.stones.begin(), result.stones.end(), seen))
    throw Error(command.input + ": none of the expected stones is seen" +
                    (result.note.empty() ? "" : ": " + result.note),
                ExitCode::kNothingDetected);
}

}  // namespace

void add_track(CLI::App& app) {
  const auto [sub, command] = add_subcommand<TrackCommand>(
      app, "track", "Check whether stones are where they were: in place, moved, fallen, unseen", track);
  sub.add_option("SCENE", command.input,
                 "What the camera sees now: scene file, cloud, depth PNG or recording, as for detect")
      ->required();
  add_path(sub, "--expect", command.expect,
           "Where the stones were: a scene file (its stack and stones), or what detect --json or track "
           "--json printed")
      ->required();
  sub.add_option("--camera-pose", command.camera_pose, "T_W_C: x,y,z,qx,qy,qz,qw or a scene file");
  sub.add_option("--held", command.held, "Stones in the gripper, comma-separated: not searched on the table");
  register_depth_input(sub, command.depth);
  command.common.register_on(sub);
  sub.footer(
      "Examples:\n"
      "  stonestack detect before/scene.yaml --json > before.json\n"
      "  stonestack track after/scene.yaml --expect before.json --held limestone_2\n"
      "  stonestack track cloud.ply --camera-pose 0.7,0,0.7,1,0,0,0 --expect scene.yaml --json\n"
      "  stonestack track scene.yaml --expect scene.yaml --set tracking.moved_shift=0.002\n"
      "A stone has fallen when its centre is lower by tracking.fallen_drop, and moved when it is elsewhere.");
}

}  // namespace stonestack::apps
