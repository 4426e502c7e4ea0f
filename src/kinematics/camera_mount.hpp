#pragma once
#include <optional>
#include <span>
#include <vector>

#include "stonestack/geometry/pose.hpp"

namespace stonestack::kinematics {

/// A thing that stands still, seen in one view: the same `mark` in another view is the same thing.
struct SeenMark {
  int mark = 0;
  Eigen::Vector3d p_C = Eigen::Vector3d::Zero();
};

/// Observation of the camera on the gripper from one arm pose.
struct MountView {
  Pose T_W_T = Pose::Identity();  ///< tool, as the arm reports it
  std::optional<Plane> table_C;   ///< the table, which lies near z = 0 in W
  std::vector<SeenMark> marks;
};

/// The mount and the table that the views agree on.
struct MountRefinement {
  Pose T_T_C = Pose::Identity();
  Plane table_W;                     ///< z = 0 where no view shows it
  double shift = 0.0, turn = 0.0;    ///< against the mount that was given: m, rad
  double before = 0.0, after = 0.0;  ///< root mean square distance of marks between views [m]
  int shared_marks = 0;              ///< marks that more than one view saw
};

/// Where the camera really sits on the gripper, from views of things that stand still: a mark must come to
/// the same place, and the table to the same plane, from every view. The given T_T_C counts as a measurement,
/// too, and so does the table's nominal plane z = 0, so unobservable directions stay as they were. Two views
/// that differ by half a turn about the optical axis tell a tilted camera, whose tilt turns with it, from a
/// tilted table; they fix all but the turn about that axis, and the height, which camera and table share by
/// how uncertain each is. Weighted least squares over mount, table and marks.
/// Throws InvalidArgument without a view.
[[nodiscard]] MountRefinement refine_camera_mount(std::span<const MountView> views, const Pose& T_T_C);

}  // namespace stonestack::kinematics
