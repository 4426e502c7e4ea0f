// Recall, false accepts, errors, calibration and time of detection on seeded synthetic scenes.
#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>

#include "bench.hpp"
#include "common_options.hpp"
#include "detection/trace.hpp"
#include "detection_bop.hpp"
#include "detection_tally.hpp"
#include "modelled_stones.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/detection/detect_stones.hpp"

namespace stonestack::bench {
namespace {

/// The command line.
struct DetectionBench {
  CommonOptions common;
  int scenes = 20;
  int first = 0;
  std::vector<std::string> kinds, methods{"default"};
  std::string trace;
  std::string bop, bop_split = "test", bop_csv = "stonestack_bop.csv";
  bool list = false;
  int attitudes = 0;
  CameraError camera_error;
};

DetectionOptions options_for(const std::string& method, DetectionBench& settings) {
  DetectionOptions options = options_of(method);
  FieldList list = nest("detection", fields(options));
  std::erase_if(list, [](const Field& f) { return f.name == "detection.method"; });  // --methods says it
  settings.common.settings.apply(list);
  options.trace = !settings.trace.empty();
  return options;
}

/// One file a method: BOP's names begin with the method, up to the first '_'.
std::string csv_of(const std::string& path, const std::string& method) {
  const std::filesystem::path file(path);
  return (file.parent_path() / (method + "-" + file.filename().string())).string();
}

/// Stones that scenes show, and what detection knows of them.
struct KnownStones {
  SceneMaker maker;
  std::vector<Stone> models;   ///< the scans, or what views show of them
  std::vector<Pose> T_scan_O;  ///< frames of the models in those of the scans
};

KnownStones known_stones(const std::vector<Stone>& stones, const DetectionBench& settings) {
  KnownStones known{SceneMaker(stones), {}, {}};
  if (settings.attitudes == 0)
    return {std::move(known.maker), stones, std::vector<Pose>(stones.size(), Pose::Identity())};
  for (auto& one : stones_from_views(known.maker, {.attitudes = {settings.attitudes}},
                                     static_cast<std::uint64_t>(settings.common.seed))) {
    known.models.push_back(std::move(one.stone));
    known.T_scan_O.push_back(one.T_scan_O);
  }
  return known;
}

DetectionTally detect_in(const SceneKind& kind, int scene_number, const KnownStones& known,
                         const DetectionModels& models, DetectionOptions options,
                         const DetectionBench& settings, Results& results) {
  options.copies = kind.copies;
  DetectionTally tally;
  const auto seed =
      static_cast<std::uint64_t>(settings.common.seed) * 100000 + static_cast<std::uint64_t>(scene_number);
  auto scene = known.maker.make(kind, seed, settings.camera_error);
  for (TrueStone& t : scene.truth) t.T_C_O = t.T_C_O * at(known.T_scan_O, t.stone);
  if (settings.list) results.note("  %s %d", kind.name.c_str(), scene_number);
  const Stopwatch watch;
  const double start = processor_seconds();
  const auto result = detect_stones(scene.views, models, {}, options);
  tally.cpu = processor_seconds() - start;
  tally.wall = watch.seconds();
  judge(result, scene, kind, known.models.size(), settings.list ? &results : nullptr, tally);
  if (result.trace)
    write_trace(concat(settings.trace, "/", kind.name, "_", scene_number), *result.trace, known.models);
  return tally;
}

void measure(DetectionBench& settings, const std::vector<Stone>& stones, Results& results, Draws& draws) {
  const auto kinds = scene_kinds();
  for (const auto& name : settings.kinds)
    require(std::any_of(kinds.begin(), kinds.end(), [&](const auto& k) { return k.name == name; }),
            "no kind of scene is called '", name, "'; see --help");
  results.settings({{"scenes", settings.scenes},
                    {"first", settings.first},
                    {"models", stones.size()},
                    {"attitudes", settings.attitudes},
                    {"right_within_deg", 5.0},
                    {"right_within_mm", 5.0},
                    {"camera_shift_m", settings.camera_error.shift},
                    {"camera_turn_rad", settings.camera_error.turn},
                    {"seed", settings.common.seed}});
  results.table("detection", detection_columns());
  std::optional<KnownStones> known;
  if (draws.performs()) known.emplace(known_stones(stones, settings));
  for (const auto& method : settings.methods) {
    const DetectionOptions options = options_for(method, settings);
    std::optional<DetectionModels> models;
    if (draws.performs()) models.emplace(known->models, options);
    for (const auto& kind : kinds) {
      const auto& wanted = settings.kinds;
      if (!wanted.empty() && std::find(wanted.begin(), wanted.end(), kind.name) == wanted.end()) continue;
      const auto tallies = draws.outcomes(concat(method, ' ', kind.name), settings.scenes, [&](int i) {
        return detect_in(kind, settings.first + i, *known, *models, options, settings, results);
      });
      throw_if_interrupted();
      if (tallies.empty()) continue;
      DetectionTally sum;
      for (const DetectionTally& tally : tallies) add(sum, tally);
      results.row(detection_cells(options.method, kind.name, sum));
    }
  }
}

}  // namespace

void add_detection(CLI::App& app) {
  auto command = std::make_shared<DetectionBench>();
  CLI::App* sub =
      app.add_subcommand("detection", "Recall, false accepts, errors, calibration and time on seeded scenes");
  sub->add_option("--scenes", command->scenes, "Scenes a kind")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  sub->add_option("--first", command->first, "Number of the first scene")->check(CLI::NonNegativeNumber);
  sub->add_option("--kinds", command->kinds,
                  "isolated,touching,stacked,few,d435,copies,mirrored,hidden,two_views; all if empty")
      ->delimiter(',');
  sub->add_option("--methods", command->methods, "default,paper")->delimiter(',')->capture_default_str();
  sub->add_option("--attitudes", command->attitudes,
                  "Models from four views of each stone in so many attitudes at most, as run --unseen makes "
                  "them; 0: scans")
      ->check(CLI::Range(0, 6))
      ->capture_default_str();
  sub->add_flag("--list", command->list, "Every detection, miss and false accept");
  sub->add_option("--bop", command->bop, "Detect in a data set of the BOP layout in place of our scenes")
      ->type_name("DIR");
  sub->add_option("--bop-split", command->bop_split, "Its folder of scenes")->capture_default_str();
  sub->add_option("--bop-csv", command->bop_csv,
                  "Where BOP's results go; with several methods METHOD- before its name")
      ->capture_default_str();
  sub->add_option("--trace", command->trace, "Write what each stage saw of every scene")->type_name("DIR");
  sub->add_option("--camera-shift", command->camera_error.shift,
                  "m, error of the reported pose of a second view")
      ->capture_default_str();
  sub->add_option("--camera-turn", command->camera_error.turn, "rad, the same")->capture_default_str();
  command->common.register_draw(*sub);
  sub->footer(
      "Examples:\n"
      "  stonestack-bench detection --scenes 100 --methods default,paper\n"
      "  stonestack-bench detection --kinds touching --first 7 --scenes 1 --list --trace trace\n"
      "  stonestack-bench detection --scenes 100 --shard 2/8 --record part-2.json\n"
      "  stonestack-bench detection --merge part-*.json\n"
      "  stonestack-bench detection --bop lm --bop-csv stonestack_lm-test.csv\n"
      "Kinds: isolated, four stones apart; touching, in a heap; stacked, three on each other, seen from the "
      "side; "
      "few, one\nstone and the others absent; d435, another sensor; copies, one stone twice; mirrored, no "
      "stone is "
      "there; hidden, a heap\nof six from low down; two_views, the same heaps from a second side, too.\n"
      "deg, mm: errors, median and 95 %; in 95: share of true poses within the stated 95 % region; chi2: 95 "
      "%\n"
      "quantile of the squared Mahalanobis distance over what it should be; score p5: 5 % quantile of right "
      "scores\n"
      "BOP data sets are scored as the BOP toolkit does (MSSD, MSPD), with the symmetries of "
      "models_info.json or,\nwhere it names none, of the meshes.");
  measure_draws_by(*sub, [command](Results& results, Draws& draws) {
    if (command->bop.empty()) return measure(*command, command->common.read().stones, results, draws);
    require(!draws.divided(), "--shard and --merge are for our scenes, not for --bop");
    require(command->attitudes == 0, "--attitudes is for our scenes, not for --bop");
    results.settings({{"bop", command->bop}, {"split", command->bop_split}});
    const bool several = command->methods.size() > 1;
    for (const auto& method : command->methods)
      run_bop(command->bop, command->bop_split, several ? csv_of(command->bop_csv, method) : command->bop_csv,
              options_for(method, *command), results);
  });
}

}  // namespace stonestack::bench
