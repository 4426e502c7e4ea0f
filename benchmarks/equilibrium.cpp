// Agreement of the equilibrium with the simulation. Random stacks, most of them settled and then pushed
// aside, are judged by both; apart from a band around the edge they must agree. Also how long a verdict
// takes.
#include <algorithm>
#include <cmath>
#include <memory>

#include "bench.hpp"
#include "core/quantile.hpp"
#include "physics/settle.hpp"
#include "physics/shape.hpp"
#include "settings.hpp"
#include "stone_draws.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::bench {
namespace {

constexpr double kSettlingFriction = 0.6;  // what only high friction holds is wanted, too
constexpr int kAttempts = 60;              // for each level of a random stack

struct EquilibriumBenchOptions {
  int stacks = 500, stones = 3, seed = 1;
  double friction = 0.3, push = 0.02, seconds = 2.0, band = 0.02;
  bool steps = false;
  PoolOptions pools;
};

/// A step (s) and iterations with which a stack may be judged, and how that fared.
struct Stepping {
  double step;
  int iterations;
  int stand = 0, as_finest = 0;
  double seconds = 0.0;
};

/// The finest last.
std::vector<Stepping> steppings() {
  std::vector<Stepping> list;
  for (const double rate : {240.0, 480.0, 1000.0})
    for (const int iterations : {10, 50, 200}) list.push_back({1.0 / rate, iterations});
  list.push_back({1.0 / 2000.0, 200});
  return list;
}

/// Both verdicts on one stack.
struct Compared {
  bool simulated = false;  ///< stands
  Equilibrium equilibrium;
  double solve_ms = 0.0;
};

/// A stone let down wherever chance has it over the top of a stack, a few times if need be; false if it never
/// comes to rest there.
bool add_at_random(const EquilibriumBenchOptions& options, const StonePool& pool, Random& random,
                   Stack* stack) {
  SettleOptions settling;
  settling.world.friction = std::max(options.friction, kSettlingFriction);
  settling.max_travel = 0.06;
  double top = 0.0;
  Eigen::Vector2d p_W_top = Eigen::Vector2d::Zero();
  if (!stack->stones.empty()) {
    const PlacedStone& last = stack->stones.back();
    const ContactShape& below = *at(pool.shapes, last.stone);
    p_W_top = (last.T_W_O * below.mass.p_O_M).head<2>();
    for (const auto& v : below.scan.vertices) top = std::max(top, (last.T_W_O * v).z());
  }
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const StoneIndex stone(random.index(pool.shapes.size()));
    const ContactShape& shape = *at(pool.shapes, stone);
    const Eigen::Vector2d aside(random.uniform(-options.push, options.push),
                                random.uniform(-options.push, options.push));
    Pose T_W_O = make_pose(Eigen::Vector3d::Zero(), random.rotation());
    double low = 1e9;
    for (const auto& v : shape.scan.vertices) low = std::min(low, (T_W_O * v).z());
    T_W_O.pretranslate(Eigen::Vector3d(p_W_top.x() + aside.x(), p_W_top.y() + aside.y(), top - low + 0.001));
    const SettleResult at_rest = settle(pool.shapes, *stack, stone, T_W_O, settling);
    if (!at_rest.rests) continue;
    stack->stones.push_back({stone, at_rest.T_W_O});
    return true;
  }
  return false;
}

std::optional<Stack> random_stack(const EquilibriumBenchOptions& options, const StonePool& pool,
                                  Random& random) {
  Stack stack;
  for (int level = 0; level < options.stones; ++level)
    if (!add_at_random(options, pool, random, &stack)) return std::nullopt;
  return stack;
}

/// The simulated verdict is on the stack from the moment at which the contacts were taken.
Compared compare(const EquilibriumBenchOptions& options, const StonePool& pool, const Stack& stack) {
  Compared out;
  StackStatics statics;
  for (std::size_t i = 0; i < stack.stones.size(); ++i) {
    const MassProperties& mass = at(pool.shapes, stack.stones[i].stone)->mass;
    statics.bodies.push_back({mass.mass, stack.stones[i].T_W_O * mass.p_O_M});
  }
  statics.contacts = geometric_contacts(pool.shapes, stack, 0.0002);
  EquilibriumOptions asked;
  asked.friction = options.friction;
  asked.min_friction = false;
  const Stopwatch watch;
  out.equilibrium = solve_equilibrium(statics.bodies, statics.contacts, asked);
  out.solve_ms = 1e3 * watch.seconds();
  asked.min_friction = true;
  out.equilibrium = solve_equilibrium(statics.bodies, statics.contacts, asked);
  StandOptions stand;
  stand.friction = options.friction;
  stand.seconds = options.seconds;
  out.simulated = judge_stack(pool.shapes, stack, stand).stands;
  return out;
}

/// The search's verdict: ten seconds that end once nothing moves.
void judge_by(const EquilibriumBenchOptions& options, const StonePool& pool, const Stack& stack,
              std::vector<Stepping>* list) {
  StandOptions stand;
  stand.friction = options.friction;
  stand.still = 5e-8;
  stand.fall = 0.0;
  std::vector<bool> stands;
  for (Stepping& by : *list) {
    stand.step = by.step;
    stand.iterations = by.iterations;
    const Stopwatch watch;
    stands.push_back(judge_stack(pool.shapes, stack, stand).stands);
    by.seconds += watch.seconds();
    by.stand += stands.back() ? 1 : 0;
  }
  for (std::size_t k = 0; k < list->size(); ++k) (*list)[k].as_finest += stands[k] == stands.back() ? 1 : 0;
}

