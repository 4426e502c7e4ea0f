// Recall, false accepts, errors, calibration and time of detection on seeded synthetic scenes.
// A stone counts when a quarter or more of what faces the camera is not hidden. Right: within 5 deg and 5 mm.
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <memory>

#include "bench.hpp"
#include "common_options.hpp"
#include "detection_scenes.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/detection/detect_stones.hpp"

namespace stonestack::apps {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;
constexpr double kChi2Of95 = 12.592;  // six degrees of freedom

/// What the user asks for.
struct DetectionBench {
  CommonOptions common;
  int scenes = 20;
  std::vector<std::string> kinds, methods{"default"};
  bool list = false;
};

/// Counts and samples of one method on one kind of scene.
struct Tally {
  int present = 0, right = 0, wrong = 0, absent = 0, false_accepts = 0, calibrated = 0;
  std::vector<double> degrees, millimetres, chi2, right_scores, bad_scores;
  double wall = 0, cpu = 0;
};

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return std::nan("");
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1) + 0.5)];
}

double mahalanobis2(const Detection& d, const Pose& truth) {
  Eigen::Matrix<double, 6, 1> e;
  const Eigen::AngleAxisd turn(truth.linear() * d.T_C_O.linear().transpose());
  e << truth.translation() - d.T_C_O.translation(), turn.angle() * turn.axis();
  return e.dot(d.covariance.ldlt().solve(e));
}

void judge(const DetectionResult& result, const bench::BenchScene& scene, int models,
           const DetectionBench& settings, Tally& tally) {
  for (int stone = 0; stone < models; ++stone) {
    const auto truth = std::find_if(scene.truth.begin(), scene.truth.end(),
                                    [&](const bench::TrueStone& t) { return t.stone == stone; });
    const auto found = std::find_if(result.detections.begin(), result.detections.end(),
                                    [&](const Detection& d) { return d.stone == stone; });
    const bool seen = found != result.detections.end();
    if (truth == scene.truth.end()) {
      ++tally.absent;
      tally.false_accepts += seen ? 1 : 0;
      if (seen) tally.bad_scores.push_back(found->score);
      if (seen && settings.list)
        std::printf("    false accept: stone %d score %.3f visible %.2f\n", stone, found->score,
                    found->visible);
      continue;
    }
    const PoseDifference off = seen ? difference(found->T_C_O, truth->T_C_O) : PoseDifference{};
    const bool right = seen && off.angle < 5 * kDegree && off.translation < 0.005;
    if (truth->unhidden >= 0.25) ++tally.present, tally.right += right ? 1 : 0;
    if (!right && settings.list && (seen || truth->unhidden >= 0.25))
      std::printf("    %s: stone %d unhidden %.2f", seen ? "wrong" : "missed", stone, truth->unhidden);
    if (seen && !right && settings.list)
      std::printf(" score %.3f visible %.2f off %.1f deg %.1f mm", found->score, found->visible,
                  off.angle / kDegree, off.translation * 1000);
    if (!right && settings.list && (seen || truth->unhidden >= 0.25)) std::printf("\n");
    if (!seen) continue;
    tally.wrong += right ? 0 : 1;
    (right ? tally.right_scores : tally.bad_scores).push_back(found->score);
    if (!right) continue;
    tally.degrees.push_back(off.angle / kDegree);
    tally.millimetres.push_back(off.translation * 1000);
    tally.chi2.push_back(mahalanobis2(*found, truth->T_C_O));
    tally.calibrated += tally.chi2.back() < kChi2Of95 ? 1 : 0;
  }
}

void print(const std::string& method, const std::string& kind, int scenes, const Tally& t) {
  std::printf(
      "%-8s %-9s %6.1f%% %4d/%-4d %3d %4d/%-5d %5.2f %5.2f %5.2f %5.2f %5.1f%% %6.2f %6.2f %6.3f %6.3f\n",
      method.c_str(), kind.c_str(), 100.0 * t.right / std::max(1, t.present), t.right, t.present, t.wrong,
      t.false_accepts, t.absent, quantile(t.degrees, 0.5), quantile(t.degrees, 0.95),
      quantile(t.millimetres, 0.5), quantile(t.millimetres, 0.95),
      100.0 * t.calibrated / std::max<std::size_t>(1, t.degrees.size()), quantile(t.chi2, 0.95) / kChi2Of95,
      quantile(t.right_scores, 0.05), t.wall / scenes, t.cpu / scenes);
  std::fflush(stdout);
}

void measure(DetectionBench& settings, const std::vector<Stone>& stones) {
  const bench::SceneMaker maker(stones);
  std::printf("seed %d, %d scenes a kind, %zu models, 5 deg / 5 mm\n", settings.common.seed, settings.scenes,
              stones.size());
  std::printf("%-8s %-9s %7s %9s %3s %10s %11s %11s %6s %6s %6s %6s %6s\n", "method", "kind", "recall", "",
              "bad", "false", "deg 50/95", "mm 50/95", "in 95%", "chi2", "score5", "wall s", "cpu s");
  for (const auto& method : settings.methods) {
    DetectionOptions options;
    options.method = method;
    settings.common.settings.apply(nest("detection", fields(options)));
    options.method = method;
    const DetectionModels models(stones, options);
    for (const auto& kind : bench::scene_kinds()) {
      if (!settings.kinds.empty() &&
          std::find(settings.kinds.begin(), settings.kinds.end(), kind.name) == settings.kinds.end())
        continue;
      Tally tally;
      for (int i = 0; i < settings.scenes; ++i) {
        throw_if_interrupted();
        const auto scene = maker.make(
            kind, static_cast<std::uint64_t>(settings.common.seed) * 100000 + static_cast<std::uint64_t>(i));
        if (settings.list) std::printf("  scene %d\n", i);
        const Stopwatch watch;
        const std::clock_t start = std::clock();
        const auto result = detect_stones(scene.image, models, {}, options);
        tally.cpu += static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
        tally.wall += watch.seconds();
        judge(result, scene, static_cast<int>(stones.size()), settings, tally);
      }
      print(method, kind.name, settings.scenes, tally);
    }
  }
}

}  // namespace

void add_bench_detection(CLI::App& bench) {
  auto command = std::make_shared<DetectionBench>();
  CLI::App* sub = bench.add_subcommand(
      "detection", "Recall, false accepts, errors, calibration and time on seeded scenes");
  sub->add_option("--scenes", command->scenes, "Scenes a kind")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  sub->add_option("--kinds", command->kinds, "isolated,touching,stacked,few,d435; all if empty")
      ->delimiter(',');
  sub->add_option("--methods", command->methods, "default,paper")->delimiter(',')->capture_default_str();
  sub->add_flag("--list", command->list, "Every miss and every false accept");
  command->common.register_bench(*sub);
  sub->footer(
      "Examples:\n"
      "  stonestack bench detection --scenes 100 --methods default,paper\n"
      "  stonestack bench detection --kinds touching --scenes 10 --list");
  sub->callback([command] { measure(*command, command->common.read().stones); });
}

}  // namespace stonestack::apps
