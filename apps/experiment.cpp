#include <algorithm>
#include <ctime>
#include <filesystem>
#include <iostream>
#include <memory>

#include "commands.hpp"
#include "common_options.hpp"
#include "scene_input.hpp"
#include "simulated_run.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/core/random.hpp"
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
  std::string compare;
  std::vector<std::string> variants;
  SimulatedRun run;
};

/// One row of a comparison: the experiment with some options set differently.
struct Variant {
  std::string name;
  std::vector<std::string> assignments;
};

/// Each way in which the cell is hard, alone, against all of them and none of them.
std::vector<Variant> cell_variants() {
  const std::vector<std::string> easy{
      "simulation.sensor_noise=false",  "simulation.hand_eye_translation=0", "simulation.hand_eye_rotation=0",
      "simulation.arm_repeatability=0", "simulation.arm_residual=0",         "simulation.mass_error=0",
      "simulation.com_error=0",         "simulation.friction=0.5",           "simulation.friction_spread=0"};
  const auto only = [&](const std::string& name, const std::vector<std::string>& hard) {
    Variant variant{name, easy};
    variant.assignments.insert(variant.assignments.end(), hard.begin(), hard.end());
    return variant;
  };
  return {{"as it is", {}},
          only("no error at all", {}),
          only("sensor noise only", {"simulation.sensor_noise=true"}),
          only("hand-eye error only",
               {"simulation.hand_eye_translation=0.001", "simulation.hand_eye_rotation=0.0052"}),
          only("arm error only", {"simulation.arm_repeatability=0.0001", "simulation.arm_residual=0.001"}),
          only("mass and centre only", {"simulation.mass_error=0.02", "simulation.com_error=0.002"}),
          only("friction 0.35 to 0.65 only", {"simulation.friction_spread=0.15"}),
          only("fingers locked only", {"simulation.regrip=false"}),
          only("friction 0.2 only", {"simulation.friction=0.2"}),
          only("friction 0.1 only", {"simulation.friction=0.1"})};
}

/// Each part of the design taken away, alone.
std::vector<Variant> design_variants() {
  return {{"as it is", {}},
          {"paper's search", {"search.method=paper"}},
          {"first failure ends the run", {"run.most_failures=1"}},
          {"no stone taken off again", {"run.most_taken_off=0"}},
          {"no stone turned over", {"run.most_turned_over=0"}},
          {"friction 0.1 only", {"run.most_friction=0.1"}},
          {"grasps by three contacts", {"motion.press_pads=false"}},
          {"no perturbed verdicts", {"search.perturbations=0"}},
          {"aim not corrected", {"run.correct_aim=false"}}};
}

/// "name: option=value, option=value"
Variant parse_variant(const std::string& text) {
  const auto colon = text.find(':');
  require(colon != std::string::npos, "--variant expects 'NAME: OPTION=VALUE, ...', got '", text, "'");
  Variant variant{text.substr(0, colon), {}};
  for (auto assignment : split(text.substr(colon + 1), ',')) {
    std::erase(assignment, ' ');
    if (!assignment.empty()) variant.assignments.push_back(assignment);
  }
  return variant;
}

