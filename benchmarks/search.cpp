// How high does the search build, at what cost? Draws sets of stones, plans a tower with the default search
// and with the paper's at the same CPU time, and lets every tower stand 60 simulated seconds on the same
// contact features than the search used. With placement noise every stone is put down beside its target, and
// the rest of the tower is planned anew from what stands. With --attitudes the stones are known by models
// that were made of views, and put down as they truly are.
#include <memory>

#include "bench.hpp"
#include "modelled_stones.hpp"
#include "ode_witness.hpp"
#include "put_down.hpp"
#include "search/search_context.hpp"
#include "search_row.hpp"
#include "settings.hpp"
#include "stone_draws.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::bench {
namespace {

// As `run --unseen` looks at stones.
constexpr int kViews = 6;
constexpr double kLowestView = 1.05;  // rad off the vertical
constexpr double kOtherSide = 1.0;    // rad, between attitudes that show two sides of a stone

struct SearchBenchOptions {
  int draws = 10, stones = 4, seed = 1;
  bool paper = true;
  Judges judges;
  double noise = 0.0, noise_turn = 0.0;  // mm, deg: one sigma along and about each axis
  std::vector<int> attitudes;            // that stones are modelled from; empty: the scans are known
  PoolOptions pools;
  SearchOptions search = search_without_robot();
  Settings settings;
};

/// The worth of a tower: how many of its stones stay, clean, and how far it is from falling.
SearchOutcome witness(const SearchBenchOptions& options, const StonePool& pool, const Stack& tower) {
  SearchOutcome outcome;
  outcome.planned = static_cast<int>(tower.stones.size());
  if (tower.stones.empty()) return outcome;
  StandOptions stand;
  stand.friction = options.search.friction;
  stand.seconds = options.judges.stand_seconds;
  const StandVerdict verdict = judge_stack(pool.fine, tower, stand);
  outcome.clean = verdict.standing;
  outcome.reason = verdict.reason;
  EquilibriumOptions statics;
  statics.friction = options.search.friction;
  outcome.margin = stack_equilibrium(pool.fine, tower, statics).margin;
  outcome.shaken = standing_when_shaken(pool.fine, tower, stand);
  OdeOptions in_ode = options.judges.in_ode;
  in_ode.friction = options.search.friction;
  if (options.judges.ode) outcome.ode = stand_in_ode(pool.fine, tower, in_ode);
  return outcome;
}

/// A tower that was built, and what ended it.
struct BuiltTower {
  Stack stack;
  std::string reason;
};

/// Stones as towers are planned with them, in the order of the pool.
struct PlannedStones {
  ShapeList shapes;
  std::vector<ShapeList> possible;
  std::vector<Pose> T_scan_O;             ///< frames of the models in those of the scans
  std::vector<Eigen::Matrix3d> R_W_scan;  ///< attitudes in which they lie
};

std::optional<PlannedStones> planned_stones(const SearchBenchOptions& options, const StonePool& pool) {
  if (options.attitudes.empty()) return std::nullopt;
  std::vector<Stone> seen = pool.stones;
  for (Stone& stone : seen) stone.mesh = stone.scan;
  const SceneMaker maker(seen);
  std::vector<Stone> models;
  PlannedStones known;
  for (StoneFromViews& one : stones_from_views(maker, {options.attitudes, kViews, kLowestView, kOtherSide},
                                               static_cast<std::uint64_t>(options.seed))) {
    known.R_W_scan.push_back(one.R_W_scan);
    models.push_back(std::move(one.stone));
    known.T_scan_O.push_back(one.T_scan_O);
  }
  known.shapes = make_contact_shapes(models);
  known.possible = make_possible_shapes(models);
  return known;
}

/// The problem as it looks to who knows the models. What stands though by the models it cannot is held.
SearchProblem as_known(const PlannedStones& known, const SearchProblem& truth, const SearchOptions& search) {
  SearchProblem problem = truth;
  problem.shapes = &known.shapes;
  problem.possible_shapes = &known.possible;
  for (auto* list : {&problem.stack.stones, &problem.available})
    for (PlacedStone& stone : *list) stone.T_W_O = stone.T_W_O * at(known.T_scan_O, stone.stone);
  if (!problem.stack.stones.empty() && !search::settled_stack(known.shapes, problem.stack, search).stack)
    problem.held = static_cast<int>(problem.stack.stones.size());
  return problem;
}

Stack stack_of(const std::vector<Placement>& placements) {
  Stack stack;
  for (const Placement& placement : placements) stack.stones.push_back({placement.stone, placement.T_W_O});
  return stack;
}

/// Plans, puts down beside the plan, and plans anew. The first stone that falls ends it.
/// @param known the stones as they are planned with; null: as they are
BuiltTower build_step_by_step(const SearchBenchOptions& options, SearchProblem problem,
                              const SearchOptions& search, const PlannedStones* known, int k) {
  Random random = Random::stream(static_cast<std::uint64_t>(options.seed), concat("placement noise ", k));
  PlacementNoise noise;
  noise.shift = 1e-3 * options.noise;
  noise.turn = options.noise_turn * M_PI / 180.0;
  noise.friction = options.search.friction;
  if (known != nullptr)
    for (PlacedStone& stone : problem.available) stone.T_W_O.linear() = at(known->R_W_scan, stone.stone);
  std::string reason;
  while (!problem.available.empty()) {
    const SearchResult found =
        find_next_pose(known != nullptr ? as_known(*known, problem, search) : problem, search);
    reason = found.reason;
    if (found.best.empty()) break;
    Placement target = found.best.front();
    if (known != nullptr) target.T_W_O = target.T_W_O * at(known->T_scan_O, target.stone).inverse();
    // What is known in part comes to rest beside its plan, and is measured there.
    const auto set_down = known != nullptr ? set_down_in_wall : put_down;
    const auto higher = set_down(*problem.shapes, problem.stack, target, noise, random);
    if (!higher || higher->stones.size() == problem.stack.stones.size()) {
      reason = concat("stone ", problem.stack.stones.size() + 1, " fell, predicted success ",
                      target.predicted_success);
      break;
    }
    problem.stack = *higher;
    std::erase_if(problem.available, [&](const PlacedStone& s) { return s.stone == target.stone; });
  }
  return {problem.stack, reason};
}

BuiltTower build(const SearchBenchOptions& options, const SearchProblem& problem, const SearchOptions& search,
                 const PlannedStones* known, int k) {
  if (options.noise > 0.0 || options.noise_turn > 0.0 || known != nullptr)
    return build_step_by_step(options, problem, search, known, k);
  const TowerPlan planned = plan_tower(problem, options.stones, search);
  return {stack_of(planned.placements), planned.reason};
}

SearchOutcome run_default(const SearchBenchOptions& options, const StonePool& pool,
                          const PlannedStones* known, int k) {
  const SearchProblem problem = draw_problem(pool, options.seed, k, options.stones);
  const double start = processor_seconds();
  const Stopwatch watch;
  const auto [tower, reason] = build(options, problem, options.search, known, k);
  const double cpu = processor_seconds() - start, wall = watch.seconds();
  SearchOutcome outcome = witness(options, pool, tower);
  outcome.cpu = cpu;
  outcome.wall = wall;
  if (!reason.empty()) outcome.reason = reason;
  return outcome;
}

/// The paper's search; with exact placement restarted with new seeds until the CPU time is used, of which the
/// highest tower counts.
SearchOutcome run_paper(const SearchBenchOptions& options, const StonePool& pool, int k, double cpu) {
  const SearchProblem problem = draw_problem(pool, options.seed, k, options.stones);
  SearchOptions search = options.search;
  search.method = "paper";
  const bool noisy = options.noise > 0.0 || options.noise_turn > 0.0;
  const double start = processor_seconds();
  const Stopwatch watch;
  Stack best;
  double once = 0.0;
  int once_planned = 0;
  for (int pass = 0; pass == 0 || (!noisy && processor_seconds() - start < cpu); ++pass) {
    search.seed = options.search.seed + 1000 * pass;
    const Stack tower = build(options, problem, search, nullptr, k).stack;
    if (pass == 0) {
      once = watch.seconds();
      once_planned = static_cast<int>(tower.stones.size());
    }
    if (tower.stones.size() > best.stones.size()) best = tower;
    if (best.stones.size() == problem.available.size()) break;
  }
  const double used = processor_seconds() - start, wall = watch.seconds();
  SearchOutcome outcome = witness(options, pool, best);
  outcome.cpu = used;
  outcome.wall = wall;
  outcome.once = once;
  outcome.once_planned = once_planned;
  return outcome;
}

/// Rows on the candidates a CPU second of one thread, both methods, on the second level of the first draw.
std::vector<std::vector<TableValue>> measure_speed(const SearchBenchOptions& options, const StonePool& pool) {
  SearchOptions search = options.search;
  search.threads = 1;
  search.horizon = 1;
  SearchProblem problem = draw_problem(pool, options.seed, 0, options.stones);
  const SearchResult first = find_next_pose(problem, search);
  if (first.best.empty()) return {};
  problem.stack.stones.push_back({first.best.front().stone, first.best.front().T_W_O});
  std::vector<std::vector<TableValue>> rows;
  for (const char* method : {"default", "paper"}) {
    search.method = method;
    const double start = processor_seconds();
    const SearchResult found = find_next_pose(problem, search);
    const double cpu = processor_seconds() - start;
    rows.push_back({pool.name, method, found.candidates, cpu, static_cast<double>(found.candidates) / cpu});
  }
  return rows;
}

/// A draw by both methods.
struct DrawOutcome {
  SearchOutcome of_default, of_paper;
};
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(DrawOutcome, of_default, of_paper)

DrawOutcome perform_draw(const SearchBenchOptions& options, const StonePool& pool, const PlannedStones* known,
                         const SearchRow& of_search, const SearchRow& paper, int k) {
  DrawOutcome outcome;
  outcome.of_default = run_default(options, pool, known, k);
  if (interrupt_noted()) return outcome;
  report_draw(of_search, k, outcome.of_default);
  if (!options.paper) return outcome;
  outcome.of_paper = run_paper(options, pool, k, outcome.of_default.cpu);
  if (!interrupt_noted()) report_draw(paper, k, outcome.of_paper);
  return outcome;
}

std::string text_of(const std::vector<int>& attitudes) {
  std::string text;
  for (const int number : attitudes) text += concat(text.empty() ? "" : ",", number);
  return text.empty() ? "scans" : text;
}

std::vector<Figure> settings_of(const SearchBenchOptions& options) {
  const SearchOptions& s = options.search;
  std::vector<Figure> settings{{"draws", options.draws},
                               {"stones", options.stones},
                               {"friction", s.friction},
                               {"noise_mm", options.noise},
                               {"noise_deg", options.noise_turn},
                               {"attitudes", text_of(options.attitudes)},
                               {"objective", s.objective},
                               {"beam", s.beam},
                               {"rounds", s.rounds},
                               {"horizon", s.horizon},
                               {"planned_for_mm", 1e3 * s.placement_sigma_translation},
                               {"planned_for_deg", s.placement_sigma_rotation * 180 / M_PI},
                               {"stand_s", options.judges.stand_seconds},
                               {"seed", options.seed}};
  if (!options.judges.ode) return settings;
  const OdeOptions& o = options.judges.in_ode;
  settings.insert(settings.end(), {{"ode_s", o.seconds},
                                   {"ode_shift_max_mm", 1e3 * o.max_shift},
                                   {"ode_turn_max_deg", o.max_turn * 180 / M_PI},
                                   {"ode_step_ms", 1e3 * o.step}});
  return settings;
}

void measure(const SearchBenchOptions& options, Results& results, Draws& draws) {
  const SearchOptions& s = options.search;
  results.settings(settings_of(options));
  results.table("towers", search_columns(options.judges.ode));
  const std::vector<StonePool> pools = read_pools(options.pools, draws);
  std::vector<std::pair<std::string, std::vector<SearchOutcome>>> of_paper;
  for (const StonePool& pool : pools) {
    const SearchRow of_search{pool.name,    "default",          options.stones,
                              s.min_margin, options.judges.ode, options.judges.in_ode};
    const SearchRow paper{
        pool.name, "paper", options.stones, s.min_margin, options.judges.ode, options.judges.in_ode};
    const auto known = draws.performs() ? planned_stones(options, pool) : std::nullopt;
    const auto outcomes = draws.outcomes(pool.name, options.draws, [&](int k) {
      return perform_draw(options, pool, known ? &*known : nullptr, of_search, paper, k);
    });
    if (outcomes.empty()) continue;
    std::vector<SearchOutcome> by_default, by_paper;
    for (const DrawOutcome& outcome : outcomes) {
      by_default.push_back(outcome.of_default);
      by_paper.push_back(outcome.of_paper);
    }
    results.row(search_cells(of_search, by_default));
    if (!options.paper) continue;
    results.row(search_cells(paper, by_paper));
    of_paper.emplace_back(pool.name, std::move(by_paper));
  }
  if (!of_paper.empty())
    results.table(
        "one pass of the paper's search",
        {{"stones"}, {"s_a_run", 1}, {"s_a_stone", 1}, {"paper_s_a_run", 0}, {"paper_s_a_stone", 0}});
  for (const auto& [pool, outcomes] : of_paper) report_paper_time(pool, outcomes, results);
  throw_if_interrupted();  // the rows are of what was done
  results.table("one thread, second level of the first draw",
                {{"stones"}, {"method"}, {"candidates"}, {"cpu_s"}, {"candidates_per_s", 0}});
  for (const StonePool& pool : pools)
    for (const auto& rows :
         draws.outcomes(pool.name + " speed", 1, [&](int) { return measure_speed(options, pool); }))
      for (const auto& row : rows) results.row(row);
}

}  // namespace

