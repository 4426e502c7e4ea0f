#include <algorithm>
#include <filesystem>
#include <limits>
#include <optional>
#include <utility>

#include "core/memory.hpp"
#include "experiment/new_stones.hpp"
#include "geometry/json_file.hpp"
#include "report/experiment_folder.hpp"
#include "report/experiment_page.hpp"
#include "report/live_run.hpp"
#include "report/perform_run.hpp"
#include "report/run_folder.hpp"
#include "report/text.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/experiment/option_sources.hpp"
#include "stonestack/motion/planning_scene.hpp"
#include "stonestack/report/record_run.hpp"
#include "stonestack/report/results.hpp"
#include "stonestack/stacking/observe.hpp"

namespace stonestack::report {
namespace {

using nlohmann::json;

constexpr const char* kRepeat = "repeat the command that began it";

std::vector<StoneIndex> draw(const Catalogue& catalogue, int count, int seed, const RobotModel& robot,
                             const std::string& gripper) {
  return draw_stones(catalogue, count, seed, gripper_of(with_gripper({}, gripper)), robot);
}

/// The stones of the experiment, drawn by its seed, in the order of the catalogue; none where each run has
/// its own.
Catalogue choose_stones(const ExperimentOrder& order, const Catalogue& all) {
  Catalogue chosen{all.path, {}};
  if (order.new_stones > 0) return chosen;
  for (const StoneIndex stone : draw(all, order.stones, order.seed, order.robot, order.run.build.gripper))
    chosen.stones.push_back(all[stone]);
  return chosen;
}

std::vector<std::string> names_of(const Catalogue& catalogue) {
  std::vector<std::string> names;
  for (const Stone& stone : catalogue.stones) names.push_back(stone.name);
  return names;
}

/// Adds `run` in the order of the numbers.
const ExperimentRun& insert_run(std::vector<ExperimentRun>& runs, ExperimentRun run) {
  const auto next = std::find_if(runs.begin(), runs.end(),
                                 [&](const ExperimentRun& other) { return other.number > run.number; });
  return *runs.insert(next, std::move(run));
}

std::vector<ExperimentRun>::const_iterator find_run(const std::vector<ExperimentRun>& runs, int number) {
  return std::find_if(runs.begin(), runs.end(),
                      [&](const ExperimentRun& run) { return run.number == number; });
}

/// Refuses what could end the experiment hours later.
void check_order(const ExperimentOrder& order, const Catalogue& catalogue) {
  constexpr int kMax = std::numeric_limits<int>::max();
  require(order.seed <= (kMax - order.runs) / 1000, "run k of seed S has the seed 1000 S + k, ",
          "which is too large for --seed ", order.seed, "; at most ", (kMax - order.runs) / 1000);
  const auto count = static_cast<int>(catalogue.stones.size());
  if (order.new_stones > 0) {
    require(order.per_run <= order.new_stones, "--per-run ", order.per_run, " of --new-stones ",
            order.new_stones, ": ask for as many new stones at least");
  } else {
    require(order.new_stones_from.empty(), "--new-stones-from ", order.new_stones_from,
            ": say how many stones of it a run has, with --new-stones");
    require(order.per_run <= count, "--per-run ", order.per_run, " of ", count,
            " stones: ask for more with --stones, of a catalogue that has them");
  }
  const std::string shard = "--shard " + to_text(order.shard);
  require(order.shard.size(order.runs) > 0, shard, " of --runs ", order.runs,
          ": it has no run; divide them into ", order.runs, " shards at most");
  require(order.shard.count == 1 || order.variants.empty(), shard,
          ": a comparison has no shards; make each row an experiment of its own, its options with --set");
  require(
      !order.perform_elsewhere || order.variants.empty(),
      "a comparison is performed by one process; make each row an experiment of its own, its options with "
      "--set");
  check_variants(order.variants, order.run, order.seed);
  require(!order.continues || !order.out.empty(), "--continue needs the folder to go on with: --out FOLDER");
}

RecordFolder out_folder(const ExperimentOrder& order) {
  if (order.out.empty()) return RecordFolder::make_new(stamped_name("experiments", order.seed));
  RecordFolder folder(order.out);
  require(order.continues || folder.made(), order.out,
          " is there already; go on with it by --continue, or name another folder with --out");
  return folder;
}

/// The runs of one experiment: `order` with the options of a variant, in a folder of its own.
class Runs {
 public:
  Runs(const ExperimentOrder& order, const SimulatedRun& settings, const Catalogue& catalogue,
       std::string folder, LiveServer* live)
      : order_(order), settings_(settings), catalogue_(catalogue), folder_(std::move(folder)), live_(live) {
    apply_protocol(settings_, order.protocol);
    if (order.new_stones > 0)
      new_stones_.emplace(order.new_stones, order.new_stones_from, order.seed, order.robot,
                          order.run.build.gripper);
  }

