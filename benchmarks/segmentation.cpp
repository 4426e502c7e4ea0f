// Segmentation of unknown objects on labelled recordings and on drawn rubble, with PCL's LCCP beside it.
#include "stonestack/detection/segment.hpp"

#include <algorithm>
#include <filesystem>
#include <map>
#include <memory>
#include <set>

#include "bench.hpp"
#include "detection_scenes.hpp"
#include "geometry/pcd.hpp"
#include "lccp.hpp"
#include "stone/reduce_mesh.hpp"
#include "stone_draws.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/stone/scene_file.hpp"

namespace stonestack::bench {
namespace {

constexpr double kRightIou = 0.75;    // of an object and a segment
constexpr double kSeenEnough = 0.25;  // of what faces the camera: other stones do not count
constexpr int kSeenPixels = 150;      // neither do those with fewer
constexpr int kBaselinePixels = 100;  // segments of the baseline with fewer are dropped
constexpr int kArrangedFaces = 500;   // of a stone while scenes are arranged
constexpr std::size_t kMaxPcd = 64U << 20U;

/// The command line.
struct SegmentationBench {
  PoolOptions pools;
  int scenes = 10;
  int first = 0;
  int seed = 1;
  std::string real = "../shared/real/mosd_learn";
  std::vector<std::string> kinds;
  bool baseline = true, list = false;
};

/// Views of a scene and what the first one truly shows: an object's number from 1 on a pixel, 0 elsewhere.
struct LabelledScene {
  std::string name;
  std::vector<DepthView> views;
  std::vector<int> truth;
  std::set<int> ignored;  ///< objects that are hidden too much to count
};

/// Counts over scenes.
struct SegmentationTally {
  int objects = 0, right = 0, segments = 0, scenes = 0;
  double cpu = 0.0;
  double right_confidence = 0.0, wrong_confidence = 0.0;  ///< sums
  int wrong = 0;
};

/// Compares segments with objects: an object is right if a segment has an IoU of 0.75 with it.
void judge_segments(const LabelledScene& scene, const std::vector<int>& labels,
                    const std::vector<SegmentedObject>* objects, SegmentationTally& tally) {
  std::map<int, int> true_size, size;
  std::map<std::pair<int, int>, int> both;
  for (std::size_t i = 0; i < labels.size(); ++i) {
    const bool seen = scene.views[0].image.z[i] > 0;
    if (seen && scene.truth[i] > 0) ++true_size[scene.truth[i]];
    if (labels[i] > 0) ++size[labels[i]];
    if (seen && scene.truth[i] > 0 && labels[i] > 0) ++both[{scene.truth[i], labels[i]}];
  }
  std::set<int> right, ignored;
  for (const auto& [pair, shared] : both) {
    const auto& [object, label] = pair;
    if (scene.ignored.count(object) > 0) {
      if (2 * shared > size[label]) ignored.insert(label);
    } else if (shared >= kRightIou * (true_size[object] + size[label] - shared)) {
      right.insert(label);
    }
  }
  ++tally.scenes;
  for (const auto& [object, pixels] : true_size) tally.objects += scene.ignored.count(object) == 0 ? 1 : 0;
  tally.right += static_cast<int>(right.size());
  for (const auto& [label, pixels] : size) {
    if (ignored.count(label) > 0) continue;
    ++tally.segments;
    const bool is_right = right.count(label) > 0;
    tally.wrong += is_right ? 0 : 1;
    if (objects == nullptr) continue;
    (is_right ? tally.right_confidence : tally.wrong_confidence) +=
        (*objects)[static_cast<std::size_t>(label - 1)].confidence;
  }
}

std::vector<Column> columns() {
  return {{"set"},
          {"method"},
          {"scenes"},
          {"objects"},
          {"right"},
          {"right_share", 3},
          {"segments"},
          {"f_score", 3},
          {"confidence_right"},
          {"confidence_wrong"},
          {"cpu_s_a_frame"}};
}

void add_row(const std::string& set, const std::string& method, const SegmentationTally& t,
             bool has_confidence, Results& results) {
  const auto mean = [&](double sum, int count) {
    return has_confidence && count > 0 ? TableValue(sum / count) : TableValue();
  };
  results.row({set, method, t.scenes, t.objects, t.right, static_cast<double>(t.right) / t.objects,
               t.segments, 2.0 * t.right / (t.objects + t.segments), mean(t.right_confidence, t.right),
               mean(t.wrong_confidence, t.wrong), t.cpu / t.scenes});
}

/// Both methods on the scenes that `make` gives.
template <class Make>
void measure_set(const std::string& set, int count, const Make& make, const SegmentationBench& settings,
                 Results& results) {
  SegmentationTally own, lccp;
  for (int i = 0; i < count; ++i) {
    throw_if_interrupted();
    const LabelledScene scene = make(i);
    double start = processor_seconds();
    const Segmentation found = segment(scene.views);
    own.cpu += processor_seconds() - start;
    require(!found.labels.empty(), scene.name, ": ", found.note);
    const int before = own.right;
    judge_segments(scene, found.labels[0], &found.objects, own);
    if (settings.list)
      results.note("  %s: %d right, %zu segments", scene.name.c_str(), own.right - before,
                   found.objects.size());
    if (!settings.baseline || scene.views.size() > 1) continue;
    start = processor_seconds();
    const auto labels = lccp_labels(scene.views[0].image, *found.table_C, 0.008, kBaselinePixels);
    lccp.cpu += processor_seconds() - start;
    judge_segments(scene, labels, nullptr, lccp);
  }
  if (own.objects == 0) return;
  add_row(set, "stonestack", own, true, results);
  if (lccp.objects > 0) add_row(set, "LCCP", lccp, false, results);
}

/// Labelled recording: labels 20 to 29 are parts of the first object, 30 to 39 of the second, ...
LabelledScene read_recording(const std::string& path) {
  LabelledScene scene{path, {{read_view(path, "").image, Pose::Identity()}}, {}, {}};
  for (const int label : parse_pcd_labels(path, read_file(path, kMaxPcd)))
    scene.truth.push_back(label >= 20 ? label / 10 - 1 : 0);
  return scene;
}

std::vector<std::string> recordings_in(const std::string& folder) {
  std::vector<std::string> paths;
  if (std::filesystem::is_directory(folder))
    for (const auto& entry : std::filesystem::directory_iterator(folder))
      if (entry.path().extension() == ".pcd") paths.push_back(entry.path().string());
  std::sort(paths.begin(), paths.end());
  return paths;
}

LabelledScene drawn_scene(const SceneMaker& maker, const SceneKind& kind, std::uint64_t seed) {
  BenchScene made = maker.make(kind, seed);
  LabelledScene scene{concat(kind.name, " ", seed), std::move(made.views), std::move(made.shown[0]), {}};
  std::map<int, int> pixels;
  for (int& label : scene.truth) ++pixels[++label];
  for (std::size_t k = 0; k < made.truth.size(); ++k) {
    const int number = static_cast<int>(k) + 1;
    if (made.truth[k].unhidden < kSeenEnough || pixels[number] < kSeenPixels) scene.ignored.insert(number);
  }
  return scene;
}

/// touching, ring: pushed together; stacked: on each other; low: a heap seen from low down; heap: ten in a
/// settled heap.
std::vector<SceneKind> rubble_kinds() {
  return {{"touching", 4, "touching"},
          {"ring", 8, "touching"},
          {"stacked", 4, "stacked", "sr300", 1, 1, 0.5, 1.1},
          {"low", 6, "touching", "sr300", 1, 1, 1.2, 1.35},
          {"heap", 10, "heap"},
          {"heap_d435", 10, "heap", "d435"},
          {"heap_two_views", 10, "heap", "sr300", 1, 2}};
}

void measure_all(const SegmentationBench& settings, Results& results) {
  results.settings({{"scenes", settings.scenes},
                    {"first", settings.first},
                    {"right_from_iou", kRightIou},
                    {"seed", settings.seed}});
  results.table("segmentation", columns());
  const auto paths = recordings_in(settings.real);
  if (paths.empty()) results.note("no recordings in %s: simulated scenes only", settings.real.c_str());
  measure_set(
      "recordings", static_cast<int>(paths.size()),
      [&](int i) { return read_recording(paths[static_cast<std::size_t>(i)]); }, settings, results);
  for (StonePool& pool : read_pool_stones(settings.pools)) {
    for (Stone& stone : pool.stones)  // the arrangement takes coarse meshes, the picture the scans
      stone.mesh = reduce_mesh(stone.scan, kArrangedFaces);
    const SceneMaker maker(pool.stones);
    for (const SceneKind& kind : rubble_kinds()) {
      const auto& wanted = settings.kinds;
      if (!wanted.empty() && std::find(wanted.begin(), wanted.end(), kind.name) == wanted.end()) continue;
      const auto seed =
          static_cast<std::uint64_t>(settings.seed) * 100000 + static_cast<std::uint64_t>(settings.first);
      measure_set(
          kind.name + " " + pool.name, settings.scenes,
          [&](int i) { return drawn_scene(maker, kind, seed + static_cast<std::uint64_t>(i)); }, settings,
          results);
    }
  }
}

}  // namespace

void add_segmentation(CLI::App& app) {
  auto command = std::make_shared<SegmentationBench>();
  CLI::App* sub = app.add_subcommand(
      "segmentation", "Unknown objects parted right on recordings and drawn rubble, PCL's LCCP beside");
  sub->add_option("--scenes", command->scenes, "Drawn scenes a kind and pool")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  sub->add_option("--first", command->first, "Number of the first drawn scene")
      ->check(CLI::NonNegativeNumber);
  sub->add_option("--kinds", command->kinds,
                  "touching,ring,stacked,low,heap,heap_d435,heap_two_views; all if empty")
      ->delimiter(',');
  sub->add_option("--real", command->real, "Labelled recordings (PCD); skipped when they are not there")
      ->type_name("DIR")
      ->capture_default_str();
  sub->add_flag("!--no-baseline", command->baseline, "Without LCCP");
  sub->add_flag("--list", command->list, "A line a scene");
  command->pools.register_on(*sub);
  sub->add_option("--seed", command->seed, "Same seed, same scenes")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  sub->footer(
      "Examples:\n"
      "  stonestack-bench segmentation --scenes 20\n"
      "  stonestack-bench segmentation --kinds heap --first 500 --scenes 20 --no-baseline\n"
      "An object is right if a segment has an intersection over union of 0.75 with it; stones of which "
      "others "
      "hide\nthree quarters do not count. F: harmonic mean of the shares of objects and of segments that are "
      "right.\nThe method's constants were chosen with all recordings and with drawn scenes of other "
      "stones.");
  measure_by(*sub, [command](Results& results) { measure_all(*command, results); });
}

}  // namespace stonestack::bench