void report(const std::string& pool, const std::vector<Stepping>& list, int count, Results& results) {
  results.table(pool + " judged with other steps",
                {{"rate_hz", 0}, {"iterations"}, {"stand"}, {"as_finest_percent", 1}, {"ms_each"}});
  for (const Stepping& by : list)
    results.row(
        {1.0 / by.step, by.iterations, by.stand, 100.0 * by.as_finest / count, 1e3 * by.seconds / count});
}

/// How far from the edge, in units of the friction: margin of what stands, missing friction of what falls.
bool outside_band(const EquilibriumBenchOptions& options, const Equilibrium& e) {
  if (e.stands) return e.margin >= options.band;
  return e.min_friction - options.friction >= options.band;
}

/// The row of a pool and, with --steps, how its stacks fared with other steps.
struct PoolFindings {
  std::vector<TableValue> row;
  std::vector<Stepping> steppings;
  int count = 0;
};

PoolFindings measure_pool(const EquilibriumBenchOptions& options, const StonePool& pool) {
  int agree = 0, clear = 0, clear_agree = 0, only_lp = 0, only_simulated = 0, stand = 0, count = 0;
  std::vector<double> times;
  std::vector<Stepping> list = steppings();
  for (int k = 0; count < options.stacks && k < 100 * options.stacks; ++k) {
    Random random = Random::stream(static_cast<std::uint64_t>(options.seed), concat("stack ", k));
    const auto stack = random_stack(options, pool, random);
    if (!stack) continue;
    const Compared c = compare(options, pool, *stack);
    ++count;
    const bool same = c.simulated == c.equilibrium.stands;
    agree += same ? 1 : 0;
    stand += c.simulated ? 1 : 0;
    only_lp += c.equilibrium.stands && !c.simulated ? 1 : 0;
    only_simulated += c.simulated && !c.equilibrium.stands ? 1 : 0;
    if (outside_band(options, c.equilibrium)) {
      ++clear;
      clear_agree += same ? 1 : 0;
    }
    times.push_back(c.solve_ms);
    if (options.steps) judge_by(options, pool, *stack, &list);
  }
  require(count > 0, "no random stack of ", options.stones, " came to rest; try fewer stones");
  const TableValue clear_share = clear > 0 ? TableValue(100.0 * clear_agree / clear) : TableValue();
  return {{pool.name, count, stand, 100.0 * agree / count, clear, clear_share, only_lp, only_simulated,
           quantile(times, 0.5), quantile(times, 0.95)},
          list,
          count};
}

void measure(const EquilibriumBenchOptions& options, Results& results) {
  results.settings({{"stacks", options.stacks},
                    {"stones", options.stones},
                    {"settling_friction", std::max(options.friction, kSettlingFriction)},
                    {"friction", options.friction},
                    {"seconds", options.seconds},
                    {"band", options.band},
                    {"seed", options.seed}});
  const std::vector<StonePool> pools = read_pools(options.pools);
  const std::vector<Column> columns{{"stones"},    {"stacks"},
                                    {"stand"},     {"agree_percent", 1},
                                    {"clear"},     {"clear_agree_percent", 1},
                                    {"only_lp"},   {"only_simulated"},
                                    {"ms_median"}, {"ms_p95"}};
  if (!options.steps) results.table("verdicts", columns);
  for (const StonePool& pool : pools) {
    const PoolFindings found = measure_pool(options, pool);
    if (options.steps) results.table("verdicts", columns);
    results.row(found.row);
    if (options.steps) report(pool.name, found.steppings, found.count, results);
  }
}

}  // namespace

void add_equilibrium(CLI::App& app) {
  auto options = std::make_shared<EquilibriumBenchOptions>();
  CLI::App* sub =
      app.add_subcommand("equilibrium", "Agreement of equilibrium and simulation on random stacks");
  sub->add_option("--stacks", options->stacks, "From each pool")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  sub->add_option("--stones", options->stones, "A stack")->check(CLI::Range(1, 20))->capture_default_str();
  sub->add_option("--friction", options->friction, "At which stacks are judged")
      ->check(CLI::Range(1e-3, 2.0))
      ->capture_default_str();
  sub->add_option("--push", options->push, "Stones land up to this far aside, m")->capture_default_str();
  sub->add_option("--seconds", options->seconds, "Simulated for a verdict")
      ->check(CLI::Range(0.1, 600.0))
      ->capture_default_str();
  sub->add_option("--band", options->band, "Stacks nearer to the edge are left out: margin in g, or friction")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  sub->add_option("--seed", options->seed)->check(CLI::NonNegativeNumber)->capture_default_str();
  sub->add_flag("--steps", options->steps, "Judge each stack with other steps and iterations, too");
  options->pools.register_on(*sub);
  sub->footer(
      "Examples:\n"
      "  stonestack-bench equilibrium --stacks 500 --friction 0.3\n"
      "  stonestack-bench equilibrium --stacks 150 --friction 0.5 --steps");
  measure_by(*sub, [options](Results& results) { measure(*options, results); });
}

}  // namespace stonestack::bench
