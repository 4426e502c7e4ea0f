// Whole runs for hours: does the process grow? Each run has another seed; after each the caches are emptied
// (they are bounded, and take tens of runs to fill), and the heap in use, resident memory, open descriptors
// and threads are counted.
#include "soak.hpp"

#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>

#include "common_options.hpp"
#include "core/memory.hpp"
#include "core/recently_used.hpp"
#include "growth.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/emulators/simulated_servers.hpp"
#include "stonestack/report/record_run.hpp"

namespace stonestack::bench {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMinSamples = 10;  // after the warm-up, for a verdict

struct SoakOptions {
  apps::CommonOptions common;
  double hours = 0.0, minutes = 0.0;
  int runs = 0, per_run = 4;
  bool sockets = false;
  std::string robot = "ur10", folder;
  SimulatedRun run;
};

/// Resources of the process.
struct Holdings {
  double heap_mb = 0.0;      ///< in use
  double resident_mb = 0.0;  ///< with what was freed between that and cannot be returned
  int descriptors = 0;
  int threads = 0;
};

int entries_of(const char* folder) {
  return static_cast<int>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

Holdings held_now() {
  std::ifstream statm("/proc/self/statm");
  double total = 0.0, resident = 0.0;
  statm >> total >> resident;
  return {static_cast<double>(core::heap_in_use()) / 1e6,
          resident * static_cast<double>(::sysconf(_SC_PAGESIZE)) / 1e6, entries_of("/proc/self/fd"),
          entries_of("/proc/self/task")};
}

/// A quantity that must not grow from run to run.
struct Quantity {
  std::string name;
  double limit;  ///< a run; more is growth
  double (*of)(const Holdings&);
};
const Quantity kQuantities[] = {
    {"heap_mb", 0.1, [](const Holdings& held) { return held.heap_mb; }},
    {"resident_mb", 0.1, [](const Holdings& held) { return held.resident_mb; }},
    {"descriptors", 0.01, [](const Holdings& held) { return static_cast<double>(held.descriptors); }},
    {"threads", 0.01, [](const Holdings& held) { return static_cast<double>(held.threads); }},
};

/// Folder of the record of the run under way, removed with what is in it.
class ScratchFolder {
 public:
  explicit ScratchFolder(const std::string& above)
      : path_(concat(above.empty() ? fs::temp_directory_path().string() : above, "/soak-", ::getpid())) {}
  ~ScratchFolder() { clear(); }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;
  [[nodiscard]] const std::string& path() const { return path_; }
  void clear() const {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }

 private:
  std::string path_;
};

/// Run number `k`, from 0; every second one over sockets where these are wanted.
RunOrder order_of(const SoakOptions& options, int k) {
  RunOrder order;
  order.run = options.run;
  order.run.seed = options.common.seed + k;
  spread_seed(order.run);
  order.robot = read_robot(options.robot);
  order.per_run = options.per_run;
  if (options.sockets && k % 2 == 1) order.cell = read_cell("loopback-" + options.robot);
  return order;
}

void report_growth(const std::vector<Holdings>& samples, Results& results) {
  results.table("growth after the warm-up", {{"quantity"},
                                             {"samples"},
                                             {"first", 1},
                                             {"last", 1},
                                             {"slope_a_run", 4},
                                             {"limit_a_run"},
                                             {"verdict"}});
  for (const Quantity& quantity : kQuantities) {
    std::vector<double> values;
    for (const Holdings& held : samples) values.push_back(quantity.of(held));
    values = after_warm_up(values);
    if (values.size() < kMinSamples) {
      results.row({quantity.name, values.size(), {}, {}, {}, quantity.limit, "too few runs"});
      continue;
    }
    const double slope = median_slope(values);
    results.row({quantity.name, values.size(), values.front(), values.back(), slope, quantity.limit,
                 slope > quantity.limit ? "growing" : "flat"});
  }
}

void soak(SoakOptions& options, Results& results) {
  require(options.hours + options.minutes > 0.0 || options.runs > 0,
          "say how long, with --hours or --minutes, or how many --runs");
  const Catalogue catalogue = options.common.read();
  results.settings({{"hours", options.hours + options.minutes / 60},
                    {"runs_max", options.runs},
                    {"per_run", options.per_run},
                    {"cell", options.run.simulation.cell},
                    {"sockets", options.sockets},
                    {"seed", options.common.seed}});
  results.table("runs", {{"run"},
                         {"devices"},
                         {"seed"},
                         {"height"},
                         {"seconds", 1},
                         {"heap_mb", 2},
                         {"resident_mb", 1},
                         {"descriptors"},
                         {"threads"}});
  const ScratchFolder folder(options.folder);
  const double limit = 3600 * options.hours + 60 * options.minutes;
  const Stopwatch all;
  std::vector<Holdings> samples;
  for (int k = 0; (limit == 0.0 || all.seconds() < limit) && (options.runs == 0 || k < options.runs); ++k) {
    RunOrder order = order_of(options, k);
    order.out = folder.path();
    const Stopwatch watch;
    int height = 0;
    try {
      height = record_run(order, catalogue).report.result.height;
    } catch (const Interrupted&) {  // the runs before it have their verdict
    }
    if (interrupt_noted()) break;
    const double seconds = watch.seconds();
    folder.clear();
    core::forget_recently_used();
    core::return_free_memory();
    samples.push_back(held_now());
    const Holdings& held = samples.back();
    results.row({k + 1, order.cell ? "sockets" : "in process", order.run.seed, height, seconds, held.heap_mb,
                 held.resident_mb, held.descriptors, held.threads});
  }
  report_growth(samples, results);
  throw_if_interrupted();
}

}  // namespace

void add_soak(CLI::App& app) {
  auto options = std::make_shared<SoakOptions>();
  CLI::App* sub =
      app.add_subcommand("soak", "Whole runs for hours: growth of memory, descriptors and threads");
  sub->add_option("--hours", options->hours)->check(CLI::Range(0.0, 1000.0))->capture_default_str();
  sub->add_option("--minutes", options->minutes)->check(CLI::Range(0.0, 60000.0))->capture_default_str();
  sub->add_option("--runs", options->runs, "Runs at most; 0: as many as the time allows")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  sub->add_option("--per-run", options->per_run, "Stones in the field of each run")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  sub->add_option("--robot", options->robot, "ur10 or ur10e")
      ->check(CLI::IsMember({"ur10", "ur10e"}))
      ->capture_default_str();
  sub->add_flag("--sockets", options->sockets,
                "Every second run with simulated devices on sockets and the real backends");
  apps::add_path(*sub, "--scratch", options->folder,
                 "Where the record of the run under way lies (default: /tmp)", "DIR");
  options->common.register_draw(*sub);
  sub->footer(
      "Growth is the median slope over the runs after the first quarter (at least five). What is counted is\n"
      "what the process holds with its caches emptied: these are bounded.\n"
      "Examples:\n"
      "  stonestack-bench soak --hours 8\n"
      "  stonestack-bench soak --minutes 30 --per-run 2 --sockets");
  measure_by(*sub, [options](Results& results) {
    options->common.settings.apply(fields(options->run));
    soak(*options, results);
  });
}

}  // namespace stonestack::bench
