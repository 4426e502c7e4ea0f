// Walls of drawn stones, planned with exact placement or built beside their plan: how many of the stones that
// were asked for stand, in this library's engine and in another one, and what the wall is like.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numeric>

#include "bench.hpp"
#include "growth.hpp"
#include "put_down.hpp"
#include "stacking/choose_in_wall.hpp"
#include "stacking/settle_stack.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/search/plan_wall.hpp"
#include "wall_growth.hpp"
#include "walls.hpp"

namespace stonestack::bench {
namespace {

constexpr double kSamePlace = 0.012;  // m: a stone that fell there, or was taken off, is not set down again
constexpr int kMaxFallen = 3;         // stones that fall, until a wall is given up

struct WallBenchOptions : StructureBenchOptions {
  std::vector<int> courses{4, 3, 2, 1};
  double length = 0.0;
  int levels = 3;
  int take_off = 0;
  double noise = 0.0, noise_turn = 0.0;  // mm, deg: one sigma along and about each axis
  std::vector<int> growth;               // stones that stand; empty: no growth is measured
  std::string plot;
};

/// A planned or built wall and what became of it.
struct WallOutcome {
  WallMetrics metrics;
  std::string reason;  ///< what stood in the way of more
  int stands = 0;      ///< stones that moved by less than the limits in this library's engine
  int fallen = 0;      ///< stones that were set down in vain
  int taken_off = 0;   ///< stones taken off again
  OdeVerdict ode;
  double cpu = 0.0;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(WallOutcome, metrics, reason, stands, fallen, taken_off, ode, cpu)

bool is_noisy(const WallBenchOptions& options) {
  return options.noise > 0.0 || options.noise_turn > 0.0;
}

WallTarget target_of(const WallBenchOptions& options) {
  WallTarget target;
  if (options.length > 0.0) {
    target.length = options.length;
    target.levels = options.levels;
  } else {
    target.courses = options.courses;
  }
  return is_noisy(options) ? stacking::wall_for_arm(target) : target;
}

/// A wall that is built stone by stone, beside where each was planned, and planned anew from what stands.
class NoisyWall {
 public:
  NoisyWall(const WallBenchOptions& options, const StonePool& pool, int k)
      : options_(options),
        pool_(pool),
        target_(target_of(options)),
        problem_(draw_problem(pool, options.seed, k, options.stones)),
        random_(Random::stream(static_cast<std::uint64_t>(options.seed), concat("noise of wall ", k))) {
    noise_.shift = 1e-3 * options.noise;
    noise_.turn = options.noise_turn * M_PI / 180.0;
    noise_.friction = options.search.friction;
    problem_.reachable = [this](StoneIndex stone, const Pose& T_W_O, const Stack&) {
      return std::none_of(given_up_.begin(), given_up_.end(), [&](const PlacedStone& other) {
        return other.stone == stone && (other.T_W_O.translation() - T_W_O.translation()).norm() < kSamePlace;
      });
    };
  }

  void build() {
    while (!is_whole() && !interrupt_noted()) {
      const WallPlan plan = plan_on_what_stands();
      reason_ = plan.reason;
      if (plan.placements.empty() ? !take_off() : !set_down(plan)) break;
    }
  }
  [[nodiscard]] const Stack& stack() const { return problem_.stack; }
  [[nodiscard]] WallOutcome outcome() const {
    WallOutcome outcome;
    if (begun_) outcome.metrics = measure_wall(problem_, target_, *begun_, options_.search);
    outcome.metrics.asked = asked();
    outcome.reason = reason_;
    outcome.fallen = fallen_;
    outcome.taken_off = taken_off_;
    return outcome;
  }

 private:
  [[nodiscard]] int asked() const {
    return std::accumulate(target_.courses.begin(), target_.courses.end(), 0);
  }
  [[nodiscard]] bool is_whole() const {
    return asked() > 0 && problem_.stack.stones.size() >= static_cast<std::size_t>(asked());
  }

