#include <algorithm>
#include <chrono>
#include <iostream>
#include <limits>
#include <thread>

#include "commands.hpp"
#include "common_options.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/emulators/simulated_servers.hpp"
#include "stonestack/motion/planning_scene.hpp"
#include "stonestack/stacking/observe.hpp"

namespace stonestack::apps {
namespace {

const std::vector<std::string> kDevices = {"arm", "gripper", "ft", "camera"};

struct SimulateCommand {
  CommonOptions common;
  std::string cell;
  PerRun per_run;
  double seconds = 0.0;
  std::vector<std::string> only;  // of kDevices; empty: all
  SimulationOptions simulation;
};

ServedDevices served(const std::vector<std::string>& only) {
  const auto wanted = [&](const std::string& device) {
    return only.empty() || std::find(only.begin(), only.end(), device) != only.end();
  };
  return {wanted(kDevices[0]), wanted(kDevices[1]), wanted(kDevices[2]), wanted(kDevices[3])};
}

/// The gripper that the stones must fit. Where none does, and no arm is there to carry one, any will do.
GripperModel gripper_for(const Catalogue& catalogue, GripperModel gripper, const RobotModel& robot,
                         bool with_arm) {
  const auto is_fit = [&](const Stone& stone) { return unfit_for_gripper(stone, gripper, robot).empty(); };
  if (with_arm || std::any_of(catalogue.stones.begin(), catalogue.stones.end(), is_fit)) return gripper;
  log_warning(
      "no stone of the catalogue can be carried by this gripper; the devices are served all the same");
  gripper.payload = gripper.max_opening = std::numeric_limits<double>::infinity();
  return gripper;
}

void simulate(SimulateCommand& command) {
  const int seed = command.simulation.seed = command.common.seed;
  CellFile file = read_cell(command.cell.empty() ? data_path("cells/simulated-ur10.yaml") : command.cell);
  command.common.settings.apply(
      join({nest("simulation", fields(command.simulation)), nest("simulators", fields(file.servers()))}));
  const ServedDevices devices = served(command.only);
  file.serve(devices);
  const RobotModel robot = read_robot(file.robot());
  log_info(concat("making the simulated cell of ", file.path, ", seed ", seed,
                  "; its devices are served when this is done"));
  const Catalogue catalogue = command.common.read();
  command.per_run.check(catalogue);
  RobotModel any = robot;  // served to any client, which has a gripper of its own
  any.payload = std::numeric_limits<double>::infinity();
  const GripperModel gripper = gripper_for(catalogue, gripper_of(to_layout(file.cell())), any, devices.arm);
  SimulatedCell world(catalogue.stones, draw_stones(catalogue, command.per_run.count, seed, gripper, any),
                      robot, true_layout(to_layout(file.cell()), file.servers()), command.simulation);
  const SimulatedServers servers(world, robot, file.servers());
  std::cout << servers.text() << std::flush;
  log_info("serving until Ctrl-C");
  const Stopwatch watch;
  while ((command.seconds <= 0 || watch.seconds() < command.seconds) && !interrupt_noted())
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  log_info("stopped");
}

}  // namespace

void add_simulate(CLI::App& app) {
  const auto [sub, command] = add_subcommand<SimulateCommand>(
      app, "simulate", "Serve a simulated cell: UR controller, gripper, force sensor, camera", simulate);
  add_path(sub, "--cell", command.cell,
           "Cell file; its group `simulators` gives the ports (default: the vendors' on 127.0.0.1)");
  sub.add_option("--only", command.only,
                 "Serve these devices alone: arm, gripper, ft (force sensor), camera; by commas or again")
      ->delimiter(',')
      ->check(CLI::IsMember(kDevices))
      ->type_name("DEVICE");
  command.per_run.register_on(sub);
  sub.add_option("--seconds", command.seconds, "End after so long (0: at Ctrl-C)")
      ->check(CLI::NonNegativeNumber);
  command.common.register_on(sub);
  sub.footer(
      "The protocols are the real ones, for other people's clients, too; docs/clients.md lists those\n"
      "that were tried, and how. Everything listens on loopback. Properties and faults of the devices\n"
      "are fields of the cell file's group `simulators`, and --set overrides it: `stonestack config cell "
      "--expert` lists\n"
      "them, docs/failure-modes.md explains the faults.\n"
      "Examples:\n"
      "  stonestack simulate --cell simulated-ur10\n"
      "  stonestack simulate --cell loopback-ur10 --seed 3 --seconds 60\n"
      "  stonestack simulate --only gripper,ft\n"
      "  stonestack simulate --set simulators.arm.faults.protective_stop_at=10");
}

}  // namespace stonestack::apps
