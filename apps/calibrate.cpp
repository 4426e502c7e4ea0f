#include <algorithm>
#include <cstdio>
#include <iostream>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>

#include "cell_input.hpp"
#include "commands.hpp"
#include "common_options.hpp"
#include "geometry/pose_json.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/hardware/cell_file.hpp"
#include "stonestack/kinematics/hand_eye.hpp"

namespace stonestack::apps {
namespace {

constexpr double kDegree = 3.14159265358979323846 / 180.0;
// Fifteen stations of our simulated arm leave 0.5 mm and 0.1 deg; a poor board and a loose mount ten times
// that.
constexpr double kMaxShift = 0.010;         // m, root mean square: more is no calibration
constexpr double kMaxTurn = 2.0 * kDegree;  // the same

struct CalibrateCommand {
  CommonOptions common;
  std::string pairs_file;
  int simulate = 0;
  bool on_base = false;
  bool force = false;
  std::string method = "joint";
  std::string check, out, cell, example, write_pairs;
  Pose simulated_truth = Pose::Identity();  ///< what a simulated calibration should find
};

/// The mount of a simulated cell's camera, of the cell to be written if there is one; beside the arm any.
Pose simulated_truth(const CalibrateCommand& command) {
  if (command.on_base) return make_pose({0.03, -0.06, 0.08}, Eigen::Quaterniond(0.95, 0.05, -0.1, 0.25));
  CellLayout layout;
  if (!command.cell.empty()) {
    const CellFile file = read_cell(command.cell);
    layout = true_layout(to_layout(file.cell), file.servers);
  }
  return layout.T_F_T * layout.T_T_C;
}

HandEyeFile stations(const CalibrateCommand& command) {
  require(command.pairs_file.empty() != (command.simulate == 0),
          "give either a file of pairs or --simulate COUNT");
  if (command.simulate == 0) return read_hand_eye_pairs(command.pairs_file);
  const CameraMount mount = command.on_base ? CameraMount::kOnBase : CameraMount::kOnHand;
  return {mount,
          simulate_hand_eye(command.simulated_truth, mount, command.simulate, HandEyeNoise{},
                            Random::stream(static_cast<std::uint64_t>(command.common.seed), "calibrate"))};
}

nlohmann::json residual_json(const HandEyeResidual& r) {
  return {{"translation_m", r.translation}, {"rotation_rad", r.rotation}};
}

void print_table(const HandEyeResult& result, const CalibrateCommand& command) {
  std::printf("%-12s %12s %12s   %-26s %s\n", "method", "residual mm", "residual deg", "position (m)",
              command.simulate > 0 ? "error mm, deg" : "");
  for (const auto& s : result.solutions) {
    const auto& p = s.T_A_C.translation();
    std::printf("%-12s %12.3f %12.4f   %8.5f %8.5f %8.5f", s.method.c_str(), 1000 * s.residual.translation,
                s.residual.rotation / kDegree, p.x(), p.y(), p.z());
    const auto error = difference(s.T_A_C, command.simulated_truth);
    if (command.simulate > 0) std::printf("   %6.3f %7.4f", 1000 * error.translation, error.angle / kDegree);
    std::printf("\n");
  }
}

/// A calibration that exists, compared with the stations.
struct Check {
  HandEyeResidual residual;
  PoseDifference off;  ///< from the result
  bool inverted = false;
};

Check check_file(const CalibrateCommand& command, const HandEyeFile& file, const HandEyeSolution& chosen) {
  const EasyHandEye given = read_easy_handeye(command.check);
  if (given.mount != file.mount)
    throw FileError(command.check, concat("is for a camera ", to_text(given.mount)),
                    concat("the pairs are of one ", to_text(file.mount)));
  return {hand_eye_residual(file.pairs, file.mount, given.T_A_C), difference(given.T_A_C, chosen.T_A_C),
          looks_inverted(file.pairs, file.mount, given.T_A_C)};
}

std::string in_words(const HandEyeResidual& r) {
  return concat("residual ", 1000 * r.translation, " mm, ", r.rotation / kDegree, " deg");
}

/// Describes what is wrong with the result, and the remedy; empty if nothing is.
std::string caution(const HandEyeResult& result, const HandEyeSolution& chosen) {
  if (!result.warning.empty()) return result.warning;
  if (chosen.residual.translation <= kMaxShift && chosen.residual.rotation <= kMaxTurn) return {};
  return concat(in_words(chosen.residual), ", more than ", 1000 * kMaxShift, " mm or ", kMaxTurn / kDegree,
                " deg: arm and target poses do not belong together, or are in other units");
}

void print_json(const HandEyeResult& result, const HandEyeFile& file, const HandEyeSolution& chosen,
                const std::vector<std::string>& warnings, const std::optional<Check>& check) {
  nlohmann::json all = nlohmann::json::array();
  for (const auto& s : result.solutions)
    all.push_back(
        {{"method", s.method}, {"T_A_C", pose_json(s.T_A_C)}, {"residual", residual_json(s.residual)}});
  nlohmann::json out = {{"schema", "stonestack.calibrate/1"}, {"camera", to_text(file.mount)},
                        {"pairs", file.pairs.size()},         {"method", chosen.method},
                        {"T_A_C", pose_json(chosen.T_A_C)},   {"solutions", all},
                        {"warning", result.warning},          {"warnings", warnings}};
  if (check)
    out["check"] = {{"residual", residual_json(check->residual)},
                    {"off", {{"translation_m", check->off.translation}, {"rotation_rad", check->off.angle}}},
                    {"inverted", check->inverted}};
  std::cout << out.dump(2) << '\n';
}

void save(const CalibrateCommand& command, const HandEyeFile& file, const HandEyeSolution& chosen) {
  EasyHandEye out;
  if (!command.example.empty()) {
    out = read_easy_handeye(command.example);
  } else {
    out.parameters = {{"move_group", "manipulator"},
                      {"move_group_namespace", "/"},
                      {"namespace", "/stonestack/"},
                      {"robot_base_frame", "base_link"},
                      {"robot_effector_frame", "tool0"},
                      {"tracking_base_frame", "camera_depth_optical_frame"},
                      {"tracking_marker_frame", "camera_marker"}};
  }
  out.mount = file.mount;
  out.T_A_C = chosen.T_A_C;
  write_easy_handeye(command.out, out);
  log_info("wrote " + command.out);
}

void write_into_cell(const CalibrateCommand& command, const HandEyeSolution& chosen) {
  const std::string line = write_mount(command.cell, chosen.T_A_C, command.out);
  log_info(concat(command.cell, ": wrote ", line,
                  "; see what the camera makes of it: stonestack doctor --cell ", command.cell));
}

/// Stations that give no result are the file's fault.
HandEyeResult solve(const CalibrateCommand& command, const HandEyeFile& file) {
  try {
    return calibrate_hand_eye(file.pairs, file.mount);
  } catch (const InvalidArgument& problem) {
    if (command.pairs_file.empty()) throw;
    throw FileError(command.pairs_file, problem.what(),
                    "record more stations, with the hand turned about two axes at least");
  }
}

/// Says what `--check` found; returns what is wrong with that file.
std::string report(const Check& check, const std::string& path) {
  log_info(concat(path, ": ", in_words(check.residual), "; ", 1000 * check.off.translation, " mm and ",
                  check.off.angle / kDegree, " deg from the result"));
  return check.inverted ? path + ": the transformation is inverted: its inverse agrees with the pairs" : "";
}

void calibrate(CalibrateCommand& command) {
  command.common.begin();
  command.common.settings.apply({});
  if (command.simulate > 0) command.simulated_truth = simulated_truth(command);
  const HandEyeFile file = stations(command);
  require(command.cell.empty() || file.mount == CameraMount::kOnHand, "--write ", command.cell,
          ": a cell's camera is on the hand, and this calibration is of one beside the arm");
  if (!command.write_pairs.empty()) write_hand_eye_pairs(command.write_pairs, file);
  const HandEyeResult result = solve(command, file);
  const auto chosen = std::find_if(result.solutions.begin(), result.solutions.end(),
                                   [&](const HandEyeSolution& s) { return s.method == command.method; });
  require(chosen != result.solutions.end(), "method ", command.method, " has no result for these pairs");
  std::optional<Check> check;
  if (!command.check.empty()) check = check_file(command, file, *chosen);
  const std::string problem = caution(result, *chosen);
  std::vector<std::string> warnings;
  if (!problem.empty()) warnings.push_back(problem);
  if (check)
    if (const auto inverted = report(*check, command.check); !inverted.empty()) warnings.push_back(inverted);
  if (command.common.json)
    print_json(result, file, *chosen, warnings, check);
  else
    print_table(result, command);
  for (const auto& warning : warnings) log_warning(warning);
  if (command.out.empty() && command.cell.empty()) return;
  if (!problem.empty() && !command.force)
    throw FileError(
        command.pairs_file.empty() ? "--simulate" : command.pairs_file,
        concat("gives no calibration (", in_words(chosen->residual), "), so nothing was written to ",
               command.out, command.out.empty() || command.cell.empty() ? "" : " and ", command.cell),
        "check that each line holds one station's arm and target pose, in metres; --force writes it");
  if (!command.out.empty()) save(command, file, *chosen);
  if (!command.cell.empty()) write_into_cell(command, *chosen);
}

}  // namespace

void add_calibrate(CLI::App& app) {
  auto command = std::make_shared<CalibrateCommand>();
  CLI::App* sub =
      app.add_subcommand("calibrate", "Where the camera sits on the hand, from arm and target poses");
  sub->add_option("PAIRS", command->pairs_file, "YAML of stations: T_R_F from the arm, T_C_B of the target");
  sub->add_option("--simulate", command->simulate, "Simulate that many stations in place of a file")
      ->check(CLI::Range(3, 1000));
  sub->add_flag("--on-base", command->on_base, "Simulate a camera beside the arm");
  sub->add_option("--method", command->method, "Whose result is written")
      ->check(CLI::IsMember({"joint", "tsai_lenz", "park_martin", "daniilidis"}))
      ->capture_default_str();
  sub->add_option("--check", command->check, "An easy_handeye file to compare with the stations")
      ->type_name("FILE");
  sub->add_option("--out", command->out, "Write the result as an easy_handeye file")->type_name("FILE");
  sub->add_option("--write", command->cell,
                  "Write the result into this cell file and leave the rest as it is: layout.T_T_C, or "
                  "layout.hand_eye: the file of --out")
      ->type_name("CELL");
  sub->add_flag("--force", command->force, "Write a result that looks wrong, too");
  sub->add_option("--like", command->example, "Take frame names and the other parameters from this file")
      ->type_name("FILE");
  sub->add_option("--write-pairs", command->write_pairs, "Write the stations that were used")
      ->type_name("FILE");
  command->common.register_on(*sub);
  sub->footer(
      "Examples:\n"
      "  stonestack calibrate --simulate 15 --seed 1\n"
      "  stonestack calibrate pairs.yaml --out ur10_sr300.yaml\n"
      "  stonestack calibrate pairs.yaml --write my_lab.yaml && stonestack doctor --cell my_lab.yaml\n"
      "  stonestack calibrate pairs.yaml --check ~/.ros/easy_handeye/ur10_sr300.yaml\n"
      "PAIRS: {schema: stonestack.hand_eye/1, camera: on_hand, pairs: [{T_R_F: {x, y, z, qx, qy, qz, qw}, "
      "T_C_B: ...}]}");
  sub->callback([command] { calibrate(*command); });
}

}  // namespace stonestack::apps
