// Prints how guarded descents end in the simulated cell: stones of many sizes are picked up once each and
// then set on the table or on another stone again and again, at random places, speeds and delays of the
// force.
#include <cstdio>
#include <memory>
#include <vector>

#include "bench.hpp"
#include "descent_trial.hpp"
#include "grasp_problems.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/quantile.hpp"

namespace stonestack::apps {
namespace {

constexpr double kMostDelay = 0.020;  // s

void print(const char* kind, const bench::DescentEnds& ends) {
  if (ends.descents == 0) return;
  std::printf(
      "%s: %d descents, missed contacts %d, false triggers %d, out of room for the hand %d, other ends %d; "
      "peak force N: median %.1f, 95 %% %.1f, largest %.1f; above %.0f N: %d\n",
      kind, ends.descents, ends.missed, ends.early, ends.no_room, ends.stopped, quantile(ends.peaks, 0.5),
      quantile(ends.peaks, 0.95), quantile(ends.peaks, 1.0), bench::kForceMark, ends.hard);
}

void measure(int descents, int each, std::uint64_t seed, std::uint64_t first, bool list) {
  const double start = processor_seconds();
  bench::DescentTally tally;
  tally.list = list;
  int picked = 0, not_picked = 0;
  std::vector<double> masses;
  for (std::uint64_t n = first; tally.descents < descents; ++n) {
    throw_if_interrupted();
    require(not_picked < 10 + 10 * picked, "no stone can be picked up: ", not_picked, " failed");
    Random random = Random::stream(seed, n);
    const std::vector<Stone> stones{
        bench::random_stone(static_cast<std::uint64_t>(random.index(1000000000)), "carried", 0.07, 0.14),
        bench::random_stone(static_cast<std::uint64_t>(random.index(1000000000)), "support", 0.12, 0.16)};
    SimulationOptions simulation;
    simulation.seed = static_cast<int>(seed % 10000 * 100000 + n);
    simulation.force_delay = random.uniform(0.0, kMostDelay);
    bench::DescentTrial trial(stones, simulation, random);
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
  std::printf("%d descents, %d of them on a stone, with %d stones of %.2f to %.2f kg, seed %d; CPU s %.0f\n",
              tally.descents, tally.on_stone, picked, quantile(masses, 0.0), quantile(masses, 1.0),
              static_cast<int>(seed), processor_seconds() - start);
  print("a plan would choose the place", tally.planned);
  print("earlier descents have moved the stone in the hand", tally.shoved);
  print("the hand comes to the support before the stone", tally.hand_first);
}

}  // namespace

void add_bench_descent(CLI::App& bench) {
  struct Command {
    int descents = 100;
    int each = 20;
    int seed = 1;
    int first = 0;
    bool list = false;
  };
  auto command = std::make_shared<Command>();
  CLI::App* sub =
      bench.add_subcommand("descent", "Guarded descents in the simulated cell: contacts and forces");
  sub->add_option("--descents", command->descents)->check(CLI::Range(1, 1000000))->capture_default_str();
  sub->add_option("--each", command->each, "Descents with one stone")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  sub->add_option("--seed", command->seed)->check(CLI::Range(0, 2147483647))->capture_default_str();
  sub->add_option("--first", command->first, "Number of the first stone: to see one again that --list names")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  sub->add_flag("--list", command->list, "Print the descents that went wrong");
  sub->footer("Example:\n  stonestack bench descent --descents 1000");
  sub->callback([command] {
    measure(command->descents, command->each, static_cast<std::uint64_t>(command->seed),
            static_cast<std::uint64_t>(command->first), command->list);
  });
}

}  // namespace stonestack::apps
