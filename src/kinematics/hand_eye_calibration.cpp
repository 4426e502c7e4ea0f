#include "stonestack/kinematics/hand_eye.hpp"

#include <algorithm>
#include <cstdio>
#include <numbers>

#include "core/constants.hpp"
#include "geometry/pose_json.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::kinematics {
namespace {

// Fifteen stations of our simulated arm leave 0.5 mm and 0.1 deg; a poor board and a loose mount ten times
// that.
constexpr double kMaxShift = 0.010;                    // m, root mean square: more is no calibration
constexpr double kCalibrationMaxTurn = 2.0 * kDegree;  // the same

/// Stations that give no result are the file's fault.
HandEyeResult solve(const HandEyeFile& stations) {
  try {
    return calibrate_hand_eye(stations.pairs, stations.mount);
  } catch (const InvalidArgument& problem) {
    if (stations.path.empty()) throw;
    throw FileError(stations.path, problem.what(),
                    "record more stations, with the gripper turned about two axes at least");
  }
}

HandEyeCheck check_file(const std::string& path, const HandEyeFile& stations, const Pose& T_A_C) {
  const EasyHandEye given = read_easy_handeye(path);
  if (given.mount != stations.mount)
    throw FileError(path, concat("is for a camera ", to_text(given.mount)),
                    concat("the pairs are of one ", to_text(stations.mount)));
  return {path, hand_eye_residual(stations.pairs, stations.mount, given.T_A_C),
          difference(given.T_A_C, T_A_C), looks_inverted(stations.pairs, stations.mount, given.T_A_C)};
}

/// Describes what is wrong with the result, and the remedy; empty if nothing is.
std::string fault_of(const HandEyeResult& result, const HandEyeSolution& chosen) {
  if (!result.warning.empty()) return result.warning;
  if (chosen.residual.translation <= kMaxShift && chosen.residual.rotation <= kCalibrationMaxTurn) return {};
  return concat(to_text(chosen.residual), ", more than ", 1000 * kMaxShift, " mm or ",
                kCalibrationMaxTurn / kDegree,
                " deg: arm and target poses do not belong together, or are in other units");
}

nlohmann::json difference_json(double translation, double rotation) {
  return {{"translation_m", translation}, {"rotation_rad", rotation}};
}

nlohmann::json residual_json(const HandEyeResidual& residual) {
  return difference_json(residual.translation, residual.rotation);
}

template <class... Values>
std::string formatted(const char* format, Values... values) {
  char line[160];
  std::snprintf(line, sizeof line, format, values...);
  return line;
}

}  // namespace

HandEyeCalibration calibrate_stations(const HandEyeFile& stations, const HandEyeCalibrationOptions& options) {
  HandEyeCalibration done;
  done.stations = stations;
  done.result = solve(stations);
  const auto& solutions = done.result.solutions;
  const auto chosen = std::find_if(solutions.begin(), solutions.end(),
                                   [&](const HandEyeSolution& s) { return s.method == options.method; });
  require(chosen != solutions.end(), "method ", options.method, " has no result for these pairs");
  done.chosen = *chosen;
  if (!options.check.empty()) done.check = check_file(options.check, stations, done.chosen.T_A_C);
  done.uncertainty = fault_of(done.result, done.chosen);
  if (!done.uncertainty.empty()) done.warnings.push_back(done.uncertainty);
  if (done.check && done.check->inverted)
    done.warnings.push_back(options.check +
                            ": the transformation is inverted: its inverse agrees with the pairs");
  return done;
}

std::string to_text(const HandEyeResidual& residual) {
  return concat("residual ", 1000 * residual.translation, " mm, ", residual.rotation / kDegree, " deg");
}

std::string to_text(const HandEyeCheck& check) {
  return concat(check.path, ": ", to_text(check.residual), "; ", 1000 * check.off.translation, " mm and ",
                check.off.angle / kDegree, " deg from the result");
}

std::string calibration_table(const HandEyeCalibration& calibration, const std::optional<Pose>& true_T_A_C) {
  std::string table = formatted("%-12s %12s %12s   %-26s %s\n", "method", "residual mm", "residual deg",
                                "position (m)", true_T_A_C ? "error mm, deg" : "");
  for (const HandEyeSolution& s : calibration.result.solutions) {
    const Eigen::Vector3d& p = s.T_A_C.translation();
    table += formatted("%-12s %12.3f %12.4f   %8.5f %8.5f %8.5f", s.method.c_str(),
                       1000 * s.residual.translation, s.residual.rotation / kDegree, p.x(), p.y(), p.z());
    if (true_T_A_C) {
      const PoseDifference error = difference(s.T_A_C, *true_T_A_C);
      table += formatted("   %6.3f %7.4f", 1000 * error.translation, error.angle / kDegree);
    }
    table += "\n";
  }
  return table;
}

std::string calibration_json(const HandEyeCalibration& calibration) {
  const HandEyeSolution& chosen = calibration.chosen;
  nlohmann::json solutions = nlohmann::json::array();
  for (const HandEyeSolution& s : calibration.result.solutions)
    solutions.push_back(
        {{"method", s.method}, {"T_A_C", pose_json(s.T_A_C)}, {"residual", residual_json(s.residual)}});
  nlohmann::json out = {
      {"schema", "stonestack.calibrate/1"},         {"camera", to_text(calibration.stations.mount)},
      {"pairs", calibration.stations.pairs.size()}, {"method", chosen.method},
      {"T_A_C", pose_json(chosen.T_A_C)},           {"solutions", solutions},
      {"warning", calibration.result.warning},      {"warnings", calibration.warnings}};
  if (const auto& check = calibration.check)
    out["check"] = {{"residual", residual_json(check->residual)},
                    {"off", difference_json(check->off.translation, check->off.angle)},
                    {"inverted", check->inverted}};
  return out.dump(2) + "\n";
}

void write_calibration(const std::string& path, const HandEyeCalibration& calibration,
                       const std::string& alternative) {
  EasyHandEye out;
  if (!alternative.empty()) {
    out = read_easy_handeye(alternative);
  } else {
    out.parameters = {{"move_group", "manipulator"},
                      {"move_group_namespace", "/"},
                      {"namespace", "/stonestack/"},
                      {"robot_base_frame", "base_link"},
                      {"robot_effector_frame", "tool0"},
                      {"tracking_base_frame", "camera_depth_optical_frame"},
                      {"tracking_marker_frame", "camera_marker"}};
  }
  out.mount = calibration.stations.mount;
  out.T_A_C = calibration.chosen.T_A_C;
  write_easy_handeye(path, out);
}

}  // namespace stonestack::kinematics