  /// Performs those that are not done; the reports of a run that the user interrupts, or whose record is not
  /// whole, stay in its folder, but it is not counted.
  [[nodiscard]] RecordedExperiment perform_all() const {
    RecordedExperiment done;
    done.folder = folder_;
    Experiment& experiment = done.experiment = without_runs();
    RunTexts as_read;
    if (order_.continues) read_runs(experiment.runs, as_read);
    // Before the first run ends, too: what --continue and --merge must agree with.
    SimulatedRun all = run_of_seed(order_.seed);
    write_file(options_file(folder_), write_fields(fields(all)));
    write_record(experiment, as_read);
    if (order_.perform_elsewhere)
      perform_missing_elsewhere(done, as_read);
    else
      perform_missing(done, as_read);
    show(experiment);
    return done;
  }

  /// Performs run `k` and writes its folder.
  /// @return the experiment with this run alone
  /// @throws Interrupted; FileError, and Error where its record is not whole
  [[nodiscard]] Experiment perform_alone(int k) const {
    Experiment experiment = without_runs();
    experiment.shard = {k, order_.runs};
    std::string unwritten;
    experiment.runs.push_back(perform_one(k, unwritten));
    if (!unwritten.empty()) throw Error(unwritten, ExitCode::kUnreadable);
    return experiment;
  }

