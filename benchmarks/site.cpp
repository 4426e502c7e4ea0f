// Is the tower that stands in a cloud alone found? Draws towers of settled stones with loose ones beside
// them, and scenes of loose stones alone, from several cameras, and sorts what is detected as `stonestack
// search` does. What is not found must be refused: never is a tower in view taken for an empty table.
#include <algorithm>
#include <cmath>
#include <memory>
#include <numeric>

#include "bench.hpp"
#include "common_options.hpp"
#include "geometry/depth_render.hpp"
#include "physics/settle.hpp"
#include "search/detect_missing.hpp"
#include "search/find_stack.hpp"
#include "simulation/sensor_noise.hpp"
#include "stone_draws.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/detection/detect_stones.hpp"
#include "stonestack/stone/catalogue.hpp"

namespace stonestack::bench {
namespace {

using namespace simulation;

constexpr double kFriction = 0.5;
constexpr double kRight = 0.005, kRightTurn = 0.0872665;  // m, rad (5 deg)

struct SiteBench {
  int scenes = 20, first = 0, loose = 2, seed = 1;
  bool list = false;
  PoolOptions pools;
};

/// A drawn scene: a tower, from the table up, and loose stones.
struct TowerScene {
  std::vector<PlacedStone> tower, loose;
  DepthImage image;
  Pose T_W_C = Pose::Identity();
};

/// Lowers a stone onto what is there until it nearly touches, and lets it come to rest.
std::optional<Pose> settled(const ShapeList& shapes, const Stack& below, StoneIndex stone,
                            const Eigen::Vector2d& p_W, Random& random) {
  const ContactShape& shape = *at(shapes, stone);
  Pose T_W_O = make_pose(Eigen::Vector3d(p_W.x(), p_W.y(), 0.6), random.rotation());
  const auto gap = [&] {
    double min = 1.0;
    for (const SurfaceSample& sample : shape.samples) {
      const Eigen::Vector3d p = T_W_O * sample.point;
      min = std::min(min, p.z());
      for (const PlacedStone& other : below.stones)
        min = std::min(min, at(shapes, other.stone)->distance.distance(other.T_W_O.inverse() * p));
    }
    return min;
  };
  while (gap() > 0.002) T_W_O.pretranslate(Eigen::Vector3d(0, 0, -0.001));
  SettleOptions options;
  options.world.friction = kFriction;
  options.seconds = 3.0;
  options.max_travel = 0.06;
  const SettleResult result = settle(shapes, below, stone, T_W_O, options);
  if (!result.rests) return std::nullopt;
  return result.T_W_O;
}

Pose camera_over_scene(Random& random) {
  const double tilt = random.uniform(0.0, 0.7), azimuth = random.uniform(0.0, 2.0 * M_PI);
  const double distance = random.uniform(0.62, 0.80), roll = random.uniform(0.0, 2.0 * M_PI);
  const Eigen::Vector3d out(std::sin(tilt) * std::cos(azimuth), std::sin(tilt) * std::sin(azimuth),
                            std::cos(tilt));
  Eigen::Matrix3d R;
  R.col(2) = -out;
  R.col(0) = R.col(2).cross(Eigen::Vector3d(-std::sin(azimuth), std::cos(azimuth), 0.2)).normalized();
  R.col(1) = R.col(2).cross(R.col(0));
  return make_pose(distance * out + Eigen::Vector3d(0, 0, 0.06),
                   Eigen::Quaterniond(R * Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ())));
}

TowerScene draw_scene(const StonePool& pool, int height, int loose, Random& random) {
  TowerScene scene;
  std::vector<StoneIndex> order = first_stones(pool.stones.size());
  do {
    random.shuffle(order.begin(), order.end());
    Stack stack;
    for (int level = 0; level < height; ++level)
      for (int attempt = 0; attempt < 60 && static_cast<int>(stack.stones.size()) == level; ++attempt) {
        const Eigen::Vector2d aside(random.uniform(-0.012, 0.012), random.uniform(-0.012, 0.012));
        if (const auto T = settled(pool.shapes, stack, order[static_cast<std::size_t>(level)], aside, random))
          stack.stones.push_back({order[static_cast<std::size_t>(level)], *T});
      }
    scene.tower = stack.stones;
  } while (static_cast<int>(scene.tower.size()) < height);
  const double start = random.uniform(0.0, 2.0 * M_PI);
  for (int i = 0; i < loose; ++i) {
    const StoneIndex stone = order[static_cast<std::size_t>(height + i)];
    const double angle = start + 2.0 * M_PI * i / loose, away = height > 0 ? 0.19 : 0.15;
    std::optional<Pose> T_W_O;
    while (!T_W_O)
      T_W_O =
          settled(pool.shapes, {}, stone, away * Eigen::Vector2d(std::cos(angle), std::sin(angle)), random);
    scene.loose.push_back({stone, *T_W_O});
  }
  RayScene world;
  world.add(make_box({3.0, 3.0, 0.02}), make_pose({0, 0, -0.01}));
  for (const auto* list : {&scene.tower, &scene.loose})
    for (const PlacedStone& placed : *list) world.add(at(pool.stones, placed.stone).scan, placed.T_W_O);
  world.commit();
  scene.T_W_C = camera_over_scene(random);
  const SensorModel sensor = read_sensor(random.uniform() < 0.5 ? "sr300" : "d435");
  scene.image = add_noise(render(world, sensor.camera, scene.T_W_C), scene.T_W_C, sensor, random);
  return scene;
}

/// How the scenes of a row came out.
struct SiteTally {
  int scenes = 0, right = 0, refused = 0, empty = 0, wrong = 0, again = 0;
};

enum class Verdict { kCorrect, kRefused, kEmpty, kWrong };

/// Sorts detections and compares them with the truth.
Verdict judge(const StonePool& pool, const TowerScene& scene, const DetectionResult& seen,
              const TableView& table, const Pose& T_V_C, std::string* why) {
  std::vector<PlacedStone> placed;
  for (const Detection& found : seen.detections) placed.push_back({found.stone, T_V_C * found.T_C_O});
  const SortedStones sorted = find_stack(pool.shapes, placed, std::nullopt, table.above_W);
  *why = sorted.note;
  if (!sorted.note.empty()) return Verdict::kRefused;
  if (sorted.stack.empty() && !scene.tower.empty()) return Verdict::kEmpty;
  if (sorted.stack.size() != scene.tower.size()) return Verdict::kWrong;
  const Pose T_V_W = T_V_C * scene.T_W_C.inverse();
  for (std::size_t i = 0; i < sorted.stack.size(); ++i) {
    const PoseDifference off = difference(sorted.stack[i].T_W_O, T_V_W * scene.tower[i].T_W_O);
    if (sorted.stack[i].stone != scene.tower[i].stone || off.translation > kRight || off.angle > kRightTurn) {
      *why = concat("level ", i, ": ", 1e3 * off.translation, " mm, ", off.angle * 180 / M_PI, " deg");
      return Verdict::kWrong;
    }
  }
  return Verdict::kCorrect;
}

void measure_pool(const SiteBench& bench, const StonePool& pool, int height, Results& results) {
  const DetectionOptions options;
  const DetectionModels models(pool.stones, options);
  SiteTally tally;
  for (int k = bench.first; k < bench.first + bench.scenes; ++k) {
    throw_if_interrupted();
    Random random = Random::stream(static_cast<std::uint64_t>(bench.seed), concat("site ", height, ' ', k));
    const TowerScene scene = draw_scene(pool, height, bench.loose + (height == 0 ? 2 : 0), random);
    const std::optional<Plane> table_C = find_table(scene.image, options);
    ++tally.scenes;
    if (!table_C) {
      ++tally.refused;
      continue;
    }
    const Pose T_V_C = camera_over(*table_C);
    const TableView table = view_of_table(scene.image, *table_C, T_V_C, options);
    DetectionResult seen = detect_stones(scene.image, models, {}, options);
    std::string why;
    Verdict verdict = judge(pool, scene, seen, table, T_V_C, &why);
    static const char* words[] = {"right", "refused", "EMPTY", "WRONG"};
    if (bench.list) {
      std::string all;
      for (const auto& p : scene.tower) all += at(pool.stones, p.stone).name + " ";
      all += "| ";
      for (const auto& p : scene.loose) all += at(pool.stones, p.stone).name + " ";
      all += "found ";
      for (const auto& p : seen.detections) all += concat(at(pool.stones, p.stone).name, ' ', p.score, ' ');
      results.note("%d %d %s: %s: %s", height, k, words[static_cast<int>(verdict)], all.c_str(), why.c_str());
    }
    if (verdict == Verdict::kRefused) {
      seen = detect_missing(scene.image, models, seen, options);
      verdict = judge(pool, scene, seen, table, T_V_C, &why);
      if (verdict == Verdict::kCorrect) ++tally.again;
      if (bench.list) {
        std::string all;
        for (const auto& p : seen.detections) all += concat(at(pool.stones, p.stone).name, ' ', p.score, ' ');
        results.note("   again %s: %s: %s", words[static_cast<int>(verdict)], all.c_str(), why.c_str());
      }
    }
    tally.right += verdict == Verdict::kCorrect ? 1 : 0;
    tally.refused += verdict == Verdict::kRefused ? 1 : 0;
    tally.empty += verdict == Verdict::kEmpty ? 1 : 0;
    tally.wrong += verdict == Verdict::kWrong ? 1 : 0;
  }
  results.row(
      {pool.name, height, tally.scenes, tally.right, tally.again, tally.refused, tally.empty, tally.wrong});
}

void measure(const SiteBench& bench, Results& results) {
  results.settings({{"scenes", bench.scenes},
                    {"first", bench.first},
                    {"loose", bench.loose},
                    {"friction", kFriction},
                    {"right_within_mm", 1e3 * kRight},
                    {"right_within_deg", kRightTurn * 180 / M_PI},
                    {"seed", bench.seed}});
  results.table("towers in clouds alone", {{"stones"},
                                           {"tower"},
                                           {"scenes"},
                                           {"found"},
                                           {"found_again"},
                                           {"refused"},
                                           {"nothing_stands"},
                                           {"wrong_tower"}});
  for (const StonePool& pool : read_pools(bench.pools))
    for (const int height : {0, 2, 3}) measure_pool(bench, pool, height, results);
}

}  // namespace

void add_site(CLI::App& app) {
  auto bench = std::make_shared<SiteBench>();
  CLI::App* sub = app.add_subcommand("site", "Is the tower that stands in a cloud alone found, or refused");
  sub->add_option("--scenes", bench->scenes, "Scenes of each height: no tower, two stones, three")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  sub->add_option("--first", bench->first, "Number of the first scene")->check(CLI::NonNegativeNumber);
  sub->add_option("--loose", bench->loose, "Loose stones beside the tower; two more without one")
      ->check(CLI::Range(0, 5))
      ->capture_default_str();
  sub->add_option("--seed", bench->seed)->check(CLI::Range(0, 2147483647))->capture_default_str();
  sub->add_flag("--list", bench->list, "Each scene");
  bench->pools.scans.clear();
  bench->pools.generated = 8;
  bench->pools.register_on(*sub);
  sub->footer("Example: stonestack-bench site --scenes 20 --catalogue data/stones");
  measure_by(*sub, [bench](Results& results) { measure(*bench, results); });
}

}  // namespace stonestack::bench
