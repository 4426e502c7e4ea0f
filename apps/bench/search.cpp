// How high does the search build, at what cost? Draws sets of stones from generated limestones (and a
// catalogue, if given), plans a tower with the default search and with the paper's at the same CPU time, and
// lets every tower stand 60 simulated seconds on finer shapes than the search used.
#include <ctime>
#include <iomanip>
#include <iostream>
#include <map>
#include <memory>

#include "bench.hpp"
#include "settings.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/search/find_next_pose.hpp"
#include "stonestack/stone/catalogue.hpp"
#include "stonestack/stone/limestone.hpp"

namespace stonestack::apps {
namespace {

struct BenchOptions {
  int draws = 8, stones = 4, seed = 1, generated = 12;
  bool paper = true;
  double witness_seconds = 60.0;
  std::string catalogue;
  SearchOptions search;
  Settings settings;
};

std::vector<Stone> pool_of(const BenchOptions& options) {
  std::vector<Stone> pool;
  if (!options.catalogue.empty()) pool = read_catalogue(options.catalogue).stones;
  for (int k = 0; k < options.generated; ++k) {
    Stone stone;
    stone.name = concat("limestone_", k);
    LimestoneOptions shape;
    shape.faces = 2000;
    stone.scan = make_limestone(static_cast<std::uint64_t>(1000 + k), shape);
    stone.mass = mass_properties(stone.scan, stone.density);
    pool.push_back(std::move(stone));
  }
  return pool;
}

/// One draw: which stones, and how they lie before they are picked up.
SearchProblem draw(const BenchOptions& options, int k, const ShapeList& shapes) {
  Random random = Random::stream(static_cast<std::uint64_t>(options.seed), static_cast<std::uint64_t>(k));
  std::vector<int> order(shapes.size());
  for (std::size_t s = 0; s < order.size(); ++s) order[s] = static_cast<int>(s);
  random.shuffle(order.begin(), order.end());
  order.resize(std::min(order.size(), static_cast<std::size_t>(options.stones)));
  SearchProblem problem;
  problem.shapes = &shapes;
  for (const int stone : order)
    problem.available.push_back({stone, make_pose(Eigen::Vector3d(0.5, 0, 0.1), random.rotation())});
  return problem;
}

double cpu_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

struct Outcome {
  int planned = 0;
  int clean = 0;
  double cpu = 0.0;
  double margin = 0.0;
  std::string reason;
};

Outcome witness(const BenchOptions& options, const ShapeList& fine, const std::vector<Placement>& tower,
                double cpu, const std::string& reason) {
  Stack stack;
  for (const Placement& placement : tower) stack.stones.push_back({placement.stone, placement.T_W_O});
  Outcome outcome;
  outcome.planned = static_cast<int>(tower.size());
  outcome.cpu = cpu;
  outcome.reason = reason;
  if (tower.empty()) return outcome;
  StandOptions stand;
  stand.friction = options.search.friction;
  stand.seconds = options.witness_seconds;
  outcome.clean = judge_stack(fine, stack, stand).standing;
  EquilibriumOptions statics;
  statics.friction = options.search.friction;
  outcome.margin = stack_equilibrium(fine, stack, statics).margin;
  return outcome;
}

Outcome run_default(const BenchOptions& options, const SearchProblem& problem, const ShapeList& fine) {
  const double start = cpu_seconds();
  std::string reason;
  const auto tower = plan_tower(problem, options.stones, options.search, &reason);
  return witness(options, fine, tower, cpu_seconds() - start, reason);
}

/// The paper's search, restarted with new seeds until the CPU time is used; its highest tower counts.
Outcome run_paper(const BenchOptions& options, const SearchProblem& problem, const ShapeList& fine,
                  double cpu) {
  SearchOptions search = options.search;
  search.method = "paper";
  const double start = cpu_seconds();
  std::vector<Placement> best;
  std::string reason, why;
  for (int pass = 0; pass == 0 || cpu_seconds() - start < cpu; ++pass) {
    search.seed = options.search.seed + 1000 * pass;
    auto tower = plan_tower(problem, options.stones, search, &why);
    if (pass == 0 || tower.size() > best.size()) {
      best = std::move(tower);
      reason = why;
    }
    if (best.size() == problem.available.size()) break;
  }
  return witness(options, fine, best, cpu_seconds() - start, reason);
}

void print(const char* method, const std::vector<Outcome>& outcomes) {
  std::map<int, int> clean;
  double sum = 0.0, cpu = 0.0;
  int firm = 0;
  for (const Outcome& outcome : outcomes) {
    ++clean[outcome.clean];
    sum += outcome.clean;
    cpu += outcome.cpu;
    firm += outcome.clean == outcome.planned && outcome.margin >= 0.02 ? 1 : 0;
  }
  const auto n = static_cast<double>(outcomes.size());
  std::cout << std::left << std::setw(8) << method << " mean clean " << sum / n << ", heights";
  for (const auto& [height, count] : clean) std::cout << ' ' << height << ':' << count;
  std::cout << ", CPU s a tower " << cpu / n << ", whole and margin >= 0.02 g " << firm << '/'
            << outcomes.size() << '\n';
}

void describe(const char* method, int k, const Outcome& outcome) {
  std::cerr << method << " draw " << k << ": planned " << outcome.planned << ", clean " << outcome.clean
            << ", margin " << outcome.margin << " g, CPU " << outcome.cpu << " s"
            << (outcome.reason.empty() ? "" : "; ") << outcome.reason << '\n';
}

void measure(const BenchOptions& options) {
  const std::vector<Stone> pool = pool_of(options);
  const ShapeList shapes = make_contact_shapes(pool);
  ShapeOptions finer;
  finer.cell = 0.001;
  finer.spacing = 0.002;
  const ShapeList fine = make_contact_shapes(pool, finer);
  std::cout << "draws " << options.draws << " of " << options.stones << " from " << pool.size()
            << " stones, friction " << options.search.friction << ", seed " << options.seed << ", beam "
            << options.search.beam << ", verdict after " << options.witness_seconds << " s\n";
  std::vector<Outcome> of_default, of_paper;
  for (int k = 0; k < options.draws; ++k) {
    const SearchProblem problem = draw(options, k, shapes);
    of_default.push_back(run_default(options, problem, fine));
    describe("default", k, of_default.back());
    if (!options.paper) continue;
    of_paper.push_back(run_paper(options, problem, fine, of_default.back().cpu));
    describe("paper", k, of_paper.back());
  }
  print("default", of_default);
  if (options.paper) print("paper", of_paper);
}

}  // namespace

void add_bench_search(CLI::App& bench) {
  auto options = std::make_shared<BenchOptions>();
  CLI::App* sub =
      bench.add_subcommand("search", "Heights, time and margins of planned towers; default beside paper");
  sub->add_option("--draws", options->draws, "Sets of stones")
      ->check(CLI::Range(1, 100000))
      ->capture_default_str();
  sub->add_option("--stones", options->stones, "Stones a set")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  sub->add_option("--catalogue", options->catalogue, "Draw from these stones too")->type_name("DIR");
  sub->add_option("--generated", options->generated, "Draw from so many generated limestones")
      ->check(CLI::Range(0, 1000))
      ->capture_default_str();
  sub->add_option("--paper", options->paper, "Beside it the paper's search at the same processor time")
      ->capture_default_str();
  sub->add_option("--stand", options->witness_seconds, "How long a tower must stand, s")
      ->check(CLI::Range(0.1, 3600.0))
      ->capture_default_str();
  sub->add_option("--seed", options->seed)->check(CLI::NonNegativeNumber)->capture_default_str();
  options->settings.register_on(*sub);
  sub->footer(
      "Examples:\n"
      "  stonestack bench search --draws 40\n"
      "  stonestack bench search --draws 40 --catalogue rocks --generated 0 --set search.friction=0.5");
  sub->callback([options] {
    options->settings.apply(nest("search", fields(options->search)));
    measure(*options);
  });
}

}  // namespace stonestack::apps