void add_search(CLI::App& app) {
  auto options = std::make_shared<SearchBenchOptions>();
  CLI::App* sub =
      app.add_subcommand("search", "Heights, time and margins of planned towers; default beside paper");
  sub->add_option("--draws", options->draws, "Sets of stones from each pool")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  sub->add_option("--stones", options->stones, "Stones a set")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  sub->add_option("--friction", options->search.friction, "Of the planner and of the world that judges")
      ->check(CLI::Range(1e-3, 2.0))
      ->capture_default_str();
  sub->add_option("--noise", options->noise, "Placement noise, mm, one sigma along each axis; plans anew")
      ->check(CLI::Range(0.0, 50.0))
      ->capture_default_str();
  sub->add_option("--noise-turn", options->noise_turn, "Placement noise, deg, one sigma about each axis")
      ->check(CLI::Range(0.0, 30.0))
      ->capture_default_str();
  sub->add_option("--attitudes", options->attitudes,
                  "Plan with models made of views in so many attitudes, as run --unseen makes them: of the "
                  "first stone, the second, and again from the first number; without: with the scans")
      ->delimiter(',')
      ->check(CLI::Range(1, 10))
      ->type_name("N,N,...");
  options->pools.register_on(*sub);
  sub->add_option("--objective", options->search.objective,
                  "height: the tower likeliest to stand; firm: the one likeliest to outlast a shake")
      ->check(CLI::IsMember({"height", "firm"}))
      ->capture_default_str();
  sub->add_option("--paper", options->paper, "Beside it the paper's search at the same processor time")
      ->capture_default_str();
  options->judges.register_on(*sub);
  sub->add_option("--seed", options->seed)->check(CLI::Range(0, 2147483647))->capture_default_str();
  options->settings.register_on(*sub);
  sub->footer(
      "Examples:\n"
      "  stonestack-bench search --draws 40\n"
      "  stonestack-bench search --draws 40 --generated 0 --friction 0.5 --stones 6\n"
      "  stonestack-bench search --draws 10 --generated 0 --paper 0 --ode\n"
      "  stonestack-bench search --draws 40 --shard 2/8 --record part-2.json\n"
      "  stonestack-bench search --merge part-*.json\n"
      "  stonestack-bench search --noise 2 --noise-turn 2 --set search.placement_sigma_translation=0.002\n"
      "  stonestack-bench search --attitudes 1,2,2 --scans none --paper 0");
  measure_draws_by(*sub, [options](Results& results, Draws& draws) {
    options->settings.apply(nest("search", fields(options->search)));
    require(options->attitudes.empty() || !options->paper,
            "the paper's search knows the scans: give --paper 0 with --attitudes");
    measure(*options, results, draws);
  });
}

}  // namespace stonestack::bench
