#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "common_options.hpp"
#include "detection_json.hpp"
#include "scene_input.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/detection/detect_stones.hpp"
#include "stonestack/detection/trace.hpp"

namespace stonestack::apps {
namespace {

constexpr double kCertain = 0.9;

struct DetectCommand {
  CommonOptions common;
  std::vector<std::string> inputs;
  std::vector<std::string> camera_poses;
  bool world = false;
  std::string stones;
  std::string trace;
  DepthInput depth;
  DetectionOptions options;
};

std::vector<int> wanted_stones(const Catalogue& catalogue, const std::string& list) {
  std::vector<int> wanted;
  if (!list.empty())
    for (const auto& name : split(list, ',')) wanted.push_back(catalogue.index(name));
  return wanted;
}

/// Every scene with its camera pose; several need one each, so that they can be joined.
std::vector<SceneView> read_views(const DetectCommand& command) {
  const auto& poses = command.camera_poses;
  require(poses.empty() || poses.size() == command.inputs.size(),
          "give one --camera-pose a scene: there are ", command.inputs.size(), " scenes and ", poses.size(),
          " poses");
  std::vector<SceneView> views;
  for (std::size_t i = 0; i < command.inputs.size(); ++i) {
    views.push_back(
        read_view(command.inputs[i], poses.empty() ? "" : poses[i], command.world, command.depth));
    if (command.inputs.size() > 1 && !views.back().T_W_C)
      throw FileError(command.inputs[i], "has no camera pose",
                      "several views need one each: add T_W_C or give --camera-pose for every scene");
  }
  return views;
}

DetectionResult detect_in(const std::vector<SceneView>& views, const DetectionModels& models,
                          const std::vector<int>& wanted, const DetectionOptions& options) {
  std::vector<DepthView> several;
  for (const auto& view : views) several.push_back({view.image, view.T_W_C.value_or(Pose::Identity())});
  return detect_stones(several, models, wanted, options);
}

void print_json(const DetectionResult& result, const Catalogue& catalogue, const std::optional<Pose>& T_W_C) {
  nlohmann::json list = nlohmann::json::array();
  for (const auto& found : result.detections) list.push_back(detection_json(catalogue, found, T_W_C));
  nlohmann::json out = {{"schema", "stonestack.detect/1"}, {"detections", list}, {"note", result.note}};
  if (result.depth_scale_sigma > 0)
    out["depth_scale"] = {{"factor", result.depth_scale}, {"sigma", result.depth_scale_sigma}};
  std::cout << out.dump(2) << '\n';
}

/// Positions in C, or in W for a cloud that no camera took.
void print_table(const Catalogue& catalogue, const DetectionResult& result, const SceneView& view) {
  std::printf("%-20s %6s %8s %8s   position in the %s frame (m)\n", "stone", "score", "inliers", "visible",
              view.world ? "world" : "camera");
  for (const auto& found : result.detections) {
    const Eigen::Vector3d p_C = found.T_C_O.translation();
    const Eigen::Vector3d p = view.world ? Eigen::Vector3d(*view.T_W_C * p_C) : p_C;
    std::printf("%-20s %6.3f %8.3f %8.3f   %7.4f %7.4f %7.4f\n",
                catalogue.stones[static_cast<std::size_t>(found.stone)].name.c_str(), found.score,
                found.inlier_ratio, found.visible, p.x(), p.y(), p.z());
  }
}

/// Names what else a detection may be: the other stones by name, and in how many other poses.
std::string in_words(const Detection& found, const Catalogue& catalogue) {
  std::string others;
  int turned = 0;
  for (const auto& alternative : found.alternatives) {
    const std::string& name = catalogue.stones[static_cast<std::size_t>(alternative.stone)].name;
    if (alternative.stone == found.stone)
      ++turned;
    else if (others.find("'" + name + "'") == std::string::npos)
      others += concat(others.empty() ? "" : ", ", "'", name, "'");
  }
  std::string words;
  if (!others.empty()) words = "may be " + others + " as well";
  if (turned > 0)
    words += concat(words.empty() ? "" : " and ", "is nearly symmetric: ", turned,
                    " other poses fit as well or nearly");
  return words;
}

/// Names the stones whose shape leaves the pose open, or which stone it is, and the poses that the paper's
/// inlier ratio takes though the visibility-aware score would refuse them.
void warn_of_doubtful(const DetectionResult& result, const Catalogue& catalogue,
                      const DetectionOptions& options) {
  for (const auto& found : result.detections) {
    const std::string& name = catalogue.stones[static_cast<std::size_t>(found.stone)].name;
    if (found.certainty < kCertain)
      log_warning(concat(name, " ", in_words(found, catalogue),
                         " (--json lists them); it has a certainty of ", found.certainty));
    if (found.score < options.accept_score)
      log_warning(concat(name, " is here by its inlier ratio; its score of ", found.score,
                         " says that the pose is wrong (detection.accept_score ", options.accept_score, ")"));
  }
}

void detect(DetectCommand& command) {
  command.common.begin();
  command.options.seed = command.common.seed;
  command.common.settings.apply(nest("detection", fields(command.options)));
  if (!command.trace.empty()) require_writable(command.trace + "/stages.json");
  const Catalogue catalogue = command.common.read();
  const auto wanted = wanted_stones(catalogue, command.stones);
  const auto views = read_views(command);
  if (views.front().world)
    check_level(views.front(), find_table(views.front().image, command.options), command.inputs.front());
  log_info(concat("preparing ", catalogue.stones.size(), " stones"));
  command.options.trace = !command.trace.empty();
  const DetectionModels models(catalogue.stones, command.options);
  const Stopwatch watch;
  const DetectionResult result = detect_in(views, models, wanted, command.options);
  log_info(concat(result.detections.size(), " stones found in ", watch.seconds(), " s"));
  if (!result.detections.empty() && !result.note.empty())
    log_warning(command.inputs.front() + ": " + result.note);
  warn_of_doubtful(result, catalogue, command.options);
  if (result.trace) write_trace(command.trace, *result.trace, catalogue.stones);
  if (command.common.json)
    print_json(result, catalogue, views.front().T_W_C);
  else
    print_table(catalogue, result, views.front());
  if (result.detections.empty())
    throw Error(command.inputs.front() + ": nothing detected: " + result.note, ExitCode::kNothingDetected);
}

}  // namespace

void add_detect(CLI::App& app) {
  auto command = std::make_shared<DetectCommand>();
  CLI::App* sub = app.add_subcommand("detect", "Find stones of a catalogue in a depth view");
  sub->add_option(
         "SCENE", command->inputs,
         "Cloud (PLY, PCD) in the camera frame, scene file with depth or cloud, 16-bit depth PNG, or "
         "recording "
         "(folder: BOP, Open3D, TUM); several: views of one scene, judged together, results in the first "
         "one's camera frame")
      ->required();
  sub->add_option("--camera-pose", command->camera_poses,
                  "T_W_C: x,y,z,qx,qy,qz,qw or a scene file; adds T_W_O to the result; once a scene")
      ->allow_extra_args(false);
  sub->add_flag("--world", command->world, "The cloud is in the world frame (z up, table at z = 0)");
  register_depth_input(*sub, command->depth);
  sub->add_option("--stones", command->stones, "Only these, by name, comma-separated");
  command->common.settings.bind(sub->add_option("--copies", command->options.copies, "Of each stone at most")
                                    ->check(CLI::Range(1, 100))
                                    ->capture_default_str(),
                                "detection.copies");
  sub->add_option("--trace", command->trace,
                  "Write what each stage saw: keypoints, matches, clusters, hypotheses (PLY, JSON)")
      ->type_name("DIR");
  command->common.settings.bind(sub->add_option("--method", command->options.method,
                                                "default, or paper: section 2 as a set of options, which "
                                                "--set, files and environment override")
                                    ->check(CLI::IsMember({"default", "paper"}))
                                    ->capture_default_str(),
                                "detection.method");
  command->common.register_on(*sub);
  sub->footer(
      "Examples:\n"
      "  stonestack render --out scene --seed 1 && stonestack detect scene/scene.yaml\n"
      "  stonestack detect cloud.pcd --catalogue rocks --json\n"
      "  stonestack detect depth.png --camera 475,475,319.5,239.5 --depth-unit 0.000125\n"
      "  stonestack detect left/scene.yaml right/scene.yaml --trace trace\n"
      "  stonestack detect cloud.ply --method paper --set detection.keypoints=iss --set "
      "detection.descriptor=iss");
  sub->callback([command] { detect(*command); });
}

}  // namespace stonestack::apps
