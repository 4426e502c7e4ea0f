#include "stonestack/detection/segment.hpp"

#include <iostream>

#include "commands.hpp"
#include "common_options.hpp"
#include "scene_input.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/report/results.hpp"

namespace stonestack::apps {
namespace {

struct SegmentCommand {
  Loudness loudness;
  SceneInputs inputs;
  SegmentOptions options;
  std::string out, picture;
  bool json = false;
};

void segment_scene(SegmentCommand& command) {
  command.loudness.apply();
  if (!command.out.empty()) require_writable(command.out + "/labels_1.png");
  if (!command.picture.empty()) require_writable(command.picture);
  const auto views = read_views(command.inputs);
  const std::string& first = command.inputs.paths.front();
  const Stopwatch watch;
  const Segmentation result = segment(depth_views_of(views), command.options);
  check_level(views.front(), result.table_C, first);
  log_info(concat(result.objects.size(), " objects in ", watch.seconds(), " s"));
  for (const auto& warning : segmentation_warnings(result)) log_warning(warning);
  if (!command.out.empty()) write_segmentation(command.out, result, views);
  if (!command.picture.empty()) draw_segmentation(command.picture, result, views);
  std::cout << (command.json ? segmentation_json(result, views.front().T_W_C)
                             : segmentation_table(result, views.front()));
  if (result.objects.empty()) throw Error(first + ": no object: " + result.note, ExitCode::kNothingDetected);
}

}  // namespace

void add_segment(CLI::App& app) {
  const auto [sub, command] = add_subcommand<SegmentCommand>(
      app, "segment", "Part unknown objects that stand on a table, touching and stacked ones too",
      segment_scene);
  register_scene_inputs(sub, command.inputs);
  add_path(
      sub, "--out", command.out,
      "Write a cloud for each object (object_1.ply, ...) and label images (labels_1.png, ..., 16 bit: an "
      "object's number, 0 elsewhere)",
      "DIR");
  add_path(sub, "--picture", command.picture, "Draw the objects in colours with their numbers (PNG)");
  sub.add_option("--min-width", command.options.min_width,
                 "m, square root of the seen area of the smallest object")
      ->check(CLI::Range(0.002, 1.0))
      ->capture_default_str();
  sub.add_option("--usual-size", command.options.usual_size,
                 "m, longest extent as expected; larger objects get less confidence")
      ->check(CLI::Range(0.02, 5.0))
      ->capture_default_str();
  sub.add_option("--farthest", command.options.farthest, "m, depths beyond are ignored")
      ->check(CLI::Range(0.2, 20.0))
      ->capture_default_str();
  sub.add_flag("--json", command.json, "Result as JSON on stdout");
  command.loudness.register_on(sub);
  sub.footer(
      "Examples:\n"
      "  stonestack render --out scene --seed 1 && stonestack segment scene/scene.yaml --picture "
      "objects.png\n"
      "  stonestack segment cloud.pcd --out objects --json\n"
      "  stonestack segment left/scene.yaml right/scene.yaml\n"
      "  stonestack segment depth.png --camera 475,475,319.5,239.5 --depth-unit 0.000125 --min-width 0.01");
}

}  // namespace stonestack::apps
