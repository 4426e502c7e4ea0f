// How the cost of the next stone of a wall grows with the stones that stand: each stone is planned alone, on
// what the plans before it have built.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>

#include "physics/shape.hpp"
#include "settings.hpp"
#include "stone_draws.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/search/plan_wall.hpp"
#include "walls.hpp"

namespace stonestack::bench {
namespace {

constexpr int kWindow = 5;  // stones whose times are averaged: they differ by how many proposals fail

struct WallGrowthOptions {
  std::vector<int> standing{20, 50, 100, 200};
  int base = 40, choices = 6, seed = 1;
  std::string plot;
  PoolOptions pools;
  SearchOptions search = search_without_robot();
  Settings settings;
};

/// One planned stone.
struct NextStone {
  int standing = 0;  ///< stones before it
  double cpu = 0.0;  ///< of its plan [s]
};

/// A wall that grows by one stone a plan; each course has a stone less than the one below.
class GrowingWall {
 public:
  GrowingWall(const WallGrowthOptions& options, const StonePool& pool)
      : options_(options),
        pool_(pool),
        random_(Random::stream(static_cast<std::uint64_t>(options.seed), "wall")) {
    // A stone may be in the wall many times: each time it is a stone of its own.
    const std::size_t needed =
        static_cast<std::size_t>(options.standing.back() + 1) * static_cast<std::size_t>(options.choices);
    for (std::size_t k = 0; k < needed; ++k)
      shapes_.push_back(pool_.shapes[random_.index(pool_.shapes.size())]);
  }

  /// Plans the next stone; empty where there is none.
  [[nodiscard]] std::optional<NextStone> add() {
    SearchProblem problem;
    problem.shapes = &shapes_;
    problem.stack = stack_;
    problem.stack_is_at_rest = true;
    for (int k = 0; k < options_.choices; ++k)
      problem.available.push_back(
          {StoneIndex(next_++), make_pose(Eigen::Vector3d(0.5, 0, 0.1), random_.rotation())});
    const auto standing = static_cast<int>(stack_.stones.size());
    WallTarget target;
    target.courses = courses_;
    if (target.courses.empty() ||
        target.courses.back() == options_.base + 1 - static_cast<int>(courses_.size()))
      target.courses.push_back(0);
    ++target.courses.back();
    const double start = processor_seconds();
    const WallPlan plan = plan_wall(problem, target, options_.search, {},
                                    begun_.courses.empty() ? std::optional<WallBegun>() : begun_);
    const double cpu = processor_seconds() - start;
    if (plan.placements.empty()) return {};
    courses_ = target.courses;
    begun_.T_W_V = plan.T_W_V;
    begun_.courses.push_back(plan.placements.front().course);
    stack_.stones.push_back(
        {plan.placements.front().placement.stone, plan.placements.front().placement.T_W_O});
    return NextStone{standing, cpu};
  }

