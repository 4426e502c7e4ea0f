#pragma once
#include <optional>
#include <string>
#include <vector>

#include "stonestack/geometry/mesh.hpp"
#include "stonestack/kinematics/robot_model.hpp"

/// Private to report/: the record of a run, read back from its folder.
namespace stonestack::report {

/// Pose of a stone at a time.
struct Keyframe {
  double time = 0.0;  ///< from the first sample [s]
  Pose T_W_O = Pose::Identity();
};
/// A stone that was seen in the run.
struct RecordedStone {
  std::string name;
  Mesh mesh;                     ///< at most 500 faces, in O
  std::vector<Keyframe> motion;  ///< rising in time; poses as measured, in the gripper as grasped
  int level = 0;                 ///< of the tower at the end, from 1; 0: loose
};
/// Arm and gripper at a time.
struct RecordedSample {
  double time = 0.0;  ///< from the first sample [s]
  Joints q = Joints::Zero();
  double opening = 0.0;  ///< between the finger pads [m]
  double force = 0.0;    ///< at the wrist [N]
  bool holds = false;    ///< the fingers were stopped by an object
};
/// A stone that was handled.
struct RecordedPlacement {
  std::string stone, outcome;
  int level = 0;  ///< that it was meant for, from 1; 0: for none
  double cost = 0.0, predicted_success = 0.0;
  Pose T_W_O_planned = Pose::Identity();
  std::optional<Pose> T_W_O_measured;
};
/// The gripper's motion with one stone, from grasp to release.
struct RecordedCarry {
  int stone = -1;  ///< index into the stones
  double begin = 0.0, end = 0.0;
  Pose T_T_O = Pose::Identity();
};
/// A line of the log.
struct RecordedEvent {
  double time = 0.0;
  std::string text;
};
/// Everything that exports need.
struct RunRecord {
  std::string folder, robot, ended;
  int seed = 0;
  int height = 0;
  std::vector<RecordedStone> stones;
  std::vector<std::size_t> last_view;  ///< indices: the tower from the table up, then loose stones
  std::vector<RecordedPlacement> placements;
  std::vector<RecordedSample> samples;
  std::vector<RecordedCarry> carries;
  std::vector<RecordedEvent> events;
  Pose T_W_R = Pose::Identity();
};

/// Reads result.json and the data of report.html, in which a run over time is kept.
/// @throws FileError for a run that did not end, and for files that do not hold what they should.
[[nodiscard]] RunRecord read_run_record(const std::string& folder);

/// Indices of the tower's stones, from the table up.
[[nodiscard]] std::vector<std::size_t> tower_of(const RunRecord& record);

}  // namespace stonestack::report
