// Prints how guarded descents end in the simulated cell: stones of many sizes are picked up once each and
// then set on the table or on another stone again and again, at random places, speeds and delays of the
// force.
#include <memory>
#include <vector>

#include "bench.hpp"
#include "core/quantile.hpp"
#include "descent_trial.hpp"
#include "grasp_problems.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::bench {
namespace {

constexpr double kMaxDelay = 0.020;  // s

void report(const char* kind, const DescentEnds& ends, Results& results) {
  if (ends.descents == 0) return;
  results.row({kind, ends.descents, ends.missed, ends.early, ends.no_clearance, ends.stopped,
               quantile(ends.peaks, 0.5), quantile(ends.peaks, 0.95), quantile(ends.peaks, 1.0), ends.hard});
}

void measure(int descents, int each, std::uint64_t seed, std::uint64_t first, bool list, Results& results) {
  const double start = processor_seconds();
  results.settings({{"descents", descents},
                    {"each", each},
                    {"first", static_cast<int>(first)},
                    {"force_mark_n", kForceMark},
                    {"seed", static_cast<int>(seed)}});
  DescentTally tally;
  if (list) tally.results = &results;
  int picked = 0, not_picked = 0;
  std::vector<double> masses;
  for (std::uint64_t n = first; tally.descents < descents; ++n) {
    throw_if_interrupted();
    require(not_picked < 10 + 10 * picked, "no stone can be picked up: ", not_picked, " failed");
    Random random = Random::stream(seed, n);
    const std::vector<Stone> stones{
        random_stone(static_cast<std::uint64_t>(random.index(1000000000)), "carried", 0.07, 0.14),
        random_stone(static_cast<std::uint64_t>(random.index(1000000000)), "support", 0.12, 0.16)};
    SimulationOptions simulation;
    simulation.seed = static_cast<int>(seed % 10000 * 100000 + n);
    simulation.force_delay = random.uniform(0.0, kMaxDelay);
    DescentTrial trial(stones, simulation, random);
    if (!trial.pick()) {
      ++not_picked;
      continue;
    }
    ++picked;
    tally.stone = n;
    masses.push_back(stones[0].mass.mass);
    for (int k = 0; k < each && tally.descents < descents; ++k)
      if (!trial.descend(random.uniform() < 0.5, tally)) break;
  }
  results.figures("descents", {{"descents", tally.descents},
                               {"on_a_stone", tally.on_stone},
                               {"stones", picked},
                               {"lightest_kg", quantile(masses, 0.0)},
                               {"heaviest_kg", quantile(masses, 1.0)},
                               {"cpu_s", processor_seconds() - start, 0}});
  results.table("ends", {{"place"},
                         {"descents"},
                         {"missed_contacts"},
                         {"false_triggers"},
                         {"gripper_blocked"},
                         {"other_ends"},
                         {"peak_n_median", 1},
                         {"peak_n_p95", 1},
                         {"peak_n_max", 1},
                         {"above_mark"}});
  report("planned", tally.planned, results);           // a plan would choose the place
  report("stone shoved", tally.shoved, results);       // earlier descents have moved the stone in the hand
  report("hand first", tally.gripper_first, results);  // the hand comes to the support before the stone
}

}  // namespace

void add_descent(CLI::App& app) {
  struct Command {
    int descents = 100;
    int each = 20;
    int seed = 1;
    int first = 0;
    bool list = false;
  };
  auto command = std::make_shared<Command>();
  CLI::App* sub =
      app.add_subcommand("descent", "Guarded descents in the simulated cell: contacts and forces");
  sub->add_option("--descents", command->descents)->check(CLI::Range(1, 1000000))->capture_default_str();
  sub->add_option("--each", command->each, "Descents with one stone")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  sub->add_option("--seed", command->seed)->check(CLI::Range(0, 2147483647))->capture_default_str();
  sub->add_option("--first", command->first, "Number of the first stone: to see one again that --list names")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  sub->add_flag("--list", command->list, "Print the descents that went wrong");
  sub->footer("Example:\n  stonestack-bench descent --descents 1000");
  measure_by(*sub, [command](Results& results) {
    measure(command->descents, command->each, static_cast<std::uint64_t>(command->seed),
            static_cast<std::uint64_t>(command->first), command->list, results);
  });
}

}  // namespace stonestack::bench