  /// Plans upon the stack as it settles in the planner's shapes, or else held where it is, as the loop does.
  [[nodiscard]] WallPlan plan_on_what_stands() const {
    SearchProblem here = problem_;
    if (!here.stack.stones.empty()) {
      const auto resting = stacking::resting_stacks(*here.shapes, here.stack, options_.search,
                                                    {options_.search.friction}, false);
      if (const auto& at_rest = resting.front().stack)
        here.stack = *at_rest;
      else
        here.held = static_cast<int>(here.stack.stones.size());
    }
    return plan_wall(here, target_, options_.search, {}, begun_);
  }

  /// @return false where the wall falls, or too many stones did
  bool set_down(const WallPlan& plan) {
    const WallPlacement& next = plan.placements.front();
    if (!begun_) begun_ = WallBegun{plan.T_W_V, {}, {}};
    const auto higher = set_down_in_wall(pool_.fine, problem_.stack, next.placement, noise_, random_);
    if (!higher) {
      reason_ = "the wall falls";
      return false;
    }
    if (higher->stones.size() == problem_.stack.stones.size()) {
      problem_.stack = *higher;
      begun_->rest.clear();
      given_up_.push_back({next.placement.stone, next.placement.T_W_O});
      if (++fallen_ <= kMaxFallen) return true;
      reason_ = "too many stones fell";
      return false;
    }
    problem_.stack = *higher;
    begun_->courses.push_back(next.course);
    begun_->rest.assign(plan.placements.begin() + 1, plan.placements.end());
    std::erase_if(problem_.available,
                  [&](const PlacedStone& stone) { return stone.stone == next.placement.stone; });
    return true;
  }

  /// Takes the last stone off, if without it more can be built than stands now.
  bool take_off() {
    if (problem_.stack.stones.empty() || taken_off_ >= options_.take_off) return false;
    const SearchProblem before = problem_;
    const std::optional<WallBegun> begun_before = begun_;
    given_up_.push_back(problem_.stack.stones.back());
    problem_.available.push_back(problem_.stack.stones.back());
    problem_.stack.stones.pop_back();
    begun_->courses.pop_back();
    begun_->rest.clear();
    const WallPlan plan = plan_on_what_stands();
    if (plan.placements.size() > 1) {
      ++taken_off_;
      begun_->rest = plan.placements;
      return true;
    }
    problem_ = before;
    begun_ = begun_before;
    return false;
  }

