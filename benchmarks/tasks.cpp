// Tasks in the manner of "Learning to Build" (spans, corbels, counterweights, lintels, a table over a gap)
// with rubble: how many are done with exact placement, and stand in this library's engine and in another one.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "bench.hpp"
#include "ode_witness.hpp"
#include "physics/shape.hpp"
#include "search/wall/span_search.hpp"
#include "settings.hpp"
#include "span_check.hpp"
#include "stone_draws.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "walls.hpp"

namespace stonestack::bench {
namespace {

namespace fs = std::filesystem;

constexpr double kMarginAsked = 0.02;   // g in 16 directions
constexpr double kInTheWay = 0.002;     // m that a stone may sag into what is kept clear
constexpr double kBlockFriction = 0.4;  // of all contacts, unless --friction says otherwise

struct TaskBenchOptions {
  std::string folder;
  int draws = 3, stones = 10, seed = 1;
  Judges judges;
  PoolOptions pools;
  SearchOptions search = search_without_robot();
  Settings settings;
};

/// A task and the name of its file.
struct NamedTask {
  std::string name;
  WallTarget target;
};

std::vector<NamedTask> read_tasks(const std::string& folder) {
  if (!fs::is_directory(folder)) throw FileError(folder, "is no folder", "give the folder of target files");
  std::vector<NamedTask> tasks;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() != ".yaml") continue;
    tasks.push_back({entry.path().stem().string(), read_wall_target(entry.path().string())});
    if (!tasks.back().target.task)
      throw FileError(entry.path().string(), "is a wall", "give targets with spans; walls: `bench walls`");
  }
  std::sort(tasks.begin(), tasks.end(), [](const auto& p, const auto& q) { return p.name < q.name; });
  if (tasks.empty()) throw FileError(folder, "holds no target files", "give a folder of *.yaml");
  return tasks;
}

/// A structure and what became of it.
struct TaskOutcome {
  WallPlan plan;
  double covered = 0.0;     ///< least share of a span, by lines every millimetre
  double in_the_way = 0.0;  ///< [m] that stones reach into what is kept clear
  bool in_bullet = false, in_ode = false;
  double cpu = 0.0;

  [[nodiscard]] bool done() const { return plan.reason.empty() && covered >= 1.0 && in_the_way < kInTheWay; }
  [[nodiscard]] bool good(bool ode) const {
    return done() && in_bullet && (in_ode || !ode) && plan.metrics.margin >= kMarginAsked;
  }
};

TaskOutcome plan_and_judge(const TaskBenchOptions& options, const StonePool& pool, const WallTarget& target,
                           int draw) {
  const SearchProblem problem = draw_problem(pool, options.seed, draw, options.stones);
  const double start = processor_seconds();
  TaskOutcome outcome;
  outcome.plan = plan_wall(problem, target, options.search);
  outcome.cpu = processor_seconds() - start;
  ShapeList shapes = pool.fine;
  Stack stones, all;
  const TaskSupports supports = make_supports(*target.task);
  for (std::size_t k = 0; k < supports.shapes.size(); ++k) {
    all.stones.push_back(
        {StoneIndex(static_cast<int>(shapes.size())), outcome.plan.T_W_V * supports.T_V_O[k]});
    shapes.push_back(supports.shapes[k]);
  }
  for (const WallPlacement& p : outcome.plan.placements)
    stones.stones.push_back({p.placement.stone, p.placement.T_W_O});
  if (stones.stones.empty()) return outcome;
  all.stones.insert(all.stones.end(), stones.stones.begin(), stones.stones.end());
  outcome.covered = 1.0;
  for (const Span& span : target.task->spans) {
    const SpanCheck check = check_span(pool.fine, stones, outcome.plan.T_W_V.inverse(), span);
    outcome.covered = std::min(outcome.covered, check.covered);
    outcome.in_the_way = std::max(outcome.in_the_way, check.in_the_way);
  }
  StandOptions stand;
  stand.friction = options.search.friction;
  stand.seconds = options.judges.stand_seconds;
  outcome.in_bullet = judge_stack(shapes, all, stand).stands;
  OdeOptions in_ode = options.judges.in_ode;
  in_ode.friction = options.search.friction;
  outcome.in_ode =
      options.judges.ode && stand_in_ode(shapes, all, in_ode).standing == static_cast<int>(all.stones.size());
  return outcome;
}

