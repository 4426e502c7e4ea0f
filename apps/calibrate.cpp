#include <iostream>
#include <optional>

#include "commands.hpp"
#include "common_options.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/emulators/simulated_servers.hpp"
#include "stonestack/hardware/cell_file.hpp"
#include "stonestack/kinematics/hand_eye.hpp"

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

HandEyeFile stations(const CalibrateCommand& command, const std::optional<Pose>& true_T_A_C) {
  require(command.pairs_file.empty() == true_T_A_C.has_value(),
          "give either a file of pairs or --simulate COUNT");
  if (!true_T_A_C) return read_hand_eye_pairs(command.pairs_file);
  const CameraMount mount = command.on_base ? CameraMount::kOnBase : CameraMount::kOnHand;
  return {mount,
          simulate_hand_eye(*true_T_A_C, mount, command.simulate, {},
                            Random::stream(static_cast<std::uint64_t>(command.common.seed), "calibrate"))};
}

void write_result(const CalibrateCommand& command, const HandEyeCalibration& done) {
  if (command.out.empty() && command.cell.empty()) return;
  if (!done.uncertainty.empty() && !command.force)
    throw FileError(
        command.pairs_file.empty() ? "--simulate" : command.pairs_file,
        concat("gives no calibration (", to_text(done.chosen.residual), "), so nothing was written to ",
               command.out, command.out.empty() || command.cell.empty() ? "" : " and ", command.cell),
        "check that each line holds one station's arm and target pose, in metres; --force writes it");
  if (!command.out.empty()) {
    write_calibration(command.out, done, command.example);
    log_info("wrote " + command.out);
  }
  if (!command.cell.empty())
    log_info(concat(command.cell, ": wrote ", write_mount(command.cell, done.chosen.T_A_C, command.out),
                    "; see what the camera makes of it: stonestack doctor --cell ", command.cell));
}

void calibrate(CalibrateCommand& command) {
  command.common.settings.apply({});
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
      app, "calibrate", "Where the camera sits on the arm, from arm and target poses", calibrate);
  sub.add_option("PAIRS", command.pairs_file, "YAML of stations: T_R_F from the arm, T_C_B of the target");
  sub.add_option("--simulate", command.simulate, "Simulate that many stations in place of a file")
      ->check(CLI::Range(3, 1000));
  sub.add_flag("--on-base", command.on_base, "Simulate a camera beside the arm");
  sub.add_option("--method", command.calibration.method, "Method whose result is written")
      ->check(CLI::IsMember({"joint", "tsai_lenz", "park_martin", "daniilidis"}))
      ->capture_default_str();
  add_path(sub, "--check", command.calibration.check, "An easy_handeye file to compare with the stations");
  add_path(sub, "--out", command.out, "Write the result as an easy_handeye file");
  add_path(sub, "--write", command.cell,
           "Write the result into this cell file and leave the rest as it is: layout.T_T_C, or "
           "layout.hand_eye: the file of --out",
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
      "PAIRS: {schema: stonestack.hand_eye/1, camera: on_hand, pairs: [{T_R_F: {x, y, z, qx, qy, qz, qw}, "
      "T_C_B: ...}]}");
}

}  // namespace stonestack::apps
