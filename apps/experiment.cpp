#include <iostream>
#include <set>

#include "commands.hpp"
#include "common_options.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/report/record_run.hpp"
#include "version.hpp"

namespace stonestack::apps {
namespace {

struct ExperimentCommand {
  CommonOptions common;
  std::string robot = "ur10";
  std::string compare;
  std::vector<std::string> variants;
  std::vector<std::string> merge;
  const CLI::App* app = nullptr;
  ExperimentOrder order;
  RecordExperiment record;
};

std::vector<Variant> variants_of(const ExperimentCommand& command) {
  std::vector<Variant> list;
  if (command.compare == "cell") list = cell_variants();
  if (command.compare == "design") list = design_variants();
  for (const auto& text : command.variants) list.push_back(parse_variant(text));
  return list;
}

/// All but the place for the result is in the records.
RecordedExperiment merged(const ExperimentCommand& command) {
  const std::set<std::string> fit{"--merge", "--out", "--json", "--quiet", "--verbose"};
  for (const CLI::Option* given : command.app->get_options([](const auto* o) { return o->count() > 0; }))
    require(fit.count(given->get_name()) > 0, "--merge takes all options from the records: leave out ",
            given->get_name());
  return merge_experiments(command.merge, command.order.out);
}

RecordedExperiment performed(ExperimentCommand& command) {
  ExperimentOrder& order = command.order;
  command.common.settings.apply(fields(order.run));
  order.robot = read_robot(command.robot);
  order.seed = command.common.seed;
  order.variants = variants_of(command);
  order.version = program_version();
  require(order.new_stones == 0 || command.common.catalogue.empty(), "--new-stones and --catalogue ",
          command.common.catalogue, ": new stones are drawn from a folder with --new-stones-from");
  return command.record(order, order.new_stones > 0 ? Catalogue{} : command.common.read(),
                        [](const std::string& row) {
                          clear_progress();
                          std::cerr << row;
                        });
}

void experiment(ExperimentCommand& command) {
  std::ostream& out = command.common.text();
  const RecordedExperiment done = command.merge.empty() ? performed(command) : merged(command);
  clear_progress();
  const bool whole = !done.interrupted && done.unwritten.empty();
  if (!command.order.variants.empty()) {
    if (whole) out << '\n' << done.comparison << "record: " << done.folder << '\n';
  } else if (!done.experiment.runs.empty()) {
    out << '\n'
        << experiment_table(done.experiment) << "record: " << done.folder
        << " (report.html, figure5.svg, runs.csv, a folder a run)\n";
    if (command.common.json) std::cout << experiment_json(done.experiment);
  }
  if (done.interrupted) throw Interrupted();
  if (!done.unwritten.empty()) throw Error(done.unwritten, ExitCode::kUnreadable);
  if (!done.missing.empty())
    throw FileError(done.folder, "runs are missing: " + done.missing,
                    concat("do them by --continue --out ", done.folder));
}

/// Registers all but --merge and the examples.
Subcommand<ExperimentCommand> register_experiment(CLI::App& app, const RecordExperiment& record) {
  const auto subcommand = add_subcommand<ExperimentCommand>(
      app, "experiment", "The paper's experiment: consecutive runs, heights, figure 5", experiment);
  const auto& [sub, command] = subcommand;
  ExperimentOrder& order = command.order;
  command.record = record;
  sub.add_option("--runs", order.runs, "Number of runs")->check(CLI::Range(1, 100000))->capture_default_str();
  CLI::Option* const stones = sub.add_option("--stones", order.stones, "Stones of the catalogue to draw from")
                                  ->check(CLI::Range(1, 1000))
                                  ->capture_default_str();
  sub.add_option("--new-stones", order.new_stones,
                 "Stones that each run has for itself, to draw from: limestones that are generated for it")
      ->check(CLI::Range(1, 100))
      ->excludes(stones);
  add_path(sub, "--new-stones-from", order.new_stones_from,
           "Draw the new stones from this catalogue; none comes again before all did", "DIR");
  sub.add_option("--protocol", order.protocol,
                 "full: until nothing more can be placed; paper: a run ends at the first placement that "
                 "fails, no stone is unstacked, reoriented or picked twice")
      ->check(CLI::IsMember({"full", "paper"}))
      ->capture_default_str();
  sub.add_option("--per-run", order.per_run, "Stones in the field of each run")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  sub.add_option("--robot", command.robot, "ur3 to ur16e or a URDF with UR kinematics")
      ->capture_default_str();
  sub.add_option("--survival", order.survival, "Let each tower stand for 600 s and shake it")
      ->capture_default_str();
  sub.add_option("--compare", command.compare,
                 "cell: what each error of the cell costs; design: what each part of the design is worth")
      ->check(CLI::IsMember({"cell", "design"}));
  sub.add_option("--variant", command.variants,
                 "Another row: 'NAME: OPTION=VALUE, OPTION=VALUE' (repeatable)");
  add_objective(sub, order.run.build.search.objective, command.common.settings);
  command.common.settings.bind(sub.add_flag("--unseen", order.run.build.unseen,
                                            "No catalogue is known: each run models its stones first"),
                               "run.unseen");
  sub.add_flag("--continue", order.continues,
               "Go on with the runs that the folder --out holds: the same command, stopped before");
  sub.add_option("--out", order.out, "Folder for the record (default: experiments/<time>-seed<seed>)");
  sub.add_option_function<std::string>(
         "--shard", [&order](const std::string& text) { order.shard = parse_shard(text); },
         "Only runs I, I + N, I + 2 N, ... of the experiment: the part of one machine of N")
      ->type_name("I/N");
  command.app = &sub;
  add_live_view(sub, order.view);
  command.common.register_on(sub);
  return subcommand;
}

}  // namespace

CLI::App& add_experiment_by(CLI::App& app, const RecordExperiment& record) {
  return register_experiment(app, record).app;
}

void add_experiment(CLI::App& app) {
  const auto [sub, command] = register_experiment(app, record_experiment);
  sub.add_option("--merge", command.merge, "Join the records of shards into one in the folder --out")
      ->type_name("DIR");
  sub.footer(
      "Run k of seed S has the seed 1000 S + k. Heights are the simulated world's own, after 60 s.\n"
      "How hard the cell is: --set simulation.NAME=VALUE (names: `stonestack config show --expert | grep "
      "simulation`).\n"
      "Examples:\n"
      "  stonestack experiment --runs 11 --stones 6 --per-run 4 --seed 1\n"
      "  stonestack experiment --runs 200 --catalogue rocks --stones 16 --out long --continue\n"
      "  stonestack experiment --runs 100 --new-stones 4 --set simulation.engine=ode\n"
      "  stonestack experiment --runs 100 --new-stones 4 --new-stones-from rocks --protocol paper\n"
      "  stonestack experiment --runs 20 --compare cell --survival false\n"
      "  stonestack experiment --runs 20 --variant 'as it is:' --variant 'wide: search.beam=6'\n"
      "On many machines, each with a shard of the runs; the last line makes one record of them:\n"
      "  sbatch --array=1-8 --wrap 'stonestack experiment --runs 200 --seed 5 "
      "--shard $SLURM_ARRAY_TASK_ID/8 --out shard-$SLURM_ARRAY_TASK_ID --continue'\n"
      "  stonestack experiment --merge shard-* --out whole\n"
      "With MPI: mpirun -n 8 stonestack-mpi experiment --runs 200 --seed 5 --out whole");
}

}  // namespace stonestack::apps