/// The stones of the experiment: `count` of the catalogue, drawn by the seed, in its order.
Catalogue choose_stones(const Catalogue& all, int count, int seed, const RobotModel& robot) {
  Catalogue chosen{all.path, {}};
  for (const int stone : draw_stones(all, count, seed, hand_of(CellLayout{}), robot))
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

/// What was done, and whether the user ended it early.
struct Performed {
  Experiment experiment;
  bool interrupted = false;
};

/// All runs; what is done is on disk after each of them, and is returned when the user interrupts. The run
/// that was under way then tells nothing about the design: its folder stays, but it is not counted.
Performed perform_runs(const ExperimentCommand& command, const SimulatedRun& settings,
                       const Catalogue& catalogue, const RobotModel& robot, const std::string& folder) {
  Performed performed;
  Experiment& experiment = performed.experiment;
  experiment.per_run = std::min(command.per_run, static_cast<int>(catalogue.stones.size()));
  experiment.title = concat(command.runs, " runs of ", experiment.per_run, " of ", catalogue.stones.size(),
                            " stones, ", robot.name, ", seed ", command.common.seed);
  const SurvivalOptions survival;
  experiment.survival_seconds = survival.seconds;
  for (int k = 1; k <= command.runs; ++k) {
    SimulatedRun run = settings;
    run.seed = 1000 * command.common.seed + k;
    spread_seed(run);
    const auto present = draw_stones(catalogue, command.per_run, run.seed, hand_of(CellLayout{}), robot);
    log_info(concat("run ", k, " of ", command.runs));
    FinishedRun done;
    try {
      done = perform(run, catalogue, robot, present, concat(folder, "/run-", k),
                     command.survival ? &survival : nullptr);
      performed.interrupted = done.report.result.end == RunResult::End::kInterrupted;
    } catch (const Interrupted&) {
      performed.interrupted = true;
    }
    if (performed.interrupted) {
      log_info(concat("interrupted; run ", k, " is not counted"));
      break;
    }
    experiment.runs.push_back({done.report, done.survival});
    write_record(experiment, folder);
    log_info(concat("run ", k, ": height ", judged_height(experiment.runs.back()), "; ",
                    done.report.result.ended));
  }
  return performed;
}

std::string out_folder(const ExperimentCommand& command) {
  if (!command.out.empty()) return command.out;
  const std::time_t now = std::time(nullptr);
  char stamp[32];
  std::strftime(stamp, sizeof stamp, "%Y%m%d-%H%M%S", std::localtime(&now));
  return concat("experiments/", stamp, "-seed", command.common.seed);
}

std::vector<Variant> variants_of(const ExperimentCommand& command) {
  std::vector<Variant> list;
  if (command.compare == "cell") list = cell_variants();
  if (command.compare == "design") list = design_variants();
  for (const auto& text : command.variants) list.push_back(parse_variant(text));
  return list;
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
  std::snprintf(row, sizeof row, "%-28s %5zu   %5.2f   %3d of %-3d (%3.0f to %3.0f %%)   %6.1f\n",
                variant.name.c_str(), experiment.runs.size(), height / n, whole.hits, whole.trials,
                100 * whole.low(), 100 * whole.high(), seconds / n);
  return row;
}

/// A table with a row for each variant.
void compare(ExperimentCommand& command, const std::vector<Variant>& variants, const Catalogue& catalogue,
             const RobotModel& robot, const std::string& folder) {
  std::string table = "variant                       runs   height   whole                    robot s\n";
  std::cerr << table;
  for (std::size_t v = 0; v < variants.size(); ++v) {
    SimulatedRun run = command.run;
    const FieldList list = fields(run);
    for (const auto& assignment : variants[v].assignments) set_field(list, assignment);
    const Performed done = perform_runs(command, run, catalogue, robot, concat(folder, "/variant-", v + 1));
    if (!done.experiment.runs.empty()) {
      const std::string row = comparison_row(variants[v], done.experiment);
      table += row;
      std::cerr << row;
      write_file(folder + "/comparison.txt", table);
    }
    if (done.interrupted) throw Interrupted();
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
  const std::string folder = out_folder(command);
  require(!std::filesystem::exists(folder), folder,
          " is there already; name another folder with --out, or remove it");
  if (!variants.empty()) return compare(command, variants, catalogue, robot, folder);
  const auto [done, interrupted] = perform_runs(command, command.run, catalogue, robot, folder);
  if (!done.runs.empty()) {
    std::cerr << '\n'
              << experiment_table(done) << "record: " << folder
              << " (figure5.svg, runs.csv, a folder a run)\n";
    if (command.common.json) std::cout << experiment_json(done);
  }
  if (interrupted) throw Interrupted();
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
  sub->add_option("--out", command->out, "Folder for the record (default: experiments/<time>-seed<seed>)");
  command->common.register_on(*sub);
  sub->footer(
      "Run k of seed S has the seed 1000 S + k. Heights are the simulated world's own, after 60 s.\n"
      "Examples:\n"
      "  stonestack experiment --runs 11 --stones 6 --per-run 4 --seed 1\n"
      "  stonestack experiment --runs 200 --catalogue rocks --stones 16 --json > rocks.json\n"
      "  stonestack experiment --runs 20 --compare cell --survival false\n"
      "  stonestack experiment --runs 20 --variant 'as it is:' --variant 'wide: search.beam=6'");
  sub->callback([command] { experiment(*command); });
}

}  // namespace stonestack::apps
