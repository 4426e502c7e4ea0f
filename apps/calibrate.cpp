#include <functional>
#include <iostream>
#include <optional>

#include "commands.hpp"
#include "common_options.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/emulators/simulated_servers.hpp"
#include "stonestack/hardware/cell_file.hpp"
#include "stonestack/kinematics/hand_eye.hpp"
#include "stonestack/stacking/check_cell.hpp"

namespace stonestack::apps {
namespace {

struct CalibrateCommand {
  CommonOptions common;
  std::string pairs_file;
  int simulate = 0;
  bool on_base = false;
  bool force = false;
  HandEyeCalibrationOptions calibration;
  std::string out, cell, example, write_pairs;
  std::string table;          ///< cell whose table is touched
  std::string capture;        ///< cell whose arm takes the stations
  std::vector<double> block;  ///< sides of the target [m]; empty: a stone
  CaptureOptions stations;
  bool execute = false;
  SimulationOptions simulation;
};

/// The mount of a simulated cell's camera, of the cell to be written if there is one; beside the arm any.
Pose simulated_mount(const CalibrateCommand& command) {
  if (command.on_base) return make_pose({0.03, -0.06, 0.08}, Eigen::Quaterniond(0.95, 0.05, -0.1, 0.25));
  CellLayout layout;
  if (!command.cell.empty()) {
    const CellFile file = read_cell(command.cell);
    layout = true_layout(to_layout(file.cell()), file.servers());
  }
  return layout.T_F_T * layout.T_T_C;
}

void write_result(const CalibrateCommand& command, const HandEyeCalibration& done) {
  if (command.out.empty() && command.cell.empty()) return;
  if (!done.uncertainty.empty() && !command.force)
    throw FileError(
        !command.capture.empty()     ? command.capture
        : command.pairs_file.empty() ? "--simulate"
                                     : command.pairs_file,
        concat("gives no calibration (", to_text(done.chosen.residual), "), so nothing was written to ",
               command.out, command.out.empty() || command.cell.empty() ? "" : " and ", command.cell),
        concat(command.capture.empty()
                   ? "check that each line holds one station's arm and target pose, in metres"
                   : "take a scanned stone or a larger block as the target, and leave it alone",
               "; --force writes it"));
  if (!command.out.empty()) {
    write_calibration(command.out, done, command.example);
    log_info("wrote " + command.out);
  }
  if (!command.cell.empty())
    log_info(concat(command.cell, ": wrote ", write_mount(command.cell, done.chosen.T_A_C, command.out),
                    "; see what the camera makes of it: stonestack doctor --cell ", command.cell));
}

/// Result of `work` with the connected devices of a cell, and its robot.
template <class Work>
auto with_devices_of(const CellConfig& cell, const Work& work) {
  const RobotModel robot = read_cell_robot(cell);
  HardwareCell hardware(cell);
  hardware.activate_gripper();
  Cell devices = hardware.cell();
  return work(devices, robot);
}

/// Result of `work` with the devices of a cell file. A real arm moves only with --execute.
/// @param present   stones of `catalogue` in the field of a cell that is simulated here
template <class Work>
auto with_devices_of(const std::string& path, const CalibrateCommand& command, const std::string& prepared,
                     const std::function<Catalogue()>& catalogue, const std::vector<StoneIndex>& present,
                     const Work& work) {
  CellFile file = read_cell(path);
  if (!file.simulate) {
    require_arm_address(file.cell());
    require(command.execute, path, " moves the robot at ", file.arm_address(), ": ", prepared,
            ", and add --execute");
    return with_devices_of(file.cell(), work);
  }
  const Catalogue known = catalogue();
  const RobotModel robot = read_robot(file.robot());
  SimulatedCell world(known.stones, present, robot, true_layout(to_layout(file.cell()), file.servers()),
                      command.simulation);
  const SimulatedServers servers(world, robot, file.servers());
  connect_to(servers, file.cell());
  log_info("the devices of " + file.path + " are simulated here");
  return with_devices_of(file.cell(), work);
}

/// Reads the options, and sees that the result can be kept, before an arm moves.
void prepare(CalibrateCommand& command) {
  command.common.settings.apply(nest("simulation", fields(command.simulation)));
  command.simulation.seed = command.common.seed;
  for (const std::string& path : {command.cell, command.out, command.write_pairs})
    if (!path.empty()) require_writable(path);
}

HandEyeFile captured_stations(const CalibrateCommand& command) {
  const Catalogue targets = command.block.empty()
                                ? command.common.read()
                                : block_target({command.block[0], command.block[1], command.block[2]});
  const StoneIndex present =
      command.stations.target.empty() ? 0_stone : targets.index(command.stations.target);
  return with_devices_of(
      command.capture, command, "lay the target into the middle of the field, clear the cell of people",
      [&] { return targets; }, {present},
      [&](Cell& cell, const RobotModel& robot) {
        return capture_stations(cell, robot, targets, command.stations);
      });
}

HandEyeFile stations(const CalibrateCommand& command, const std::optional<Pose>& true_T_A_C) {
  if (!command.capture.empty()) return captured_stations(command);
  require(command.pairs_file.empty() == true_T_A_C.has_value(),
          "give a file of stations, --capture CELL, --table CELL or --simulate N");
  if (!true_T_A_C) return read_hand_eye_pairs(command.pairs_file);
  const CameraMount mount = command.on_base ? CameraMount::kOnBase : CameraMount::kOnHand;
  return {mount,
          simulate_hand_eye(*true_T_A_C, mount, command.simulate, {},
                            Random::stream(static_cast<std::uint64_t>(command.common.seed), "calibrate"))};
}

void calibrate_table(CalibrateCommand& command) {
  prepare(command);
  const TouchedTable table = with_devices_of(
      command.table, command, "clear the field of stones and the cell of people, empty the gripper",
      [&] { return command.common.read(); }, {},
      [](Cell& cell, const RobotModel& robot) { return touch_table(cell, robot); });
  command.common.text() << to_text(table);
  if (command.common.json) std::cout << touched_table_json(table);
  if (!table.problems.empty() && !command.force)
    throw Error(concat(command.table, ": camera and touch disagree, see above",
                       command.cell.empty() ? "" : "; nothing was written, --force writes it"),
                ExitCode::kExecutionFailed);
  if (command.cell.empty()) return;
  log_info(concat(command.cell, ": wrote ", write_base(command.cell, table.T_W_R),
                  ", with which the touched table is z = 0"));
}

void calibrate(CalibrateCommand& command) {
  require(command.table.empty() || command.pairs_file.empty(),
          "give either a file of stations or --table CELL");
  require(command.capture.empty() || command.pairs_file.empty(),
          "give either a file of stations or --capture CELL");
  require(!command.execute || !command.table.empty() || !command.capture.empty(),
          "--execute goes with --table CELL or --capture CELL");
  require(command.block.empty() || command.stations.target.empty(), "give either --block or --target");
  if (!command.table.empty()) return calibrate_table(command);
  if (command.capture.empty())
    command.common.settings.apply({});
  else
    prepare(command);
  std::optional<Pose> true_T_A_C;
  if (command.simulate > 0) true_T_A_C = simulated_mount(command);
  const HandEyeFile file = stations(command, true_T_A_C);
  require(command.cell.empty() || file.mount == CameraMount::kOnHand, "--write ", command.cell,
          ": a cell's camera is on the gripper, and this calibration is of one beside the arm");
  if (!command.write_pairs.empty()) write_hand_eye_pairs(command.write_pairs, file);
  const HandEyeCalibration done = calibrate_stations(file, command.calibration);
  if (done.check) log_info(to_text(*done.check));
  std::cout << (command.common.json ? calibration_json(done) : calibration_table(done, true_T_A_C));
  for (const std::string& warning : done.warnings) log_warning(warning);
  write_result(command, done);
}

}  // namespace

void add_calibrate(CLI::App& app) {
  const auto [sub, command] = add_subcommand<CalibrateCommand>(
      app, "calibrate", "Where the camera sits on the arm, and whether the table is where it sees it",
      calibrate);
  sub.add_option("STATIONS", command.pairs_file, "YAML of stations: T_R_F from the arm, T_C_B of the target");
  CLI::Option* simulate =
      sub.add_option("--simulate", command.simulate, "Simulate that many stations in place of a file")
          ->check(CLI::Range(3, 1000));
  CLI::Option* on_base = sub.add_flag("--on-base", command.on_base, "Simulate a camera beside the arm");
  CLI::Option* table =
      add_path(sub, "--table", command.table,
               "Touch the table of this cell at three points, and compare it with what the camera sees",
               "CELL")
          ->excludes(simulate);
  CLI::Option* capture =
      add_path(sub, "--capture", command.capture,
               "Let the arm of this cell drive to the stations, at 0.25 m/s at most", "CELL")
          ->excludes(simulate)
          ->excludes(on_base)
          ->excludes(table);
  sub.add_option("--stations", command.stations.stations, "Stations to take")
      ->check(CLI::Range(4, 100))
      ->capture_default_str()
      ->needs(capture);
  sub.add_option("--target", command.stations.target,
                 "Stone of the catalogue that lies in the field (default: the one nearest to its middle)")
      ->needs(capture);
  sub.add_option("--block", command.block, "A block as the target: its three sides, metres")
      ->delimiter(',')
      ->expected(3)
      ->needs(capture);
  sub.add_flag("--execute", command.execute, "Yes, move the real robot of --table or --capture");
  sub.add_option("--method", command.calibration.method, "Method whose result is written")
      ->check(CLI::IsMember({"joint", "tsai_lenz", "park_martin", "daniilidis"}))
      ->capture_default_str();
  add_path(sub, "--check", command.calibration.check, "An easy_handeye file to compare with the stations");
  add_path(sub, "--out", command.out, "Write the result as an easy_handeye file");
  add_path(sub, "--write", command.cell,
           "Write the result into this cell file and leave the rest as it is: layout.T_T_C, or "
           "layout.hand_eye: the file of --out; with --table layout.T_W_R",
           "CELL");
  sub.add_flag("--force", command.force, "Write the result even if it is probably wrong");
  add_path(sub, "--like", command.example, "Take frame names and the other parameters from this file");
  add_path(sub, "--write-pairs", command.write_pairs, "Write the stations that were used");
  command.common.register_on(sub);
  sub.footer(
      "Examples:\n"
      "  stonestack calibrate --simulate 15 --seed 1\n"
      "  stonestack calibrate pairs.yaml --out ur10_sr300.yaml\n"
      "  stonestack calibrate pairs.yaml --write my_lab.yaml && stonestack doctor --cell my_lab.yaml\n"
      "  stonestack calibrate pairs.yaml --check ~/.ros/easy_handeye/ur10_sr300.yaml\n"
      "  stonestack calibrate --capture my_lab.yaml --block 0.16,0.10,0.04 --execute --write my_lab.yaml\n"
      "  stonestack calibrate --table my_lab.yaml --execute --write my_lab.yaml\n"
      "--capture: a stone of the catalogue, or a block, lies in the middle of the field and is left alone.\n"
      "--table: the field is clear and the gripper empty. The gripper opens, the camera views the field, "
      "and\n"
      "the open fingers go down at 5 mm/s until the wrist feels the table. Exit code 6 and nothing written\n"
      "where touch and camera disagree by more than 5 mm or 0.75 deg.\n"
      "STATIONS: {schema: stonestack.hand_eye/1, camera: on_hand, pairs: [{T_R_F: {x, y, z, qx, qy, qz, qw}, "
      "T_C_B: ...}]}");
}

}  // namespace stonestack::apps
