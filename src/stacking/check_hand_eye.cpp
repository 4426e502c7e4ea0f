#include "stacking/check_hand_eye.hpp"

#include <cmath>
#include <numbers>

#include "kinematics/mount_reading.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/detection/detect_stones.hpp"
#include "stonestack/hardware/cell_file.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::stacking {
namespace {

double degrees(double angle) {
  return angle * 180.0 / std::numbers::pi;
}

double rounded(double value, double unit) {
  return std::round(value / unit) * unit;
}

/// The hand-eye calibration as the cell file has it.
struct GivenMount {
  std::string name;  ///< "layout.T_T_C"
  MountReading meant = MountReading::kTip;
  Pose numbers = Pose::Identity();
  CellLayout layout;

  explicit GivenMount(const CellConfig& cell) : layout(to_layout(cell)) {
    name = cell.T_F_C ? "layout.hand_eye (" + cell.hand_eye + ")" : "layout.T_T_C";
    meant = cell.T_F_C ? MountReading::kFlange : MountReading::kTip;
    numbers = cell.T_F_C ? *cell.T_F_C : layout.T_T_C;
  }
};

const std::string kHandEye = "hand-eye calibration";
const std::string kCalibrate = "calibrate: `stonestack calibrate --capture CELL --execute --write CELL`";

/// "camera 0.17 m behind the finger tips, 0.11 m aside"
std::string place_of(const Pose& T_T_C) {
  const Eigen::Vector3d p = T_T_C.translation();
  return concat("camera ", rounded(std::abs(p.z()), 0.001), " m ", p.z() > 0 ? "in front of" : "behind",
                " the finger tips, ", rounded(std::hypot(p.x(), p.y()), 0.001), " m aside");
}

std::string in_words(const TableOffset& table) {
  return concat(rounded(std::abs(1000 * table.height), 1), " mm ", table.height < 0 ? "below" : "above",
                " z = 0 and tilted by ", rounded(degrees(table.tilt), 0.1), " deg");
}

/// The line for the cell file.
std::string write_instead(const Pose& T_T_C) {
  return concat("if that is right, write `T_T_C: ", mount_text(T_T_C), "` in its place");
}

/// By the numbers alone: nothing here is known to be right, but much is known to be wrong.
Found judge_numbers(const GivenMount& given, const std::string& why_no_view) {
  const Pose& T_T_C = given.layout.T_T_C;
  if (is_possible_mount(T_T_C))
    return {concat(place_of(T_T_C), "; not compared with the table: ", why_no_view), true};
  std::string candidates;
  for (const MountReading reading : kMountReadings)
    if (reading != given.meant && is_possible_mount(mount_of(reading, given.numbers, given.layout.T_F_T)))
      candidates += (candidates.empty() ? "they may be " : ", or ") + to_text(reading);
  throw DeviceError(
      kHandEye,
      concat(given.name, " as ", to_text(given.meant), ": ", place_of(T_T_C),
             T_T_C.linear()(2, 2) > 0 ? "" : ", facing the arm"),
      candidates.empty() ? "nor is it the inverse or another frame; " + kCalibrate : candidates);
}

/// The table that the camera sees, at the place where the mount puts it.
Found judge_view(const GivenMount& given, const Pose& T_W_T, const Plane& table_C) {
  const MountCheck check = check_mount(given.numbers, given.meant, given.layout.T_F_T, T_W_T, table_C);
  const std::string seen =
      concat(place_of(check.meant.T_T_C), "; the table is seen ", in_words(check.meant.table));
  const std::string as_given = concat(given.name, " as ", to_text(given.meant), ": ", seen);
  switch (check.verdict) {
    case MountCheck::Verdict::kOther:
      throw DeviceError(kHandEye,
                        concat(as_given, "; the numbers look like ", to_text(check.others.front().reading),
                               ": with that it is ", in_words(check.others.front().table)),
                        write_instead(check.others.front().T_T_C));
    case MountCheck::Verdict::kNone:
      throw DeviceError(kHandEye, concat(as_given, ", and no other reading of the numbers explains it"),
                        "see that the table is in view and layout.T_W_R is right, or " + kCalibrate);
    case MountCheck::Verdict::kAmbiguous:
      return {
          concat(seen, ", but would be so, too, if the numbers were ", to_text(check.others.front().reading),
                 ": tilt the gripper by 20 deg, the table in view, and ask again"),
          true};
    case MountCheck::Verdict::kRough:
      return {concat(seen, "; ", kCalibrate), true};
    case MountCheck::Verdict::kFits:
      break;
  }
  if (!is_possible_mount(check.meant.T_T_C))
    return {concat(seen, "; if the camera is not mounted so, ", kCalibrate), true};
  return {concat(seen, " (one view does not show the camera's place along the table)")};
}

/// Reason why the view cannot be compared; empty if it can.
std::string obstacle_to_view(const CellConfig& cell, const CellView& view) {
  if (!view.q) return "the arm has not said where it is";
  if (cell.camera == "recorded") return "a recording is not from where the arm is now";
  if (!view.image) return "there is no depth image";
  return "";
}

}  // namespace

Found check_hand_eye(const CellConfig& cell, const CellView& view) {
  const GivenMount given(cell);
  if (const std::string why = obstacle_to_view(cell, view); !why.empty()) return judge_numbers(given, why);
  const auto table_C = find_table(*view.image);
  if (!table_C) return judge_numbers(given, "the camera sees none; move the gripper over it and ask again");
  const Pose T_W_T = given.layout.T_W_R * forward(read_cell_robot(cell), *view.q) * given.layout.T_F_T;
  return judge_view(given, T_W_T, *table_C);
}

}  // namespace stonestack::stacking