  const WallBenchOptions& options_;
  const StonePool& pool_;
  WallTarget target_;
  SearchProblem problem_;
  Random random_;
  PlacementNoise noise_;
  std::optional<WallBegun> begun_;
  std::vector<PlacedStone> given_up_;
  std::string reason_;
  int fallen_ = 0, taken_off_ = 0;
};

WallOutcome plan_and_judge(const WallBenchOptions& options, const StonePool& pool, int k) {
  const double start = processor_seconds();
  WallOutcome outcome;
  Stack wall;
  if (is_noisy(options)) {
    NoisyWall noisy(options, pool, k);
    noisy.build();
    outcome = noisy.outcome();
    wall = noisy.stack();
  } else {
    const WallPlan plan =
        plan_wall(draw_problem(pool, options.seed, k, options.stones), target_of(options), options.search);
    outcome.metrics = plan.metrics;
    outcome.reason = plan.reason;
    for (const WallPlacement& p : plan.placements)
      wall.stones.push_back({p.placement.stone, p.placement.T_W_O});
  }
  outcome.cpu = processor_seconds() - start;
  if (wall.stones.empty()) return outcome;
  StandOptions stand;
  stand.friction = options.search.friction;
  stand.seconds = options.judges.stand_seconds;
  const StandVerdict verdict = judge_stack(pool.fine, wall, stand);
  outcome.stands = verdict.stands ? static_cast<int>(wall.stones.size()) : verdict.standing;
  OdeOptions in_ode = options.judges.in_ode;
  in_ode.friction = options.search.friction;
  if (options.judges.ode) outcome.ode = stand_in_ode(pool.fine, wall, in_ode);
  return outcome;
}

void report_wall(int draw, const WallOutcome& outcome) {
  const WallMetrics& m = outcome.metrics;
  std::fprintf(stderr,
               "draw %d: %d of %d stones, %d stand, %d fell, %d taken off, ODE %d (%.2f mm), margin %.3f g, "
               "fill %.2f, face %.2f, "
               "open joints "
               "%d of %d, flat %.1f mm, height %.0f mm, CPU %.1f s%s%s\n",
               draw, m.placed, m.asked, outcome.stands, outcome.fallen, outcome.taken_off,
               outcome.ode.standing, 1e3 * outcome.ode.shift, m.margin, m.fill, m.face, m.open_joints,
               m.joints, 1e3 * m.flatness, 1e3 * m.height, outcome.cpu, outcome.reason.empty() ? "" : "; ",
               outcome.reason.c_str());
}

std::vector<TableValue> wall_cells(const WallBenchOptions& options, const std::string& pool,
                                   const std::vector<WallOutcome>& outcomes) {
  int whole = 0, stand = 0, in_ode = 0, stones = 0, joints = 0, open = 0;
  double margin = 0.0, fill = 0.0, face = 0.0, flat = 0.0, cpu = 0.0;
  const auto n = static_cast<double>(outcomes.size());
  for (const WallOutcome& outcome : outcomes) {
    const WallMetrics& m = outcome.metrics;
    const bool is_whole = m.placed > 0 && m.placed >= m.asked;
    whole += is_whole ? 1 : 0;
    stand += is_whole && outcome.stands == m.placed ? 1 : 0;
    in_ode += is_whole && outcome.ode.standing == m.placed ? 1 : 0;
    stones += m.placed;
    joints += m.joints;
    open += m.open_joints;
    margin += m.margin / n;
    fill += m.fill / n;
    face += m.face / n;
    flat += 1e3 * m.flatness / n;
    cpu += outcome.cpu;
  }
  std::vector<TableValue> cells{pool,       outcomes.size(), whole, stand,
                                stones / n, margin,          fill,  face,
                                open,       joints,          flat,  cpu / std::max(1, stones)};
  if (options.judges.ode) cells.emplace_back(in_ode);
  return cells;
}

void measure_walls(const WallBenchOptions& options, Results& results, Draws& draws) {
  const SearchOptions& s = options.search;
  std::string courses;
  for (const int count : options.courses) courses += concat(courses.empty() ? "" : "+", count);
  results.settings({{"draws", options.draws},
                    {"stones", options.stones},
                    {"courses", options.length > 0.0 ? std::to_string(options.levels) : courses},
                    {"length_m", options.length},
                    {"friction", s.friction},
                    {"perturbations", s.perturbations},
                    {"stand_s", options.judges.stand_seconds},
                    {"noise_mm", options.noise},
                    {"noise_turn_deg", options.noise_turn},
                    {"take_off", options.take_off},
                    {"seed", options.seed}});
  std::vector<Column> columns{{"stones"},      {"draws"},    {"whole"},       {"whole_that_stand"},
                              {"mean_stones"}, {"margin_g"}, {"fill"},        {"face"},
                              {"open_joints"}, {"joints"},   {"flatness_mm"}, {"cpu_s_a_stone", 1}};
  if (options.judges.ode) columns.push_back({"whole_that_stand_in_ode"});
  results.table("walls", columns);
  for (const StonePool& pool : read_pools(options.pools, draws)) {
    const std::vector<WallOutcome> outcomes = draws.outcomes(pool.name, options.draws, [&](int k) {
      WallOutcome outcome = plan_and_judge(options, pool, k);
      if (!interrupt_noted()) report_wall(k, outcome);
      return outcome;
    });
    if (!outcomes.empty()) results.row(wall_cells(options, pool.name, outcomes));
  }
  throw_if_interrupted();
}

/// Cost of the next stone by the number of stones that stand.
void measure_growth(const WallBenchOptions& options, Results& results, Draws& draws) {
  results.settings({{"stones", options.stones},
                    {"friction", options.search.friction},
                    {"perturbations", options.search.perturbations},
                    {"seed", options.seed}});
  std::vector<CostPoint> last;
  std::vector<std::pair<std::string, double>> exponents;
  results.table("cost of the next stone",
                {{"stones"}, {"that_stand"}, {"planned"}, {"to_begin_cpu_s", 1}, {"cpu_s_a_stone", 1}});
  for (const StonePool& pool : read_pools(options.pools, draws)) {
    last.clear();
    for (const GrowthPoint& point : measure_wall_growth(options, pool, options.growth, draws)) {
      results.row({pool.name, point.standing, point.planned, point.set_up, point.each});
      last.push_back({static_cast<double>(point.standing), point.each});
    }
    throw_if_interrupted();
    exponents.emplace_back(pool.name, growth_exponent(last));
  }
  results.table("growth, 1: linear", {{"stones"}, {"exponent"}});
  for (const auto& [pool, exponent] : exponents) results.row({pool, exponent});
  if (!options.plot.empty())
    write_file(options.plot, growth_plot(last, "stones that stand", "CPU seconds of the next stone"));
}

}  // namespace

void StructureBenchOptions::register_on(CLI::App& command) {
  command.add_option("--draws", draws, "Sets of stones from each pool")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  command.add_option("--stones", stones, "Stones a set")->check(CLI::Range(1, 1000))->capture_default_str();
  command.add_option("--friction", search.friction, "Of the planner and of the worlds that judge")
      ->check(CLI::Range(1e-3, 2.0))
      ->capture_default_str();
  pools.register_on(command);
  judges.register_on(command);
  command.add_option("--seed", seed)->check(CLI::Range(0, 2147483647))->capture_default_str();
  settings.register_on(command);
}

void add_walls(CLI::App& app) {
  auto options = std::make_shared<WallBenchOptions>();
  CLI::App* sub =
      app.add_subcommand("walls", "Planned walls: whole, standing, figures of the wall, time a stone");
  sub->add_option("--courses", options->courses, "Stones of each course, from the table up")
      ->delimiter('+')
      ->capture_default_str();
  sub->add_option("--length", options->length, "Length of a straight wall instead, m; 0: --courses")
      ->check(CLI::Range(0.0, 100.0))
      ->capture_default_str();
  sub->add_option("--levels", options->levels, "Courses of a straight wall")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  sub->add_option("--noise", options->noise, "Of each placement, one sigma along each axis, mm")
      ->check(CLI::Range(0.0, 50.0))
      ->capture_default_str();
  sub->add_option("--noise-turn", options->noise_turn, "Of each placement, one sigma about each axis, deg")
      ->check(CLI::Range(0.0, 45.0))
      ->capture_default_str();
  sub->add_option("--take-off", options->take_off,
                  "With --noise: stones that may be taken off where nothing fits")
      ->check(CLI::Range(0, 100))
      ->capture_default_str();
  CLI::Option* const growth =
      sub->add_option("--growth", options->growth, "Instead: cost of the next stone where so many stand")
          ->delimiter(',')
          ->check(CLI::Range(1, 1000));
  sub->add_option("--plot", options->plot, "Plot of --growth, of the last pool")
      ->type_name("SVG")
      ->needs(growth);
  options->register_on(*sub);
  sub->footer(
      "Examples:\n"
      "  stonestack-bench walls --growth 20,50,100,200 --scans none --generated 30 --stones 30 --friction "
      "0.3 --plot growth.svg\n"
      "  stonestack-bench walls --draws 20 --generated 0 --friction 0.3 --ode\n"
      "  stonestack-bench walls --draws 5 --generated 0 --stones 40 --length 0.8 --levels 3 --friction 0.3");
  measure_draws_by(*sub, [options](Results& results, Draws& draws) {
    options->settings.apply(nest("search", fields(options->search)));
    if (!options->growth.empty()) return measure_growth(*options, results, draws);
    measure_walls(*options, results, draws);
  });
}

}  // namespace stonestack::bench
