// Tasks in the manner of "Learning to Build" (spans, corbels, counterweights, lintels, a table over a gap)
// with rubble: how many are done with exact placement, and stand in this library's engine and in another one.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>

#include "bench.hpp"
#include "physics/shape.hpp"
#include "search/wall/span_search.hpp"
#include "span_check.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "walls.hpp"

namespace stonestack::bench {
namespace {

namespace fs = std::filesystem;

constexpr double kMarginAsked = 0.02;   // g in 16 directions
constexpr double kBesideCarry = 0.030;  // m from the place of the stone that is carried
constexpr int kDirections = 16;
constexpr double kInTheWay = 0.002;     // m that a stone may sag into what is kept clear
constexpr double kBlockFriction = 0.4;  // of all contacts, unless --friction says otherwise

struct TaskBenchOptions : StructureBenchOptions {
  std::string folder;
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
  WallMetrics metrics;
  std::string reason;       ///< what stood in the way of more
  double covered = 0.0;     ///< least share of a span, by lines every millimetre
  double in_the_way = 0.0;  ///< [m] that stones reach into what is kept clear
  bool carried = true;      ///< a stone lies where the task wants one
  double margin = 0.0;      ///< of all stones and blocks, by statics on the fine shapes [g]
  bool in_bullet = false, in_ode = false;
  double cpu = 0.0;

