#include <iostream>

#include "commands.hpp"
#include "common_options.hpp"
#include "scene_input.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/detection/detect_stones.hpp"
#include "stonestack/report/results.hpp"

namespace stonestack::apps {
namespace {

struct DetectCommand {
  CommonOptions common;
  SceneInputs inputs;
  std::string stones;
  std::string trace;
  std::string explain;
  DetectionOptions options;
};

/// The stones that a comma-separated list names; none for an empty one.
std::vector<StoneIndex> named_stones(const std::string& list, const Catalogue& catalogue) {
  std::vector<StoneIndex> stones;
  if (list.empty()) return stones;
  for (const auto& name : split_list(list)) stones.push_back(catalogue.index(name));
  return stones;
}

/// Detections, and why other stones were not found.
struct Detected {
  DetectionResult result;
  std::vector<Explanation> explanations;
};

Detected detect_in(const std::vector<SceneView>& views, const Catalogue& catalogue,
                   const DetectCommand& command) {
  const auto wanted = named_stones(command.stones, catalogue);
  const auto explained = named_stones(command.explain, catalogue);
  log_info(concat("preparing ", catalogue.stones.size(), " stones"));
  const DetectionModels models(catalogue.stones, command.options);
  const Stopwatch watch;
  DetectionResult result = detect_stones(depth_views_of(views), models, wanted, command.options);
  log_info(concat(result.detections.size(), " stones found in ", watch.seconds(), " s"));
  Detected detected{std::move(result), {}};
  for (const StoneIndex stone : explained)
    detected.explanations.push_back(
        explain_stone(views.front().image, detected.result, models, stone, command.options));
  return detected;
}

/// Path of the picture that explains a stone: beside the trace, or here.
std::string picture_path(const DetectCommand& command, const std::string& stone) {
  return concat(command.trace.empty() ? "" : command.trace + "/", "explain_", stone, ".png");
}

void draw_explanations(const std::vector<Explanation>& explanations, const SceneView& view,
                       const Catalogue& catalogue, const DetectCommand& command) {
  for (const Explanation& e : explanations) {
    if (e.evidence.empty()) continue;
    const std::string path = picture_path(command, at(catalogue.stones, e.stone).name);
    draw_explanation(path, view.image, e);
    log_info("drawn: " + path);
  }
}

void detect(DetectCommand& command) {
  command.options.seed = command.common.seed;
  command.common.settings.apply(nest("detection", fields(command.options)));
  command.options.trace = !command.trace.empty() || !command.explain.empty();
  if (!command.trace.empty()) require_writable(command.trace + "/stages.json");
  const Catalogue catalogue = command.common.read();
  for (const StoneIndex stone : named_stones(command.explain, catalogue))
    require_writable(picture_path(command, at(catalogue.stones, stone).name));
  const auto views = read_views(command.inputs);
  const std::string& first = command.inputs.paths.front();
  if (views.front().world)
    check_level(views.front(), find_table(views.front().image, command.options), first);
  const auto [result, explanations] = detect_in(views, catalogue, command);
  if (!result.detections.empty() && !result.note.empty()) log_warning(first + ": " + result.note);
  for (const auto& uncertainty : detection_warnings(result, catalogue, command.options))
    log_warning(uncertainty);
  if (!command.trace.empty() && result.trace) write_trace(command.trace, *result.trace, catalogue.stones);
  std::cout << (command.common.json ? detection_json(result, catalogue, views.front().T_W_C, explanations)
                                    : detection_table(result, catalogue, views.front()) +
                                          explanation_text(explanations, catalogue));
  draw_explanations(explanations, views.front(), catalogue, command);
  if (result.detections.empty())
    throw Error(first + ": nothing detected: " + result.note, ExitCode::kNothingDetected);
}

}  // namespace

void add_detect(CLI::App& app) {
  const auto [sub, command] =
      add_subcommand<DetectCommand>(app, "detect", "Find stones of a catalogue in a depth view", detect);
  Settings& settings = command.common.settings;
  register_scene_inputs(sub, command.inputs);
  sub.add_option("--stones", command.stones, "Search for these stones only, by name, comma-separated");
  settings.bind(sub.add_option("--copies", command.options.copies, "Maximum number of copies of each stone")
                    ->check(CLI::Range(1, 100))
                    ->capture_default_str(),
                "detection.copies");
  add_path(sub, "--trace", command.trace,
           "Write what each stage saw: keypoints, matches, clusters, hypotheses (PLY, JSON)", "DIR");
  sub.add_option("--explain", command.explain,
                 "Say of these stones, by name, comma-separated, at which stage they were lost and what may "
                 "help, and draw the pose that came nearest: explain_NAME.png, in the folder of --trace if "
                 "there is one");
  settings.bind(sub.add_option("--method", command.options.method,
                               "default, or paper: section 2 as a set of options, which --set, files and "
                               "environment override")
                    ->check(CLI::IsMember({"default", "paper"}))
                    ->capture_default_str(),
                "detection.method");
  command.common.register_on(sub);
  sub.footer(
      "Examples:\n"
      "  stonestack render --out scene --seed 1 && stonestack detect scene/scene.yaml\n"
      "  stonestack detect cloud.pcd --catalogue rocks --json\n"
      "  stonestack detect depth.png --camera 475,475,319.5,239.5 --depth-unit 0.000125\n"
      "  stonestack detect left/scene.yaml right/scene.yaml --trace trace\n"
      "  stonestack detect depth.png --camera 475,475,319.5,239.5 --depth-unit 0.000125 --explain "
      "limestone_2\n"
      "  stonestack detect cloud.ply --method paper --set detection.keypoints=iss --set "
      "detection.descriptor=iss");
}

}  // namespace stonestack::apps
