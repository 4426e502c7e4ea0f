#pragma once
#include <string>

#include "stonestack/experiment/experiment.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/stone/catalogue.hpp"

/// Private to report/: the data of a run's page.
namespace stonestack::report {

/// Data that the page's scripts draw (src/report/page): one JSON object. Poses are [x, y, z, qx, qy, qz, qw]
/// in W, lengths in metres, times in seconds from the first sample; stones are indices into `stones`.
/// `picture`: a data URI, or empty.
[[nodiscard]] std::string page_data(const RunReport& report, const Catalogue& catalogue,
                                    const RobotModel& robot, const std::string& picture);

}  // namespace stonestack::report
