#include <iostream>
#include <memory>
#include <optional>

#include "cell_input.hpp"
#include "commands.hpp"
#include "common_options.hpp"
#include "run_folder.hpp"
#include "simulated_run.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/stacking/observe.hpp"

namespace stonestack::apps {
namespace {

struct RunCommand {
  CommonOptions common;
  std::string robot = "ur10";
  std::string out;
  std::string cell;
  bool execute = false;
  int per_run = 4;
  const CLI::Option* asked_per_run = nullptr;
  SimulatedRun run;
  std::optional<CellFile> file;     ///< of --cell
  std::optional<RobotModel> model;  ///< of --robot, without --cell
};

/// A real arm moves only when somebody who knows says so.
void check_permission(const RunCommand& command, const CellFile& file) {
  require_arm_address(file.cell);
  require(command.execute, "--cell ", command.cell, " moves the robot at ", file.cell.arm.address,
          ": check the cell with `stonestack doctor --cell ", command.cell,
          "`, clear it of people, and add --execute");
}

/// Refuses what can be refused before a folder is made.
void check_command(const RunCommand& command, const Catalogue& catalogue) {
  require_stones(catalogue, command.per_run, command.asked_per_run);
  if (!command.file) return;
  const CellFile& file = *command.file;
  require(command.robot == file.cell.robot, "--robot ", command.robot, " is not the robot of ", command.cell,
          ", ", file.cell.robot);
  if (!file.simulate) check_permission(command, file);
}

FinishedRun build_tower_for(const RunCommand& command, const Catalogue& catalogue,
                            const RecordFolder& folder) {
  const auto draw = [&](const CellLayout& layout, const RobotModel& robot) {
    return draw_stones(catalogue, command.per_run, command.common.seed, gripper_of(layout), robot);
  };
  if (!command.file) {
    const RobotModel& robot = *command.model;
    return perform(command.run, catalogue, robot, draw(CellLayout{}, robot), folder);
  }
  const CellFile& file = *command.file;
  if (!file.simulate) return perform_real(command.run, catalogue, file, folder);
  const RobotModel robot = read_cell_robot(file.cell);
  return perform(command.run, catalogue, robot, draw(to_layout(file.cell), robot), folder, nullptr, &file);
}

ExitCode exit_code(const RunResult& result) {
  switch (result.end) {
    case RunResult::End::kAllPlaced:
    case RunResult::End::kHeightReached:
      return ExitCode::kDone;
    case RunResult::End::kNothingSeen:
      return ExitCode::kNothingDetected;
    case RunResult::End::kNoPose:
      return result.height > 1 ? ExitCode::kDone : ExitCode::kNoStablePose;
    case RunResult::End::kNoPlan:
    case RunResult::End::kPlacementFailed:
      return ExitCode::kExecutionFailed;
    case RunResult::End::kStopped:
      return ExitCode::kSafetyStop;
    case RunResult::End::kInterrupted:
      return ExitCode::kInterrupted;
    case RunResult::End::kFailed:
      return ExitCode::kInternal;
  }
  return ExitCode::kInternal;
}

void run(RunCommand& command) {
  command.common.begin();
  require(!command.execute || !command.cell.empty(), "--execute moves a real robot: name its cell with ",
          "--cell FILE, or leave --execute out for the simulated cell");
  command.run.seed = command.common.seed;
  spread_seed(command.run);
  FieldList list = fields(command.run);
  if (!command.cell.empty()) command.file = read_cell(command.cell);
  if (command.file && command.file->simulate)
    list = join({list, nest("simulators", fields(command.file->servers))});
  command.common.settings.apply(list);
  if (command.cell.empty()) command.model = read_robot(command.robot);  // a wrong name before all else
  const Catalogue catalogue = command.common.read();
  check_command(command, catalogue);
  const RecordFolder folder = take_run_folder(command.out, command.common.seed);
  const auto [report, survival, unwritten] = build_tower_for(command, catalogue, folder);
  std::cerr << run_table(report);
  if (!report.picture.empty()) std::cerr << "picture: " << report.picture << '\n';
  std::cerr << (unwritten.empty() ? "report:  " : "record:  ") << folder.path()
            << (unwritten.empty() ? "/report.html\n" : "\n");
  if (command.common.json) std::cout << run_json(report);
  const ExitCode code = exit_code(report.result);
  if (!unwritten.empty() && code == ExitCode::kDone) throw Error(unwritten, ExitCode::kUnreadable);
  if (!unwritten.empty()) log_error(unwritten);
  if (code != ExitCode::kDone) throw Error(report.result.ended, code);
  throw_if_interrupted();
}

}  // namespace

void add_run(CLI::App& app) {
  auto command = std::make_shared<RunCommand>();
  CLI::App* sub = app.add_subcommand("run", "Build a tower: observe, search, plan, place, observe again");
  sub->add_option(
         "--robot", command->robot,
         "ur3, ur5, ur10, ur3e, ur5e, ur10e, ur16e, a URDF with UR kinematics, or a YAML of a calibrated "
         "robot")
      ->capture_default_str();
  sub->add_option(
         "--cell", command->cell,
         "Cell file, or the name of one that comes with stonestack: loopback-ur10 serves the "
         "simulated devices on sockets and uses "
         "the real backends; without: simulated in process. Its layout names what hangs on the arm and "
         "obstacles that the arm must not touch")
      ->type_name("FILE");
  sub->add_flag("--execute", command->execute, "Yes, move the real robot that --cell names");
  command->asked_per_run =
      sub->add_option("--per-run", command->per_run, "How many stones of the catalogue lie in the field")
          ->check(CLI::Range(1, 100))
          ->capture_default_str();
  command->common.settings.bind(
      sub->add_option("--height", command->run.build.max_stones, "Stop at this height (0: all stones)")
          ->check(CLI::Range(0, 100)),
      "run.max_stones");
  command->common.settings.bind(
      sub->add_option("--method", command->run.build.search.method, "Pose search: default or paper")
          ->check(CLI::IsMember({"default", "paper"}))
          ->capture_default_str(),
      "search.method");
  sub->add_option("--out", command->out,
                  "Folder for journal, options, picture and report (default: runs/<time>-<seed>)");
  command->common.register_on(*sub);
  sub->footer(
      "Without hardware the tower is built in a simulated cell that keeps its truth to itself.\n"
      "Examples:\n"
      "  stonestack run --robot ur10\n"
      "  stonestack run --robot ur10 --seed 7 --per-run 6 --json > result.json\n"
      "  stonestack run --robot ur10 --cell loopback-ur10\n"
      "  stonestack run --catalogue rocks --set search.friction=0.3 --set simulation.friction=0.4");
  sub->callback([command] { run(*command); });
}

}  // namespace stonestack::apps
