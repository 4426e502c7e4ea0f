#include <iostream>
#include <set>

#include "commands.hpp"
#include "common_options.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/report/record_run.hpp"
#include "stonestack/report/results.hpp"
#include "version.hpp"

namespace stonestack::apps {
namespace {

struct RunCommand {
  CommonOptions common;
  std::string robot;  ///< empty: the cell's, or a UR10
  std::string cell, resume;
  const CLI::App* app = nullptr;
  bool execute = false, slow = false, full_speed = false, step = false;
  PerRun per_run;
  RunOrder order;
};

/// Refuses what can be refused before a folder is made. A real arm moves only with --execute.
void check_cell(const RunCommand& command, const CellFile& file) {
  require(command.robot.empty() || command.robot == file.robot(), "--robot ", command.robot,
          " is not the robot of ", command.cell, ", ", file.robot());
  if (file.simulate) return;
  require_arm_address(file.cell());
  require(command.execute || command.order.dry, "--cell ", command.cell, " moves the robot at ",
          file.arm_address(), ": check the cell with `stonestack doctor --cell ", command.cell,
          "`, clear it of people, and add --execute; --dry-run plans without moving anything");
}

/// Enter goes on; q or the end of the input stops the run.
bool ask_before(const PlannedStep& step) {
  const auto answer = ask_person("next: " + to_text(step) + " [Enter: go, q: stop] ");
  return answer && *answer != "q";
}

void set_options(RunCommand& command) {
  RunOrder& order = command.order;
  order.run.seed = command.common.seed;
  spread_seed(order.run);
  FieldList list = fields(order.run);
  if (!command.cell.empty()) order.cell = read_cell(command.cell);
  if (order.cell && order.cell->simulate)
    list = join({list, nest("simulators", fields(order.cell->servers()))});
  command.common.settings.apply(list);
  order.per_run = command.per_run.count;
}

/// How the user watches a run, and how fast it goes; what it does is in its order.
void set_mode(RunCommand& command) {
  RunOrder& order = command.order;
  order.speed = command.slow ? RunSpeed::kSlow : command.full_speed ? RunSpeed::kFull : RunSpeed::kByDefault;
  if (command.step) order.before_motion = ask_before;
  order.version = program_version();
}

/// The order of the run that goes on.
Catalogue take_up(RunCommand& command) {
  static const std::set<std::string> kAllowed{"resume", "execute",   "slow", "step",  "full-speed",
                                              "view",   "view-port", "json", "quiet", "verbose"};
  for (const CLI::Option* option : command.app->get_options()) {
    const std::string name = option->get_lnames().empty() ? option->get_name() : option->get_lnames().front();
    require(option->count() == 0 || kAllowed.contains(name), "--", name,
            " cannot be changed in a run that goes on; leave it out");
  }
  ResumableRun run = read_resumable_run(command.resume);
  run.order.view = command.order.view;
  command.order = std::move(run.order);
  if (command.order.cell) command.cell = command.order.cell->path;
  return std::move(run.catalogue);
}

Catalogue begin(RunCommand& command) {
  RunOrder& order = command.order;
  set_options(command);
  if (!order.cell)
    order.robot = read_robot(command.robot.empty() ? "ur10" : command.robot);  // a wrong name before all else
  Catalogue catalogue = command.common.read();
  command.per_run.check(catalogue);
  return catalogue;
}

/// Ends the program as the run ended.
void end(const RecordedRun& done) {
  const RunResult& result = done.report.result;
  const ExitCode code = exit_code(result);
  if (!done.unwritten.empty() && code == ExitCode::kDone) throw Error(done.unwritten, ExitCode::kUnreadable);
  if (!done.unwritten.empty()) log_error(done.unwritten);
  const std::string more =
      done.resumable ? concat("; go on with it: stonestack run --resume ", done.folder) : std::string();
  if (code != ExitCode::kDone) throw Error(result.ended + more, code);
  throw_if_interrupted();
}

void run(RunCommand& command) {
  require(!command.execute || !command.cell.empty() || !command.resume.empty(),
          "--execute moves a real robot: name its cell with ",
          "--cell FILE, or leave --execute out for the simulated cell");
  RunOrder& order = command.order;
  const Catalogue catalogue = command.resume.empty() ? begin(command) : take_up(command);
  set_mode(command);
  if (order.cell) check_cell(command, *order.cell);
  const RecordedRun done = record_run(order, catalogue);
  const RunReport& report = done.report;
  std::ostream& out = command.common.text();
  out << run_table(report);
  if (!report.picture.empty()) out << "picture: " << report.picture << '\n';
  const bool whole = done.unwritten.empty();
  out << (whole ? "report:  " : "record:  ") << done.folder << (whole ? "/report.html\n" : "\n");
  if (command.common.json) std::cout << run_json(report);
  end(done);
}

}  // namespace

void add_run(CLI::App& app) {
  const auto [sub, command] = add_subcommand<RunCommand>(
      app, "run", "Build a tower or a wall: observe, search, plan, place, observe again", run);
  command.app = &sub;
  BuildOptions& build = command.order.run.build;
  sub.add_option(
      "--robot", command.robot,
      "ur3, ur5, ur10, ur3e, ur5e, ur10e, ur16e, a URDF with UR kinematics, or a YAML of a calibrated "
      "robot (default: the cell's, or ur10)");
  add_path(sub, "--cell", command.cell,
           "Cell file, or the name of one that comes with stonestack: loopback-ur10 serves the "
           "simulated devices on sockets and uses the real backends; without: simulated in process. Its "
           "layout names what is mounted on the arm, and obstacles");
  const auto flag = [&sub = sub](const char* name, bool& value, const char* description) {
    return sub.add_flag(name, value, description);
  };
  CLI::Option* execute = flag("--execute", command.execute, "Yes, move the real robot that --cell names");
  CLI::Option* dry =
      flag("--dry-run", command.order.dry,
           "One view from where the arm stands, then the plan of the first step; moves nothing");
  CLI::Option* slow = flag("--slow", command.slow,
                           "Tool at 0.25 m/s at most: the default until a real cell has completed a run");
  flag("--full-speed", command.full_speed, "Not slow, also in a cell's first run")->excludes(slow);
  flag("--step", command.step, "Before each motion, show it and wait for Enter; q stops")->excludes(dry);
  dry->excludes(execute);
  command.per_run.register_on(sub);
  command.common.settings.bind(
      sub.add_option("--height", build.max_stones, "Stop at this height (0: all stones)")
          ->check(CLI::Range(0, 100)),
      "run.max_stones");
  command.common.settings.bind(
      sub.add_option("--method", build.search.method, "Pose search: default or paper")
          ->check(CLI::IsMember({"default", "paper"}))
          ->capture_default_str(),
      "search.method");
  add_objective(sub, build.search.objective, command.common.settings);
  add_structure(sub, build.wall, &command.common.settings);
  command.common.settings.bind(
      flag("--unseen", build.unseen,
           "The stones are in no catalogue: model them with the arm's camera first, then build"),
      "run.unseen");
  add_path(sub, "--save-catalogue", command.order.save_catalogue,
           "With --unseen: keep the modelled stones here (default: in the run's folder, stones)", "DIR");
  add_path(
      sub, "--known", command.order.known,
      "With --unseen: stones of this catalogue may lie among the others; they are recognised, not modelled",
      "DIR");
  sub.add_option("--out", command.order.out,
                 "Folder for journal, options, picture and report (default: runs/<time>-seed<seed>)");
  add_path(sub, "--resume", command.resume,
           "Go on with a run that was killed, interrupted or stopped: asks the gripper first, observes, and "
           "keeps on building; a stone in the gripper goes back to where it was picked",
           "RUN");
  add_live_view(sub, command.order.view);
  command.common.register_on(sub);
  sub.footer(
      "Without hardware the tower is built in a simulated cell that keeps its truth to itself.\n"
      "--view on another machine: ssh -L 8080:127.0.0.1:PORT, then open http://localhost:8080/ here.\n"
      "Examples:\n"
      "  stonestack run --robot ur10\n"
      "  stonestack run --robot ur10 --seed 7 --per-run 6 --json > result.json\n"
      "  stonestack run --cell loopback-ur10\n"
      "  stonestack run --robot ur10 --per-run 6 --wall 3+2+1\n"
      "  stonestack run --robot ur10 --per-run 5 --bridge 0.08\n"
      "  stonestack run --robot ur10 --unseen --save-catalogue my_stones\n"
      "  stonestack run --robot ur10 --unseen --known my_stones\n"
      "  stonestack run --robot ur10 --cell my_lab.yaml --dry-run\n"
      "  stonestack run --robot ur10 --cell my_lab.yaml --execute --slow --step\n"
      "  stonestack run --robot ur10 --view\n"
      "  stonestack run --resume runs/20250101-101500-seed1\n"
      "  stonestack run --catalogue rocks --set search.friction=0.3 --set simulation.friction=0.4");
}

}  // namespace stonestack::apps
