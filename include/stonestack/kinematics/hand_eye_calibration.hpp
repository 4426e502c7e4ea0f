#pragma once
#include <optional>
#include <string>
#include <vector>

#include "stonestack/kinematics/hand_eye.hpp"

#pragma GCC visibility push(default)

/// A calibration from recorded stations to its report.
namespace stonestack::kinematics {

/// Comparison of a calibration that exists with the stations.
struct HandEyeCheck {
  std::string path;  ///< of the easy_handeye file
  HandEyeResidual residual;
  PoseDifference off;     ///< from the new result
  bool inverted = false;  ///< its inverse agrees with the stations
};

/// Calibration from the stations of a file, and what is wrong with it.
struct HandEyeCalibration {
  HandEyeFile stations;
  HandEyeResult result;
  HandEyeSolution chosen;             ///< of the method that was asked for
  std::optional<HandEyeCheck> check;  ///< of the file that was named
  std::string uncertainty;            ///< why `chosen` is no calibration; empty if it is one
  std::vector<std::string> warnings;  ///< about `chosen` and `check`
};

struct HandEyeCalibrationOptions {
  std::string method = "joint";  ///< joint, tsai_lenz, park_martin or daniilidis
  std::string check;             ///< easy_handeye file to compare with the stations; empty: none
};
/// Calibrates by all methods and judges the result of one.
/// @throws FileError if the file of the stations gives no result, or the file to check is of another mount;
/// InvalidArgument if simulated stations give none, or the method has none
[[nodiscard]] HandEyeCalibration calibrate_stations(const HandEyeFile& stations,
                                                    const HandEyeCalibrationOptions& options = {});

/// "residual 0.4 mm, 0.05 deg"
[[nodiscard]] std::string to_text(const HandEyeResidual& residual);
/// "eye.yaml: residual 0.4 mm, 0.05 deg; 0.1 mm and 0.01 deg from the result"
[[nodiscard]] std::string to_text(const HandEyeCheck& check);
/// Table of the methods, a line each; with the errors of simulated stations where their `T_A_C` is known.
[[nodiscard]] std::string calibration_table(const HandEyeCalibration& calibration,
                                            const std::optional<Pose>& true_T_A_C = {});
/// JSON text of schema stonestack.calibrate/1.
[[nodiscard]] std::string calibration_json(const HandEyeCalibration& calibration);
/// Writes the chosen result as an easy_handeye file, with the frame names and other parameters of the file
/// `alternative`, or with those of a UR arm where that is empty.
/// @throws FileError
void write_calibration(const std::string& path, const HandEyeCalibration& calibration,
                       const std::string& alternative = "");

}  // namespace stonestack::kinematics

#pragma GCC visibility pop
