// What does a run do when a device, the world or the host fails? One run for each fault and each phase at
// which it strikes, judged by what the devices were told and by the simulation's true world.
#include <algorithm>
#include <map>
#include <memory>

#include "bench.hpp"
#include "fault_devices.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"

namespace stonestack::bench {
namespace {

struct FaultBench {
  int seed = 1, stones = 1, threads = 1;
  bool from_start = false;
  std::vector<std::string> only, phases;
};

bool is_asked_for(const std::vector<std::string>& wanted, const std::string& name) {
  return wanted.empty() || std::find(wanted.begin(), wanted.end(), name) != wanted.end();
}

std::vector<FaultCell> cells_of(const FaultBench& bench) {
  std::vector<FaultCell> cells;
  for (const Fault& fault : known_faults())
    for (std::size_t p = 0; p < kFaultPhases.size(); ++p)
      if ((is_asked_for(bench.only, fault.family) || is_asked_for(bench.only, fault.name)) &&
          is_asked_for(bench.phases, kFaultPhases[p]))
        cells.push_back({&fault, static_cast<FaultPhase>(p), {}});
  return cells;
}

/// Counts of the cells of one row.
struct FaultCount {
  int cells = 0, not_reached = 0, right = 0, stopped = 0, kept = 0;
  std::array<int, 8> broken{};
  void add(const FaultOutcome& outcome) {
    ++cells;
    not_reached += outcome.reached ? 0 : 1;
    right += outcome.right ? 1 : 0;
    stopped += outcome.stopped ? 1 : 0;
    kept += outcome.count() == 0 ? 1 : 0;
    for (std::size_t i = 0; i < broken.size(); ++i) broken[i] += outcome.broken[i].empty() ? 0 : 1;
  }
};

void report_counts(const std::string& what, const std::vector<std::pair<std::string, FaultCount>>& counts,
                   Results& results) {
  std::vector<Column> columns{{what}, {"cells"}, {"not_reached"}, {"right"}, {"stopped"}, {"all_kept"}};
  for (int i = 1; i <= 8; ++i) columns.push_back({concat("i", i)});
  results.table("by " + what, columns);
  for (const auto& [name, count] : counts) {
    std::vector<TableValue> row{name, count.cells, count.not_reached, count.right, count.stopped, count.kept};
    for (const int broken : count.broken) row.emplace_back(broken);
    results.row(row);
  }
}

FaultCount& count_of(std::vector<std::pair<std::string, FaultCount>>& counts, const std::string& name) {
  for (auto& [known, count] : counts)
    if (known == name) return count;
  return counts.emplace_back(name, FaultCount{}).second;
}

/// Cells with a fault that is not fatal which end without the right tower, each with the run's last line.
void report_not_right(const std::vector<FaultCell>& cells, Results& results) {
  results.table("not right",
                {{"class"}, {"fault"}, {"phase"}, {"height"}, {"end"}, {"reason"}, {"true_world"}});
  for (const FaultCell& cell : cells)
    if (!cell.fault->fatal && !cell.outcome.right)
      results.row({cell.fault->family, cell.fault->name, kFaultPhases[static_cast<std::size_t>(cell.phase)],
                   cell.outcome.height, cell.outcome.end, cell.outcome.reason, cell.outcome.false_claim});
}

void measure_faults(const FaultBench& bench, Results& results) {
  FaultScene scene{read_catalogue(data_path("stones")), read_robot("ur10"), bench.seed};
  auto& stones = scene.catalogue.stones;
  stones.erase(stones.begin() + std::min<std::ptrdiff_t>(bench.stones, std::ssize(stones)), stones.end());
  std::vector<FaultCell> cells = cells_of(bench);
  require(!cells.empty(), "no such fault or phase");
  results.settings(
      {{"cells", cells.size()}, {"stones", stones.size()}, {"cell", "ideal"}, {"seed", bench.seed}});
  run_with_faults(scene, cells, bench.threads, bench.from_start);

  std::vector<std::pair<std::string, FaultCount>> by_class, by_phase;
  FaultCount all, passing;
  for (const FaultCell& cell : cells) {
    count_of(by_class, cell.fault->family).add(cell.outcome);
    count_of(by_phase, kFaultPhases[static_cast<std::size_t>(cell.phase)]).add(cell.outcome);
    all.add(cell.outcome);
    if (!cell.fault->fatal) passing.add(cell.outcome);
  }
  report_counts("class", by_class, results);
  report_counts("phase", by_phase, results);
  results.table("broken", {{"class"}, {"fault"}, {"phase"}, {"invariant"}, {"why"}, {"end"}, {"reason"}});
  for (const FaultCell& cell : cells)
    for (std::size_t i = 0; i < cell.outcome.broken.size(); ++i)
      if (!cell.outcome.broken[i].empty())
        results.row({cell.fault->family, cell.fault->name, kFaultPhases[static_cast<std::size_t>(cell.phase)],
                     concat("I", i + 1), cell.outcome.broken[i], cell.outcome.end, cell.outcome.reason});
  report_not_right(cells, results);
  results.figures("totals", {{"cells", all.cells},
                             {"all_invariants_kept", all.kept},
                             {"phase_not_reached", all.not_reached},
                             {"faults_that_are_not_fatal", passing.cells},
                             {"of_these_ended_with_the_right_tower", passing.right}});
}

}  // namespace

void add_faults(CLI::App& app) {
  auto bench = std::make_shared<FaultBench>();
  CLI::App* sub =
      app.add_subcommand("faults", "One run for each fault and phase: eight invariants of safety");
  sub->add_option("--seed", bench->seed, "Seed of every run")->capture_default_str();
  sub->add_option("--stones", bench->stones, "Stones of a run")
      ->check(CLI::Range(1, 6))
      ->capture_default_str();
  sub->add_option("--threads", bench->threads, "Runs at a time; 0: one a core")
      ->check(CLI::Range(0, 1024))
      ->capture_default_str();
  sub->add_flag("--from-start", bench->from_start,
                "Make each run from its start, not from where its fault strikes: the same outcomes, later");
  sub->add_option("--only", bench->only, "Classes or faults, by their names")->delimiter(',');
  sub->add_option("--phase", bench->phases, "Phases, by their names")->delimiter(',');
  sub->footer(
      "Invariants: I1 at rest in the end, I2 no motion after a stop, I3 no jump, I4 one end with its reason, "
      "I5 no\n"
      "stone let go of in the air, I6 joints within limits, I7 no foreign exception and no hang, I8 what is\n"
      "reported stands.\n"
      "Cells with a fault that is not fatal which end without the right tower are listed as `not right`.\n"
      "Example:\n  stonestack-bench faults --only camera,robot --phase lift");
  measure_by(*sub, [bench](Results& results) { measure_faults(*bench, results); });
}

}  // namespace stonestack::bench
