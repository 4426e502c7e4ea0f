#include <array>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "common_options.hpp"
#include "geometry/pose_json.hpp"
#include "scene_input.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/detection/detect_stones.hpp"

namespace stonestack::apps {
namespace {

struct DetectCommand {
  CommonOptions common;
  std::string input;
  std::string camera_pose;
  bool world = false;
  std::string stones;
  DetectionOptions options;
};

std::vector<int> wanted_stones(const Catalogue& catalogue, const std::string& list) {
  std::vector<int> wanted;
  if (!list.empty())
    for (const auto& name : split(list, ',')) wanted.push_back(catalogue.index(name));
  return wanted;
}

nlohmann::json detection_json(const Catalogue& catalogue, const Detection& found,
                              const std::optional<Pose>& T_W_C) {
  nlohmann::json entry = {{"stone", catalogue.stones[static_cast<std::size_t>(found.stone)].name},
                          {"T_C_O", pose_json(found.T_C_O)},
                          {"score", found.score},
                          {"inlier_ratio", found.inlier_ratio},
                          {"visible", found.visible}};
  if (T_W_C) entry["T_W_O"] = pose_json(*T_W_C * found.T_C_O);
  return entry;
}

void print_table(const Catalogue& catalogue, const DetectionResult& result) {
  std::printf("%-20s %6s %8s %8s   position in the camera frame (m)\n", "stone", "score", "inliers",
              "visible");
  for (const auto& found : result.detections) {
    const auto& p = found.T_C_O.translation();
    std::printf("%-20s %6.3f %8.3f %8.3f   %7.4f %7.4f %7.4f\n",
                catalogue.stones[static_cast<std::size_t>(found.stone)].name.c_str(), found.score,
                found.inlier_ratio, found.visible, p.x(), p.y(), p.z());
  }
}

void detect(DetectCommand& command) {
  command.common.begin();
  command.options.seed = command.common.seed;
  command.common.settings.apply(nest("detection", fields(command.options)));
  const Catalogue catalogue = command.common.read();
  const auto wanted = wanted_stones(catalogue, command.stones);
  const SceneView view = read_view(command.input, command.camera_pose, command.world);
  log_info(concat("preparing ", catalogue.stones.size(), " stones"));
  const DetectionModels models(catalogue.stones, command.options);
  const Stopwatch watch;
  const DetectionResult result = detect_stones(view.image, models, wanted, command.options);
  log_info(concat(result.detections.size(), " stones found in ", watch.seconds(), " s"));
  if (command.common.json) {
    nlohmann::json list = nlohmann::json::array();
    for (const auto& found : result.detections) list.push_back(detection_json(catalogue, found, view.T_W_C));
    std::cout << nlohmann::json{{"schema", "stonestack.detect/1"},
                                {"detections", list},
                                {"note", result.note}}
                     .dump(2)
              << '\n';
  } else {
    print_table(catalogue, result);
  }
  if (result.detections.empty())
    throw Error(command.input + ": nothing detected: " + result.note, ExitCode::kNothingDetected);
}

}  // namespace

void add_detect(CLI::App& app) {
  auto command = std::make_shared<DetectCommand>();
  CLI::App* sub = app.add_subcommand("detect", "Find stones of a catalogue in a depth view");
  sub->add_option("SCENE", command->input,
                  "Cloud (PLY, PCD) in the camera frame, or scene file with depth or cloud")
      ->required();
  sub->add_option("--camera-pose", command->camera_pose,
                  "T_W_C: x,y,z,qx,qy,qz,qw or a scene file; adds T_W_O to the result");
  sub->add_flag("--world", command->world, "The cloud is in the world frame (z up, table at z = 0)");
  sub->add_option("--stones", command->stones, "Only these, by name, comma-separated");
  command->common.settings.bind(sub->add_option("--method", command->options.method, "default or paper")
                                    ->check(CLI::IsMember({"default", "paper"}))
                                    ->capture_default_str(),
                                "detection.method");
  command->common.register_on(*sub);
  sub->footer(
      "Examples:\n"
      "  stonestack render --out scene --seed 1 && stonestack detect scene/scene.yaml\n"
      "  stonestack detect cloud.pcd --catalogue rocks --json\n"
      "  stonestack detect cloud.ply --method paper --set detection.best=50");
  sub->callback([command] { detect(*command); });
}

}  // namespace stonestack::apps
