#pragma once
#include <cstddef>
#include <map>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "stonestack/experiment/experiment.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/stone/catalogue.hpp"

/// Private to report/: the data of a run's page.
namespace stonestack::report {

/// [x, y, z] of a page, to 0.01 mm.
[[nodiscard]] nlohmann::json numbers(const Eigen::Vector3d& v);
/// [x, y, z, qx, qy, qz, qw] of a page, likewise.
[[nodiscard]] nlohmann::json numbers(const Pose& pose);
/// Arm and gripper as makeArm of src/report/page/scene.js draws them.
[[nodiscard]] nlohmann::json robot_entry(const RobotModel& robot, const CellLayout& layout);
/// Data of a page as one line; bytes that are no UTF-8 are replaced.
[[nodiscard]] std::string one_line(const nlohmann::json& page);

/// Data that the page's scripts draw (src/report/page): one JSON object. Poses are [x, y, z, qx, qy, qz, qw]
/// in W, lengths in metres, times in seconds from the first sample; stones are indices into `stones`.
/// `picture`: a data URI, or empty.
[[nodiscard]] std::string page_data(const RunReport& report, const Catalogue& catalogue,
                                    const RobotModel& robot, const std::string& picture);

/// Position up to which a page shows a run.
struct PagePosition {
  std::size_t samples = 0;                    ///< number of samples of the timeline
  std::size_t events = 0;                     ///< number of events
  std::size_t stones = 0;                     ///< number of stones of the catalogue
  std::vector<std::string> why;               ///< log lines since the last decision
  std::vector<StoneIndex> planned;            ///< stone that was chosen last, then those planned to follow it
  std::map<std::string, std::string> values;  ///< by name, what the page shows
};
/// Changes since `from`, which moves on: the lists `samples`, `views`, `towers`, `decisions` and
/// `events` are to be appended, other values replace those of the page. All changes of a run in order, and
/// what never changes, make `page_data`.
[[nodiscard]] std::string page_changes(const RunReport& report, const Catalogue& catalogue,
                                       const RobotModel& robot, PagePosition& from);

/// The page around `data`; `text` stands there for a browser without scripts.
[[nodiscard]] std::string page_html(const std::string& title, const std::string& text,
                                    const std::string& data);
/// The picture of the run as a data URI; empty: none.
/// @throws FileError
[[nodiscard]] std::string picture_uri(const RunReport& report);

}  // namespace stonestack::report
