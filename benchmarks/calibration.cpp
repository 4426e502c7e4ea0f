// Do placements succeed as often as predicted? Every alternative that the search returns, sure or not, is put
// down several times with the noise that was planned for, drawn from other streams, on the same contact
// features.
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>

#include "bench.hpp"
#include "put_down.hpp"
#include "settings.hpp"
#include "stone_draws.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::bench {
namespace {

constexpr std::size_t kBins = 5;

struct BenchOptions {
  BenchOptions() {
    search.min_success = 0.0;
    search.horizon = 1;
    search.alternatives = 10;
  }
  int placements = 500, stones = 4, repeats = 4, seed = 1;
  PoolOptions pools;
  SearchOptions search = search_without_robot();
  Settings settings;
};

/// One noisy placement: what was predicted, what happened.
struct Try {
  double predicted;
  bool held;
};

/// Tries of the alternatives on every level of one tower, which grows by the surest of them, put down
/// exactly.
void try_tower(const BenchOptions& options, const StonePool& pool, int k, std::vector<Try>* tries) {
  SearchProblem problem = draw_problem(pool, options.seed, k, options.stones);
  Random random = Random::stream(static_cast<std::uint64_t>(options.seed), concat("calibration ", k));
  PlacementNoise noise;
  noise.shift = options.search.placement_sigma_translation;
  noise.turn = options.search.placement_sigma_rotation;
  noise.com = options.search.com_sigma;
  noise.friction = options.search.friction;
  while (!problem.available.empty()) {
    const SearchResult found = find_next_pose(problem, options.search);
    if (found.best.empty()) return;
    for (const Placement& target : found.best)
      for (int repeat = 0; repeat < options.repeats; ++repeat)
        tries->push_back({target.predicted_success,
                          put_down(pool.fine, problem.stack, target, noise, random).has_value()});
    const auto surest = std::max_element(
        found.best.begin(), found.best.end(),
        [](const Placement& p, const Placement& q) { return p.predicted_success < q.predicted_success; });
    problem.stack.stones.push_back({surest->stone, surest->T_W_O});
    const StoneIndex placed = surest->stone;
    std::erase_if(problem.available, [&](const PlacedStone& s) { return s.stone == placed; });
  }
}

/// Chance that a placement that held was given more than one that fell.
double area_under_curve(const std::vector<Try>& tries) {
  double above = 0.0, pairs = 0.0;
  for (const Try& held : tries)
    for (const Try& fell : tries) {
      if (!held.held || fell.held) continue;
      pairs += 1.0;
      above += held.predicted > fell.predicted ? 1.0 : (held.predicted == fell.predicted ? 0.5 : 0.0);
    }
  return pairs > 0.0 ? above / pairs : 1.0;
}

void report_pool(const StonePool& pool, const std::vector<Try>& tries, Results& results) {
  struct Bin {
    int count = 0, held = 0;
    double predicted = 0.0;
  };
  std::array<Bin, kBins> bins{};
  for (const Try& one : tries) {
    Bin& bin = bins[std::min(kBins - 1, static_cast<std::size_t>(one.predicted * kBins))];
    ++bin.count;
    bin.held += one.held ? 1 : 0;
    bin.predicted += one.predicted;
  }
  results.figures(pool.name,
                  {{"placements", tries.size()}, {"area_under_curve", area_under_curve(tries), 3}});
  results.table(pool.name + " by predicted success",
                {{"from", 1}, {"to", 1}, {"placements"}, {"predicted"}, {"observed"}});
  for (std::size_t b = 0; b < kBins; ++b) {
    const Bin& bin = bins[b];
    const double n = bin.count;  // without placements no share
    results.row({static_cast<double>(b) / kBins, static_cast<double>(b + 1) / kBins, bin.count,
                 bin.predicted / n, bin.held / n});
  }
}

void measure(const BenchOptions& options, Results& results) {
  results.settings({{"stones", options.stones},
                    {"friction", options.search.friction},
                    {"noise_mm", 1e3 * options.search.placement_sigma_translation},
                    {"noise_deg", options.search.placement_sigma_rotation * 180 / M_PI},
                    {"com_noise_mm", 1e3 * options.search.com_sigma},
                    {"perturbations", options.search.perturbations},
                    {"seed", options.seed}});
  for (const StonePool& pool : read_pools(options.pools)) {
    std::vector<Try> tries;
    for (int k = 0; static_cast<int>(tries.size()) < options.placements && k < options.placements; ++k)
      try_tower(options, pool, k, &tries);
    report_pool(pool, tries, results);
  }
}

}  // namespace

void add_calibration(CLI::App& app) {
  auto options = std::make_shared<BenchOptions>();
  CLI::App* sub = app.add_subcommand("calibration", "Predicted against observed success of noisy placements");
  sub->add_option("--placements", options->placements, "At least, from each pool")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  sub->add_option("--stones", options->stones, "A tower")->check(CLI::Range(1, 100))->capture_default_str();
  sub->add_option("--repeats", options->repeats, "Times that each pose is tried")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  sub->add_option("--friction", options->search.friction, "Of the planner and of the world")
      ->check(CLI::Range(1e-3, 2.0))
      ->capture_default_str();
  sub->add_option("--seed", options->seed)->check(CLI::NonNegativeNumber)->capture_default_str();
  options->pools.register_on(*sub);
  options->settings.register_on(*sub);
  sub->footer(
      "Example:\n"
      "  stonestack-bench calibration --set search.placement_sigma_translation=0.002 "
      "--set search.placement_sigma_rotation=0.035");
  measure_by(*sub, [options](Results& results) {
    options->settings.apply(nest("search", fields(options->search)));
    measure(*options, results);
  });
}

}  // namespace stonestack::bench