  [[nodiscard]] bool done() const {
    return reason.empty() && covered >= 1.0 && in_the_way < kInTheWay && carried;
  }
  [[nodiscard]] bool good(bool ode) const {
    return done() && in_bullet && (in_ode || !ode) && margin >= kMarginAsked;
  }
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(TaskOutcome, metrics, reason, covered, in_the_way, carried, margin,
                                   in_bullet, in_ode, cpu)

/// Can stones stand on that side of a span?
bool has_side(const SpanTask& task, const Span& span, bool left) {
  return task.on_table || std::any_of(task.supports.begin(), task.supports.end(), [&](const auto& block) {
           return left ? block.to <= span.from : block.from >= span.to;
         });
}

/// Coverage of the spans: where both sides can carry, by stones that stand on both.
void check_spans(const ShapeList& shapes, const Stack& all, const Pose& T_V_W, const SpanTask& task,
                 TaskOutcome& outcome) {
  outcome.covered = 1.0;
  for (const Span& span : task.spans) {
    const bool both = has_side(task, span, true) && has_side(task, span, false);
    const Stack over = both ? bridging_stones(shapes, all, T_V_W, span) : all;
    outcome.covered = std::min(outcome.covered, check_span(shapes, over, T_V_W, span).covered);
    outcome.in_the_way = std::max(outcome.in_the_way, check_span(shapes, all, T_V_W, span).in_the_way);
  }
}

/// Does a stone that is not needed to cover the spans have its centre of mass where one is to be carried?
bool is_carried(const ShapeList& shapes, const Stack& all, const Pose& T_V_W, const SpanTask& task) {
  for (std::size_t k = task.supports.size(); k < all.stones.size(); ++k) {
    const PlacedStone& stone = all.stones[k];
    const Eigen::Vector3d p_V = T_V_W * stone.T_W_O * at(shapes, stone.stone)->mass.p_O_M;
    if (std::abs(p_V.x() - *task.carry) > kBesideCarry) continue;
    Stack others = all;
    others.stones.erase(others.stones.begin() + static_cast<std::ptrdiff_t>(k));
    TaskOutcome without;
    check_spans(shapes, others, T_V_W, task, without);
    if (without.covered >= 1.0) return true;
  }
  return false;
}

TaskOutcome plan_and_judge(const TaskBenchOptions& options, const StonePool& pool, const WallTarget& target,
                           int draw) {
  const SearchProblem problem = draw_problem(pool, options.seed, draw, options.stones);
  const double start = processor_seconds();
  TaskOutcome outcome;
  const WallPlan plan = plan_wall(problem, target, options.search);
  outcome.cpu = processor_seconds() - start;
  outcome.metrics = plan.metrics;
  outcome.reason = plan.reason;
  ShapeList shapes = pool.fine;
  Stack all;
  const TaskSupports supports = make_supports(*target.task);
  for (std::size_t k = 0; k < supports.shapes.size(); ++k) {
    all.stones.push_back({StoneIndex(static_cast<int>(shapes.size())), plan.T_W_V * supports.T_V_O[k]});
    shapes.push_back(supports.shapes[k]);
  }
  for (const WallPlacement& p : plan.placements) all.stones.push_back({p.placement.stone, p.placement.T_W_O});
  if (plan.placements.empty()) return outcome;
  const Pose T_V_W = plan.T_W_V.inverse();
  check_spans(shapes, all, T_V_W, *target.task, outcome);
  if (target.task->carry) outcome.carried = is_carried(shapes, all, T_V_W, *target.task);
  EquilibriumOptions statics;
  statics.friction = options.search.friction;
  statics.directions = kDirections;
  statics.min_friction = false;
  const Equilibrium balance = stack_equilibrium(shapes, all, statics);
  outcome.margin = balance.stands ? balance.margin : 0.0;
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

void report_task(const std::string& name, int draw, const TaskOutcome& outcome) {
  std::fprintf(stderr,
               "%s, draw %d: %d stones, %.0f of %.0f mm, covered %.2f, %.1f mm in the way, margin %.3f "
               "g, Bullet %d, ODE %d%s%s\n",
               name.c_str(), draw, outcome.metrics.placed, 1e3 * outcome.metrics.spanned,
               1e3 * outcome.metrics.to_span, outcome.covered, 1e3 * outcome.in_the_way, outcome.margin,
               outcome.in_bullet ? 1 : 0, outcome.in_ode ? 1 : 0, outcome.reason.empty() ? "" : "; ",
               outcome.reason.c_str());
}

void measure_tasks(const TaskBenchOptions& options, Results& results, Draws& draws) {
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
  for (const StonePool& pool : read_pools(options.pools, draws)) {
    results.table("tasks", columns);
    int solved = 0;
    for (const NamedTask& task : tasks) {
      int done = 0, stand = 0, in_ode = 0, good = 0, stones = 0;
      double margin = 0.0, cpu = 0.0;
      const auto outcomes = draws.outcomes(concat(pool.name, ' ', task.name), options.draws, [&](int k) {
        TaskOutcome outcome = plan_and_judge(options, pool, task.target, k);
        if (!interrupt_noted()) report_task(task.name, k, outcome);
        return outcome;
      });
      throw_if_interrupted();
      if (outcomes.empty()) continue;
      const auto count = static_cast<int>(outcomes.size());
      for (const TaskOutcome& outcome : outcomes) {
        done += outcome.done() ? 1 : 0;
        stand += outcome.done() && outcome.in_bullet ? 1 : 0;
        in_ode += outcome.done() && outcome.in_ode ? 1 : 0;
        good += outcome.good(ode) ? 1 : 0;
        stones += outcome.metrics.placed;
        margin += outcome.margin / count;
        cpu += outcome.cpu;
      }
      solved += 2 * good > count ? 1 : 0;
      std::vector<TableValue> cells{pool.name,
                                    task.name,
                                    count,
                                    done,
                                    stand,
                                    good,
                                    static_cast<double>(stones) / count,
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
  options->draws = 3;
  options->stones = 10;
  options->register_on(*sub);
  sub->footer(
      "Examples:\n"
      "  stonestack-bench tasks --generated 0 --ode\n"
      "  stonestack-bench tasks --scans none --generated 30 --draws 5 --ode\n"
      "Good: all spans covered, nothing stands in them, all stones and blocks stay where they are, and the "
      "whole "
      "bears\n0.02 g in 16 directions.");
  measure_draws_by(*sub, [options](Results& results, Draws& draws) {
    options->settings.apply(nest("search", fields(options->search)));
    measure_tasks(*options, results, draws);
  });
}

}  // namespace stonestack::bench
