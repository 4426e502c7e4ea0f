#include <iostream>
#include <memory>
#include <optional>

#include "commands.hpp"
#include "common_options.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/emulators/simulated_servers.hpp"
#include "stonestack/stacking/check_cell.hpp"

namespace stonestack::apps {
namespace {

struct DoctorCommand {
  CommonOptions common;
  std::string cell;
  CellCheckOptions check;
};

void doctor(DoctorCommand& command) {
  CellFile file = read_cell(command.cell.empty() ? data_path("cells/loopback-ur10.yaml") : command.cell);
  set_cell(file, [&](const FieldList& list) { command.common.settings.apply(list); });
  Catalogue catalogue;
  std::unique_ptr<SimulatedCell> world;
  std::optional<SimulatedServers> servers;
  if (file.simulate && is_served_elsewhere(file)) {
    log_info("the devices of " + file.path + " are simulated by another process, which is examined");
  } else if (file.simulate) {
    catalogue = command.common.read();
    const RobotModel robot = read_robot(file.robot());
    world = std::make_unique<SimulatedCell>(catalogue.stones, std::vector<StoneIndex>{StoneIndex(0)}, robot,
                                            true_layout(to_layout(file.cell()), file.servers()));
    servers.emplace(*world, robot, file.servers());
    connect_to(*servers, file.cell());
    log_info("the devices of " + file.path + " are simulated here");
  }
  std::ostream& out = command.common.text();
  command.check.on_check = [&out](const CellCheck& check) { out << to_text(check) << std::endl; };
  const CellReport report = check_cell(file.cell(), command.check);
  if (command.common.json) std::cout << cell_report_json(report);
  if (report.failed() > 0)
    throw Error(
        concat(file.path, ": ", report.failed(), " of ", report.checks.size(), " checks failed, see above"),
        ExitCode::kExecutionFailed);
}

}  // namespace

void add_doctor(CLI::App& app) {
  const auto [sub, command] = add_subcommand<DoctorCommand>(
      app, "doctor", "Check every device of a cell, step by step; moves nothing", doctor);
  add_path(sub, "--cell", command.cell, "Cell file (default: the loopback cell, simulated here)");
  sub.add_option("--frames", command.check.frames, "Number of depth frames to check")
      ->check(CLI::Range(2, 100000))
      ->capture_default_str();
  command.common.register_on(sub);
  sub.footer(
      "Reports for each device what is wrong and what to do. Exit code 0 when all is well, 6 otherwise.\n"
      "--set takes what the cell file may hold, and beats it: `stonestack config cell --expert` lists it.\n"
      "Of a simulated cell on the standard ports it examines what `stonestack simulate` serves, if it runs.\n"
      "Examples:\n"
      "  stonestack doctor --cell my_lab.yaml\n"
      "  stonestack doctor --cell my_lab.yaml --frames 300 --set camera.v4l2.record=raw_frames\n"
      "  stonestack doctor --cell simulated-ur10\n"
      "  stonestack doctor --set simulators.gripper.wire_faults.exceptions=-1\n"
      "  stonestack doctor --json");
}

}  // namespace stonestack::apps