 private:
  /// The experiment before its first run.
  [[nodiscard]] Experiment without_runs() const {
    Experiment experiment;
    experiment.seed = order_.seed;
    experiment.total = order_.runs;
    experiment.shard = order_.shard;
    experiment.stones = names_of(catalogue_);
    experiment.protocol = order_.protocol;
    experiment.per_run = order_.per_run;
    experiment.new_stones = order_.new_stones;
    experiment.new_stones_from = order_.new_stones_from;
    experiment.title = concat(order_.runs, " runs of ", order_.per_run, " of ",
                              new_stones_ ? concat(order_.new_stones, " new stones each")
                                          : concat(catalogue_.stones.size(), " stones"),
                              ", ", order_.robot.name, ", protocol ", order_.protocol, ", seed ", order_.seed,
                              ", cell ", settings_.simulation.cell);
    experiment.survival_seconds = survival_.seconds;
    return experiment;
  }
  /// Numbers of the shard's runs that are not among `runs`.
  [[nodiscard]] std::vector<int> missing_in(const std::vector<ExperimentRun>& runs) const {
    std::vector<int> numbers;
    for (int k = 1; k <= order_.runs; ++k)
      if (order_.shard.has(k) && find_run(runs, k) == runs.end()) numbers.push_back(k);
    return numbers;
  }
  /// Performs the runs of the shard that are not done, one after the other.
  void perform_missing(RecordedExperiment& done, const RunTexts& as_read) const {
    const std::vector<ExperimentRun>& runs = done.experiment.runs;
    const double before = static_cast<double>(runs.size()), all = order_.shard.size(order_.runs);
    const auto shapes = make_contact_shapes(catalogue_.stones);  // held, so that all runs find them
    const Stopwatch watch;
    for (const int k : missing_in(runs)) {
      show(done.experiment);
      if (!add_run(k, done, as_read)) return;
      const auto now = static_cast<double>(runs.size());
      show_progress({"experiment", now, all, "runs", format("mean height %.2f", mean_height(done.experiment)),
                     watch.seconds() * now / (now - before)});
    }
  }
  /// Lets other processes perform them, and adds each to the record as it comes.
  void perform_missing_elsewhere(RecordedExperiment& done, RunTexts& as_read) const {
    Experiment& experiment = done.experiment;
    const double before = static_cast<double>(experiment.runs.size()), all = order_.shard.size(order_.runs);
    const Stopwatch watch;
    const auto take = [&](const std::vector<std::string>& ended) {
      std::string lines;
      for (const std::string& run : ended) {
        const json file = json::parse(run, nullptr, false);
        Experiment alone = experiment_of(file, "a run that was performed elsewhere");
        as_read.merge(run_texts(file));
        lines += line_about(insert_run(experiment.runs, std::move(alone.runs.at(0)))) + '\n';
      }
      write_record(experiment, as_read);
      show(experiment);
      const auto now = static_cast<double>(experiment.runs.size());
      return lines + progress_text({"experiment", now, all, "runs",
                                    format("mean height %.2f", mean_height(experiment)),
                                    watch.seconds() * now / (now - before)});
    };
    show(experiment);
    order_.perform_elsewhere(folder_, missing_in(experiment.runs), take);
    done.interrupted = interrupt_noted();
    done.missing = listed_runs(missing_in(experiment.runs));
  }
  void write_record(const Experiment& experiment, const RunTexts& as_read) const {
    if (experiment.runs.empty())
      write_file(experiment_file(folder_), experiment_json(experiment));
    else
      report::write_record(experiment, as_read, folder_);
  }
  /// A line for a person about a run that has ended.
  static std::string line_about(const ExperimentRun& run) {
    return concat("run ", run.number, ": height ", judged_height(run), "; ", run.report.result.ended);
  }
  /// Brings the live view up to date.
  void show(const Experiment& experiment) const {
    if (live_ == nullptr) return;
    const int total = order_.shard.size(order_.runs);
    live_->publish("state", experiment_data(experiment, total), true);
    live_->set_page(live_experiment_page(experiment, total));
  }
  [[nodiscard]] SimulatedRun run_of_seed(int seed) const {
    SimulatedRun run = settings_;
    run.seed = seed;
    spread_seed(run);
    return run;
  }
  [[nodiscard]] SimulatedRun run_number(int k) const { return run_of_seed(1000 * order_.seed + k); }
  /// The stones that run `k` may draw from.
  [[nodiscard]] Catalogue stones_of(int k, const SimulatedRun& run) const {
    return new_stones_ ? new_stones_->of_run(k, run.seed) : catalogue_;
  }
  [[nodiscard]] std::vector<StoneIndex> present_in(const Catalogue& catalogue,
                                                   const SimulatedRun& run) const {
    return draw(catalogue, order_.per_run, run.seed, order_.robot, run.build.gripper);
  }

  /// The folder of run `k`; what a run that did not end has left in it is put aside.
  [[nodiscard]] std::string empty_run_folder(int k) const {
    std::string folder = folder_of_run(folder_, k);
    if (std::filesystem::exists(folder))
      log_info(concat(folder, " was not finished; it is kept as ", put_aside(folder)));
    return folder;
  }

