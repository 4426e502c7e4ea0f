// Walls of drawn stones, planned with exact placement: how many of the stones that were asked for stand, in
// this library's engine and in another one, and what the wall is like.
#include <cstdio>
#include <memory>

#include "bench.hpp"
#include "growth.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/search/plan_wall.hpp"
#include "wall_growth.hpp"
#include "walls.hpp"

namespace stonestack::bench {
namespace {

struct WallBenchOptions : StructureBenchOptions {
  std::vector<int> courses{4, 3, 2, 1};
  double length = 0.0;
  int levels = 3;
  std::vector<int> growth;  // stones that stand; empty: no growth is measured
  std::string plot;
};

/// A planned wall and what became of it.
struct WallOutcome {
  WallMetrics metrics;
  std::string reason;  ///< what stood in the way of more
  int stands = 0;      ///< stones that moved by less than the limits in this library's engine
  OdeVerdict ode;
  double cpu = 0.0;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(WallOutcome, metrics, reason, stands, ode, cpu)

WallOutcome plan_and_judge(const WallBenchOptions& options, const StonePool& pool, int k) {
  const SearchProblem problem = draw_problem(pool, options.seed, k, options.stones);
  WallTarget target;
  if (options.length > 0.0) {
    target.length = options.length;
    target.levels = options.levels;
  } else {
    target.courses = options.courses;
  }
  const double start = processor_seconds();
  WallOutcome outcome;
  const WallPlan plan = plan_wall(problem, target, options.search);
  outcome.cpu = processor_seconds() - start;
  outcome.metrics = plan.metrics;
  outcome.reason = plan.reason;
  Stack wall;
  for (const WallPlacement& p : plan.placements)
    wall.stones.push_back({p.placement.stone, p.placement.T_W_O});
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
               "draw %d: %d of %d stones, %d stand, ODE %d (%.2f mm), margin %.3f g, fill %.2f, face %.2f, "
               "open joints "
               "%d of %d, flat %.1f mm, height %.0f mm, CPU %.1f s%s%s\n",
               draw, m.placed, m.asked, outcome.stands, outcome.ode.standing, 1e3 * outcome.ode.shift,
               m.margin, m.fill, m.face, m.open_joints, m.joints, 1e3 * m.flatness, 1e3 * m.height,
               outcome.cpu, outcome.reason.empty() ? "" : "; ", outcome.reason.c_str());
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