 private:
  const WallGrowthOptions& options_;
  const StonePool& pool_;
  Random random_;
  ShapeList shapes_;
  Stack stack_;
  WallBegun begun_;
  std::vector<int> courses_;
  int next_ = 0;
};

/// Mean CPU time of the last stones before `standing` stand.
TableValue time_at(const std::vector<NextStone>& stones, int standing) {
  double sum = 0.0;
  int count = 0;
  for (const NextStone& stone : stones) {
    if (stone.standing > standing || stone.standing <= standing - kWindow) continue;
    sum += stone.cpu;
    ++count;
  }
  return count == kWindow ? TableValue(sum / count) : TableValue();
}

/// CPU time against stones that stand.
std::string growth_svg(const std::vector<NextStone>& stones) {
  constexpr double kWidth = 640.0, kHeight = 400.0, kEdge = 50.0;
  double slowest = 1e-9;
  for (const NextStone& stone : stones) slowest = std::max(slowest, stone.cpu);
  const double last = std::max(1, stones.back().standing);
  const auto x = [&](double standing) { return kEdge + (kWidth - 2 * kEdge) * standing / last; };
  const auto y = [&](double cpu) { return kHeight - kEdge - (kHeight - 2 * kEdge) * cpu / slowest; };
  std::string text =
      concat("<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 ", kWidth, ' ', kHeight,
             "' font-family='sans-serif' font-size='12'>\n<path fill='none' stroke='black' d='M", kEdge, ' ',
             kEdge, 'V', kHeight - kEdge, 'H', kWidth - kEdge, "'/>\n<text x='", kEdge, "' y='", kEdge - 10,
             "'>CPU time of the next stone, up to ", slowest, " s</text>\n<text x='", kWidth - kEdge, "' y='",
             kHeight - kEdge + 20, "' text-anchor='end'>stones that stand, up to ", last, "</text>\n");
  for (const NextStone& stone : stones)
    text += concat("<circle r='2.5' cx='", x(stone.standing), "' cy='", y(stone.cpu), "'/>\n");
  return text + "</svg>\n";
}

void measure_growth(const WallGrowthOptions& options, Results& results) {
  require(std::is_sorted(options.standing.begin(), options.standing.end()), "--standing: numbers that rise");
  results.settings({{"base", options.base},
                    {"choices", options.choices},
                    {"friction", options.search.friction},
                    {"seed", options.seed}});
  results.table("next stone of a wall", {{"stones"}, {"standing"}, {"cpu_s", 2}, {"ms_a_standing_stone", 1}});
  for (StonePool pool : read_pool_stones(options.pools)) {
    pool.shapes = make_contact_shapes(pool.stones);
    GrowingWall wall(options, pool);
    std::vector<NextStone> stones;
    while (stones.empty() || stones.back().standing < options.standing.back()) {
      const auto next = wall.add();
      if (interrupt_noted()) break;
      if (!next) {
        results.note("%s: no place for stone %zu", pool.name.c_str(), stones.size() + 1);
        break;
      }
      stones.push_back(*next);
      std::fprintf(stderr, "%d stand: CPU %.2f s\n", next->standing, next->cpu);
    }
    for (const int standing : options.standing) {
      const TableValue cpu = time_at(stones, standing);
      const auto* seconds = std::get_if<double>(&cpu.value());
      results.row({pool.name, standing, cpu,
                   seconds == nullptr ? TableValue() : TableValue(1e3 * *seconds / standing)});
    }
    if (!options.plot.empty() && !stones.empty()) write_file(options.plot, growth_svg(stones));
  }
  throw_if_interrupted();
}

}  // namespace

void add_wall_growth(CLI::App& app) {
  auto options = std::make_shared<WallGrowthOptions>();
  CLI::App* sub =
      app.add_subcommand("wall-growth", "CPU time of the next stone of a wall against the stones that stand");
  sub->add_option("--standing", options->standing, "Stones that stand, rising")
      ->delimiter(',')
      ->check(CLI::Range(kWindow, 1000))
      ->capture_default_str();
  sub->add_option("--base", options->base, "Stones of the lowest course; each course has one less")
      ->check(CLI::Range(2, 200))
      ->capture_default_str();
  sub->add_option("--choices", options->choices, "Loose stones that each is chosen from")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  sub->add_option("--friction", options->search.friction, "Of the planner")
      ->check(CLI::Range(1e-3, 2.0))
      ->capture_default_str();
  sub->add_option("--plot", options->plot, "Write the times of all stones as SVG")->type_name("FILE");
  options->pools.register_on(*sub);
  sub->add_option("--seed", options->seed)->check(CLI::Range(0, 2147483647))->capture_default_str();
  options->settings.register_on(*sub);
  sub->footer(
      "A row is the mean of the five stones up to it.\n"
      "Example:\n"
      "  stonestack-bench wall-growth --generated 0 --friction 0.3 --plot growth.svg");
  measure_by(*sub, [options](Results& results) {
    options->settings.apply(nest("search", fields(options->search)));
    measure_growth(*options, results);
  });
}

}  // namespace stonestack::bench