  /// Performs run `k`; `unwritten` says what of its record could not be written. Throws Interrupted.
  [[nodiscard]] ExperimentRun perform_one(int k, std::string& unwritten) const {
    const SimulatedRun run = run_number(k);
    log_info(concat("run ", k, " of ", order_.runs));
    Catalogue catalogue = stones_of(k, run);
    const auto present = present_in(catalogue, run);
    const RecordFolder place(empty_run_folder(k));
    if (run.build.save_states && new_stones_ && order_.new_stones_from.empty()) {
      catalogue.path = place.path() + "/stones";
      for (const Stone& stone : catalogue.stones) write_stone(catalogue.path, stone);
    }
    RecordedRun made = perform(run, catalogue, order_.robot, present, place, order_.version,
                               order_.survival ? &survival_ : nullptr);
    throw_if_interrupted();
    unwritten = made.unwritten;
    made.report.result.events.clear();  // in the run's own folder
    made.report.result.timeline = {};
    core::return_free_memory();
    return {std::move(made.report), std::move(made.survival), k};
  }

  /// Adds run `k`; false where the experiment ends with it.
  [[nodiscard]] bool add_run(int k, RecordedExperiment& done, const RunTexts& as_read) const {
    try {
      ExperimentRun run = perform_one(k, done.unwritten);
      if (done.unwritten.empty()) {
        const ExperimentRun& added = insert_run(done.experiment.runs, std::move(run));
        write_record(done.experiment, as_read);
        log_info(line_about(added));
        return true;
      }
    } catch (const Interrupted&) {
      done.interrupted = true;
      log_info(concat("interrupted; run ", k, " is not counted"));
    } catch (const FileError& error) {
      done.unwritten = error.what();
    }
    if (!done.interrupted) log_info(concat("the record of run ", k, " is not whole; it is not counted"));
    return false;
  }

  /// Refuses a run that would not be made now as it was made.
  void check_same_run(const ExperimentRun& there) const {
    const int k = there.number;
    const std::string remedy = concat(kRepeat, ", or begin another in a new folder");
    const RunReport& report = there.report;
    require(report.robot == order_.robot.name, folder_, " was made with ", report.robot, ", not with ",
            order_.robot.name);
    SimulatedRun run = run_number(k);
    if (report.seed != run.seed)
      throw FileError(folder_, concat("run ", k, " has the seed ", report.seed, ", not ", run.seed), remedy);
    std::vector<std::string> present;
    const Catalogue catalogue = stones_of(k, run);
    for (const StoneIndex stone : present_in(catalogue, run)) present.push_back(name_of(catalogue, stone));
    if (report.present != present)
      throw FileError(folder_, concat("run ", k, " was made with other stones"), remedy);
    const std::string file = folder_of_run(folder_, k) + "/options.yaml";
    const std::string options = read_file(file, 1U << 20U), now = write_fields(fields(run));
    const auto [line, line_now] = first_difference(options, now);
    if (options != now)
      throw FileError(file, concat("made with other options: '", line, "' there, '", line_now, "' now"),
                      remedy);
    require(there.survival.standing.empty() != order_.survival, folder_, ": run ", k,
            " was made with --survival ", order_.survival ? "false" : "true", "; ", kRepeat);
  }

  /// Reads the runs that the folder holds, if they belong to this experiment.
  void read_runs(std::vector<ExperimentRun>& runs, RunTexts& as_read) const {
    if (std::filesystem::exists(experiment_file(folder_))) {
      const json file = read_json(experiment_file(folder_));
      Experiment there = experiment_of(file, experiment_file(folder_));
      require(there.per_run == order_.per_run, folder_, " was made with --per-run ", there.per_run, ", not ",
              order_.per_run, "; ", kRepeat);
      require(there.protocol == order_.protocol, folder_, " was made with --protocol ", there.protocol,
              ", not ", order_.protocol, "; ", kRepeat);
      require(there.new_stones == order_.new_stones && there.new_stones_from == order_.new_stones_from,
              folder_, " was made with --new-stones ", there.new_stones,
              there.new_stones_from.empty() ? "" : " --new-stones-from " + there.new_stones_from, "; ",
              kRepeat);
      require(to_text(there.shard) == to_text(order_.shard), folder_, " was made with --shard ",
              to_text(there.shard), ", not ", to_text(order_.shard), "; ", kRepeat);
      runs = std::move(there.runs);
      as_read = run_texts(file);
    }
    require(runs.empty() || runs.back().number <= order_.runs, folder_, " holds ", runs.size(),
            " runs already, up to number ", runs.empty() ? 0 : runs.back().number,
            "; ask for more with --runs");
    for (const ExperimentRun& run : runs) check_same_run(run);
    if (!runs.empty()) log_info(concat(runs.size(), " runs are there already"));
  }