void measure_tasks(const TaskBenchOptions& options, Results& results) {
  results.settings({{"draws", options.draws},
                    {"stones", options.stones},
                    {"friction", options.search.friction},
                    {"perturbations", options.search.perturbations},
                    {"stand_s", options.judges.stand_seconds},
                    {"seed", options.seed}});
  const std::vector<NamedTask> tasks = read_tasks(options.folder);
  const bool ode = options.judges.ode;
  std::vector<Column> columns{{"stones"},         {"task"},     {"draws"},
                              {"done"},           {"stand"},    {"good"},
                              {"mean_stones", 1}, {"margin_g"}, {"cpu_s_a_stone", 1}};
  if (ode) columns.push_back({"stand_in_ode"});
  for (const StonePool& pool : read_pools(options.pools)) {
    results.table("tasks", columns);
    int solved = 0;
    for (const NamedTask& task : tasks) {
      int done = 0, stand = 0, in_ode = 0, good = 0, stones = 0;
      double margin = 0.0, cpu = 0.0;
      for (int k = 0; k < options.draws; ++k) {
        const TaskOutcome outcome = plan_and_judge(options, pool, task.target, k);
        throw_if_interrupted();
        done += outcome.done() ? 1 : 0;
        stand += outcome.done() && outcome.in_bullet ? 1 : 0;
        in_ode += outcome.done() && outcome.in_ode ? 1 : 0;
        good += outcome.good(ode) ? 1 : 0;
        stones += outcome.plan.metrics.placed;
        margin += outcome.plan.metrics.margin / options.draws;
        cpu += outcome.cpu;
        std::fprintf(stderr,
                     "%s, draw %d: %d stones, %.0f of %.0f mm, covered %.2f, %.1f mm in the way, margin %.3f "
                     "g, Bullet %d, ODE %d%s%s\n",
                     task.name.c_str(), k, outcome.plan.metrics.placed, 1e3 * outcome.plan.metrics.spanned,
                     1e3 * outcome.plan.metrics.to_span, outcome.covered, 1e3 * outcome.in_the_way,
                     outcome.plan.metrics.margin, outcome.in_bullet ? 1 : 0, outcome.in_ode ? 1 : 0,
                     outcome.plan.reason.empty() ? "" : "; ", outcome.plan.reason.c_str());
      }
      solved += 2 * good > options.draws ? 1 : 0;
      std::vector<TableValue> cells{pool.name,
                                    task.name,
                                    options.draws,
                                    done,
                                    stand,
                                    good,
                                    static_cast<double>(stones) / options.draws,
                                    margin,
                                    cpu / std::max(1, stones)};
      if (ode) cells.emplace_back(in_ode);
      results.row(cells);
    }
    results.table("tasks solved in most draws", {{"stones"}, {"tasks"}, {"solved"}});
    results.row({pool.name, tasks.size(), solved});
  }
}

}  // namespace

void add_tasks(CLI::App& app) {
  auto options = std::make_shared<TaskBenchOptions>();
  options->search.friction = kBlockFriction;
  CLI::App* sub =
      app.add_subcommand("tasks", "Spans, corbels, counterweights, lintels: done, standing, time a stone");
  options->folder = data_path("targets/tasks");
  sub->add_option("--folder", options->folder, "Target files")->capture_default_str();
  sub->add_option("--draws", options->draws, "Sets of stones for each task")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  sub->add_option("--stones", options->stones, "Stones a set")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  sub->add_option("--friction", options->search.friction, "Of the planner and of the worlds that judge")
      ->check(CLI::Range(1e-3, 2.0))
      ->capture_default_str();
  options->pools.register_on(*sub);
  options->judges.register_on(*sub);
  sub->add_option("--seed", options->seed)->check(CLI::Range(0, 2147483647))->capture_default_str();
  options->settings.register_on(*sub);
  sub->footer(
      "Examples:\n"
      "  stonestack-bench tasks --generated 0 --ode\n"
      "  stonestack-bench tasks --scans none --generated 30 --draws 5 --ode\n"
      "Good: all spans covered, nothing stands in them, all stones and blocks stay where they are, and the "
      "whole "
      "bears\n0.02 g in 16 directions.");
  measure_by(*sub, [options](Results& results) {
    options->settings.apply(nest("search", fields(options->search)));
    measure_tasks(*options, results);
  });
}

}  // namespace stonestack::bench
