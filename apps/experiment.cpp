#include <algorithm>
#include <filesystem>
#include <iostream>
#include <limits>
#include <memory>
#include <sstream>
#include <utility>

#include "commands.hpp"
#include "common_options.hpp"
#include "run_folder.hpp"
#include "scene_input.hpp"
#include "simulated_run.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/experiment/variants.hpp"
#include "stonestack/report/experiment_report.hpp"
#include "stonestack/stacking/observe.hpp"

namespace stonestack::apps {
namespace {

struct ExperimentCommand {
  CommonOptions common;
  std::string robot = "ur10";
  std::string out;
  int runs = 11;
  int stones = 6;
  int per_run = 4;
  bool survival = true;
  bool go_on = false;  ///< with what the folder holds
  std::string compare;
  std::vector<std::string> variants;
  SimulatedRun run;
};

/// The stones of the experiment: `count` of the catalogue, drawn by the seed, in its order.
Catalogue choose_stones(const Catalogue& all, int count, int seed, const RobotModel& robot) {
  Catalogue chosen{all.path, {}};
  for (const int stone : draw_stones(all, count, seed, gripper_of(CellLayout{}), robot))
    chosen.stones.push_back(all.stones[static_cast<std::size_t>(stone)]);
  return chosen;
}

void write_record(const Experiment& experiment, const std::string& folder) {
  write_file(folder + "/experiment.json", experiment_json(experiment));
  write_file(folder + "/runs.csv", runs_csv(experiment));
  write_file(folder + "/figure5.csv", figure5_csv(experiment));
  write_file(folder + "/figure5.svg", figure5_svg(experiment));
  write_file(folder + "/summary.txt", experiment_table(experiment));
}

/// Runs that were done, and whether the user ended them early.
struct Performed {
  Experiment experiment;
  bool interrupted = false;
  std::string unwritten;  ///< what of the last run's record could not be written; empty: nothing
};

/// Ends the command where the runs were not all done.
void throw_if_cut_short(const Performed& performed) {
  if (performed.interrupted) throw Interrupted();
  if (!performed.unwritten.empty()) throw Error(performed.unwritten, ExitCode::kUnreadable);
}

SimulatedRun run_number(int k, const SimulatedRun& settings, int seed) {
  SimulatedRun run = settings;
  run.seed = 1000 * seed + k;
  spread_seed(run);
  return run;
}

/// The first line in which two option files differ, for the user.
std::string first_difference(const std::string& there, const std::string& now) {
  std::istringstream a(there), b(now);
  std::string p, q;
  do {
    p.clear();
    q.clear();
    std::getline(a, p);
    std::getline(b, q);
  } while (p == q && (a || b));
  return concat("'", p, "' there, '", q, "' now");
}

/// The run was made by what would be done now.
void check_same_run(const RunReport& report, int k, SimulatedRun run, const std::vector<std::string>& present,
                    const std::string& folder) {
  const std::string file = concat(folder, "/run-", k, "/options.yaml");
  const std::string remedy = "repeat the command that began it, or begin another in a new folder";
  if (report.seed != run.seed)
    throw FileError(folder, concat("run ", k, " has the seed ", report.seed, ", not ", run.seed), remedy);
  if (report.present != present)
    throw FileError(folder, concat("run ", k, " was made with other stones"), remedy);
  const std::string there = read_file(file, 1U << 20U), now = write_fields(fields(run));
  if (there != now)
    throw FileError(file, concat("made with other options: ", first_difference(there, now)), remedy);
}

std::vector<std::string> names_of(const Catalogue& catalogue, const std::vector<int>& stones) {
  std::vector<std::string> names;
  for (const int stone : stones) names.push_back(catalogue.stones[static_cast<std::size_t>(stone)].name);
  return names;
}

/// The runs that the folder holds, if they belong to this experiment. One that was interrupted is put aside.
std::vector<ExperimentRun> runs_done(const ExperimentCommand& command, const SimulatedRun& settings,
                                     const Catalogue& catalogue, const RobotModel& robot,
                                     const std::string& folder) {
  std::vector<ExperimentRun> runs;
  if (std::filesystem::exists(folder + "/experiment.json")) {
    Experiment there = read_experiment(folder + "/experiment.json");
    require(there.per_run == command.per_run, folder, " was made with --per-run ", there.per_run, ", not ",
            command.per_run, "; repeat the command that began it");
    runs = std::move(there.runs);
  }
  require(runs.size() <= static_cast<std::size_t>(command.runs), folder, " holds ", runs.size(),
          " runs already; ask for more with --runs");
  for (std::size_t i = 0; i < runs.size(); ++i) {
    require(runs[i].report.robot == robot.name, folder, " was made with ", runs[i].report.robot,
            ", not with ", robot.name);
    const int k = static_cast<int>(i) + 1;
    const SimulatedRun run = run_number(k, settings, command.common.seed);
    const auto present = draw_stones(catalogue, command.per_run, run.seed, gripper_of(CellLayout{}), robot);
    check_same_run(runs[i].report, k, run, names_of(catalogue, present), folder);
    require(runs[i].survival.standing.empty() != command.survival, folder, ": run ", k,
            " was made with --survival ", command.survival ? "false" : "true",
            "; repeat the command that began it");
  }
  const std::string next = concat(folder, "/run-", runs.size() + 1);
  if (std::filesystem::exists(next))
    log_info(concat(next, " was not finished; it is kept as ", put_aside(next)));
  if (!runs.empty()) log_info(concat(runs.size(), " runs are there already"));
  return runs;
}

/// All runs; what is done is on disk after each of them, and is returned when the user interrupts. The run
/// that was under way then tells nothing about the design: its folder stays, but it is not counted.
Performed perform_runs(const ExperimentCommand& command, const SimulatedRun& settings,
                       const Catalogue& catalogue, const RobotModel& robot, const std::string& folder) {
  const auto shapes = make_contact_shapes(catalogue.stones);  // held, so that all runs find them
  Performed performed;
  Experiment& experiment = performed.experiment;
  experiment.per_run = command.per_run;
  experiment.title = concat(command.runs, " runs of ", experiment.per_run, " of ", catalogue.stones.size(),
                            " stones, ", robot.name, ", seed ", command.common.seed);
  const SurvivalOptions survival;
  experiment.survival_seconds = survival.seconds;
  if (command.go_on) experiment.runs = runs_done(command, settings, catalogue, robot, folder);
  // Before the first run ends, too: what --continue must agree with.
  write_file(folder + "/experiment.json", experiment_json(experiment));
  for (int k = static_cast<int>(experiment.runs.size()) + 1; k <= command.runs; ++k) {
    const SimulatedRun run = run_number(k, settings, command.common.seed);
    const auto present = draw_stones(catalogue, command.per_run, run.seed, gripper_of(CellLayout{}), robot);
    log_info(concat("run ", k, " of ", command.runs));
    FinishedRun done;
    try {
      const RecordFolder place(concat(folder, "/run-", k));
      done = perform(run, catalogue, robot, present, place, command.survival ? &survival : nullptr);
      performed.unwritten = done.unwritten;
      performed.interrupted = interrupt_noted();
    } catch (const Interrupted&) {
      performed.interrupted = true;
    } catch (const FileError& error) {
      performed.unwritten = error.what();
    }
    if (performed.interrupted) {
      log_info(concat("interrupted; run ", k, " is not counted"));
      break;
    }
    if (!performed.unwritten.empty()) {
      log_info(concat("the record of run ", k, " is not whole; it is not counted"));
      break;
    }
    experiment.runs.push_back({done.report, done.survival});
    try {
      write_record(experiment, folder);
    } catch (const FileError& error) {
      performed.unwritten = error.what();
      break;
    }
    log_info(concat("run ", k, ": height ", judged_height(experiment.runs.back()), "; ",
                    done.report.result.ended));
  }
  return performed;
}

RecordFolder out_folder(const ExperimentCommand& command) {
  if (command.out.empty()) return RecordFolder::make_new(stamped_name("experiments", command.common.seed));
  RecordFolder folder(command.out);
  require(command.go_on || folder.made(), command.out,
          " is there already; go on with it by --continue, or name another folder with --out");
  return folder;
}

std::string comparison_row(const Variant& variant, const Experiment& experiment) {
  double height = 0.0, seconds = 0.0;
  for (const auto& run : experiment.runs) {
    height += judged_height(run);
    seconds += run.report.result.seconds.motion;
  }
  const auto n = static_cast<double>(experiment.runs.size());
  const Rate whole = reached(experiment, experiment.per_run);
  char row[256];
  std::snprintf(row, sizeof row, " %5zu   %5.2f   %3d of %-3d (%3.0f to %3.0f %%)   %6.1f\n",
                experiment.runs.size(), height / n, whole.hits, whole.trials, 100 * whole.low(),
                100 * whole.high(), seconds / n);
  std::string name = variant.name;
  name.resize(std::max<std::size_t>(name.size(), 28), ' ');
  return name + row;
}

std::vector<Variant> variants_of(const ExperimentCommand& command) {
  std::vector<Variant> list;
  if (command.compare == "cell") list = cell_variants();
  if (command.compare == "design") list = design_variants();
  for (const auto& text : command.variants) list.push_back(parse_variant(text));
  return list;
}

/// Before anything is built: what could end the experiment hours later.
void check_command(const ExperimentCommand& command, const Catalogue& catalogue,
                   const std::vector<Variant>& variants) {
  constexpr int kMax = std::numeric_limits<int>::max();
  require(command.common.seed <= (kMax - command.runs) / 1000, "run k of seed S has the seed 1000 S + k, ",
          "which is too large for --seed ", command.common.seed, "; at most ", (kMax - command.runs) / 1000);
  const auto count = static_cast<int>(catalogue.stones.size());
  require(command.per_run <= count, "--per-run ", command.per_run, " of ", count,
          " stones: ask for more with --stones, of a catalogue that has them");
  check_variants(variants, command.run, command.common.seed);
}

/// A table with a row for each variant.
void compare(ExperimentCommand& command, const std::vector<Variant>& variants, const Catalogue& catalogue,
             const RobotModel& robot, const std::string& folder) {
  std::string table = "variant                       runs   height   whole                    robot s\n";
  std::cerr << table;
  for (std::size_t v = 0; v < variants.size(); ++v) {
    SimulatedRun run = command.run;
    set_fields(fields(run), variants[v].assignments);
    const Performed done = perform_runs(command, run, catalogue, robot, concat(folder, "/variant-", v + 1));
    if (!done.experiment.runs.empty()) {
      const std::string row = comparison_row(variants[v], done.experiment);
      table += row;
      std::cerr << row;
      write_file(folder + "/comparison.txt", table);
    }
    throw_if_cut_short(done);
  }
  std::cerr << '\n' << table << "record: " << folder << '\n';
}

void experiment(ExperimentCommand& command) {
  command.common.begin();
  command.common.settings.apply(fields(command.run));
  const RobotModel robot = read_robot(command.robot);
  const Catalogue catalogue =
      choose_stones(command.common.read(), command.stones, command.common.seed, robot);
  const auto variants = variants_of(command);
  check_command(command, catalogue, variants);
  require(!command.go_on || !command.out.empty(), "--continue needs the folder to go on with: --out FOLDER");
  const RecordFolder place = out_folder(command);
  const std::string& folder = place.path();
  if (!variants.empty()) return compare(command, variants, catalogue, robot, folder);
  const Performed performed = perform_runs(command, command.run, catalogue, robot, folder);
  if (const Experiment& done = performed.experiment; !done.runs.empty()) {
    std::cerr << '\n'
              << experiment_table(done) << "record: " << folder
              << " (figure5.svg, runs.csv, a folder a run)\n";
    if (command.common.json) std::cout << experiment_json(done);
  }
  throw_if_cut_short(performed);
}

}  // namespace

void add_experiment(CLI::App& app) {
  auto command = std::make_shared<ExperimentCommand>();
  CLI::App* sub =
      app.add_subcommand("experiment", "The paper's experiment: consecutive runs, heights, figure 5");
  sub->add_option("--runs", command->runs)->check(CLI::Range(1, 100000))->capture_default_str();
  sub->add_option("--stones", command->stones, "Stones of the catalogue to draw from")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  sub->add_option("--per-run", command->per_run, "Stones in the field of each run")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  sub->add_option("--robot", command->robot, "ur3 to ur16e or a URDF with UR kinematics")
      ->capture_default_str();
  sub->add_option("--survival", command->survival, "Let each tower stand for 600 s and shake it")
      ->capture_default_str();
  sub->add_option("--compare", command->compare,
                  "cell: what each error of the cell costs; design: what each part of the design is worth")
      ->check(CLI::IsMember({"cell", "design"}));
  sub->add_option("--variant", command->variants,
                  "Another row: 'NAME: OPTION=VALUE, OPTION=VALUE' (repeatable)");
  sub->add_flag("--continue", command->go_on,
                "Go on with the runs that the folder --out holds: the same command, stopped before");
  sub->add_option("--out", command->out, "Folder for the record (default: experiments/<time>-seed<seed>)");
  command->common.register_on(*sub);
  sub->footer(
      "Run k of seed S has the seed 1000 S + k. Heights are the simulated world's own, after 60 s.\n"
      "How hard the cell is: --set simulation.NAME=VALUE (names: `stonestack config show --expert | grep "
      "simulation`).\n"
      "Examples:\n"
      "  stonestack experiment --runs 11 --stones 6 --per-run 4 --seed 1\n"
      "  stonestack experiment --runs 200 --catalogue rocks --stones 16 --out long --continue\n"
      "  stonestack experiment --runs 20 --compare cell --survival false\n"
      "  stonestack experiment --runs 20 --variant 'as it is:' --variant 'wide: search.beam=6'");
  sub->callback([command] { experiment(*command); });
}

}  // namespace stonestack::apps