  const ExperimentOrder& order_;
  SimulatedRun settings_;
  const Catalogue& catalogue_;
  std::optional<NewStones> new_stones_;
  const std::string folder_;
  LiveServer* const live_;
  const SurvivalOptions survival_;
};

std::string comparison_row(std::string name, const Experiment& experiment) {
  double height = 0.0, seconds = 0.0;
  for (const auto& run : experiment.runs) {
    height += judged_height(run);
    seconds += run.report.result.seconds.motion;
  }
  const auto n = static_cast<double>(experiment.runs.size());
  const Rate whole = reached(experiment, experiment.per_run);
  name.resize(std::max<std::size_t>(name.size(), 28), ' ');
  return name + format(" %5zu   %5.2f   %3d of %-3d (%3.0f to %3.0f %%)   %6.1f\n", experiment.runs.size(),
                       height / n, whole.hits, whole.trials, 100 * whole.low(), 100 * whole.high(),
                       seconds / n);
}

/// One experiment a variant.
RecordedExperiment compare(const ExperimentOrder& order, const Catalogue& catalogue,
                           const std::string& folder, const std::function<void(const std::string&)>& listener,
                           LiveServer* live) {
  std::string table;
  const auto add = [&](const std::string& line) {
    table += line;
    if (listener) listener(line);
  };
  add("variant                       runs   height   whole                    robot s\n");
  RecordedExperiment done;
  for (std::size_t v = 0; v < order.variants.size(); ++v) {
    SimulatedRun run = order.run;
    set_fields(fields(run), order.variants[v].assignments);
    done = Runs(order, run, catalogue, concat(folder, "/variant-", v + 1), live).perform_all();
    if (!done.experiment.runs.empty()) {
      add(comparison_row(order.variants[v].name, done.experiment));
      write_file(folder + "/comparison.txt", table);
    }
    if (done.interrupted || !done.unwritten.empty()) break;
  }
  done.comparison = table;
  done.folder = folder;
  return done;
}

}  // namespace

std::string perform_experiment_run(const ExperimentOrder& order, const Catalogue& catalogue,
                                   const std::string& folder, int number) {
  const Catalogue chosen = choose_stones(order, catalogue);
  check_order(order, chosen);
  require(order.variants.empty(), "a run of a comparison is performed with the others");
  require(number >= 1 && number <= order.runs, "there is no run ", number, " of ", order.runs);
  return experiment_json(Runs(order, order.run, chosen, folder, nullptr).perform_alone(number));
}

RecordedExperiment record_experiment(const ExperimentOrder& order, const Catalogue& catalogue,
                                     const std::function<void(const std::string& line)>& listener) {
  const Catalogue chosen = choose_stones(order, catalogue);
  check_order(order, chosen);
  if (order.new_stones > 0)  // before a folder is made
    (void)NewStones(order.new_stones, order.new_stones_from, order.seed, order.robot,
                    order.run.build.gripper);
  const RecordFolder folder = out_folder(order);
  const int total = order.shard.size(order.runs);
  const auto live = make_live_server(order.view, live_experiment_page({}, total));
  RecordedExperiment done = order.variants.empty()
                                ? Runs(order, order.run, chosen, folder.path(), live.get()).perform_all()
                                : compare(order, chosen, folder.path(), listener, live.get());
  if (live) {
    live->publish("end", experiment_data(done.experiment, total), true);
    live->finish(kFarewell);
  }
  return done;
}

}  // namespace stonestack::report
