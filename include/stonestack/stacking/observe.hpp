#pragma once
#include <optional>
#include <string>
#include <vector>

#include "stonestack/core/options.hpp"
#include "stonestack/detection/detect_stones.hpp"
#include "stonestack/hardware/cell.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/motion/pick_and_place.hpp"
#include "stonestack/physics/stack.hpp"
#include "stonestack/stacking/world_estimate.hpp"
#include "stonestack/stone/catalogue.hpp"

#pragma GCC visibility push(default)

namespace stonestack::stacking {

/// T_W_C from what the arm reports: the chain of eq. (1), T_W_R * T_R_F * T_F_T * T_T_C.
[[nodiscard]] Pose camera_pose(const CellLayout& layout, const RobotModel& robot, const Joints& q);

/// Which of the stones stand at the site, from the table up, and which lie loose, by geometry alone: the
/// lowest stone within 12 cm of the site is the base; each next one is clear of the table with its centre of
/// mass over the one below.
[[nodiscard]] Arrangement sort_by_site(const ShapeList& shapes, const Eigen::Vector2d& site,
                                       const std::vector<PlacedStone>& stones);

/// The gripper of a cell, with the linkage, the masses and the camera's mount that its layout
/// names.
/// @throws InvalidArgument for another linkage than parallel and three_finger.
[[nodiscard]] GripperModel gripper_of(const CellLayout& layout);
/// Describes the option `hand` of the group `gripper`: the gripper where no cell file names one.
[[nodiscard]] Field gripper_field(std::string& name);
/// The layout with the gripper of that option; the file of a cell names its own. Throws InvalidArgument for
/// both, FileError as `with_gripper`.
[[nodiscard]] CellLayout with_option_gripper(CellLayout layout, const std::string& name, bool from_cell_file);

/// The scene that motions must avoid: every stone, by name, indexed like `stack` then `loose`,
/// then the obstacles of the layout.
[[nodiscard]] PlanningScene make_planning_scene(const CellLayout& layout, const RobotModel& robot,
                                                const Catalogue& catalogue, const Arrangement& arrangement);

/// The motion task that brings loose stone `stone` from where it is seen to lie to T_W_O.
/// @throws InvalidArgument when it is not among the loose stones.
[[nodiscard]] PickAndPlaceTask make_task(const Catalogue& catalogue, const Arrangement& arrangement,
                                         StoneIndex stone, const Pose& T_W_O, const Joints& q_start);

/// Where the arm waits and starts: folded above the middle of the cell, tool down, view free.
[[nodiscard]] Joints home_joints();

/// Camera at `p_W_eye` that looks at `p_W_target`, image "up" away from the ground, turned by `roll` (rad)
/// about the optical axis.
[[nodiscard]] Pose camera_looking_at(const Eigen::Vector3d& p_W_eye, const Eigen::Vector3d& p_W_target,
                                     double roll);

/// Camera poses that show `p_W_target` from `distance`, best first: high and from the robot's side before
/// low and from aside, each with four turns about the optical axis.
[[nodiscard]] std::vector<Pose> view_poses(const CellLayout& layout, const Eigen::Vector3d& p_W_target,
                                           double distance);

/// A motion to the first of `T_W_C_candidates` that the arm reaches without touching anything; nothing if it
/// reaches none.
[[nodiscard]] std::optional<JointTrajectory> plan_route_to_view(Cell& cell, const PlanningScene& scene,
                                                                const std::vector<Pose>& T_W_C_candidates,
                                                                const MotionOptions& options);
/// Follows it and takes a frame at its end.
/// @throws DeviceError when the arm does not get there.
[[nodiscard]] CameraView take_view(Cell& cell, const RobotModel& robot, const JointTrajectory& route);

/// A stone seen in one of several views, in the world.
struct Sighting {
  StoneIndex stone = kNoStone;    ///< index into the catalogue
  Pose T_W_O = Pose::Identity();  ///< pose that was measured
  double score = 0.0;             ///< score of the detection
  double visible = 0.0;           ///< share of the stone's surface that was seen
  double certainty = 1.0;         ///< of this stone in this pose: Detection::certainty
  PoseSigma sigma = {};           ///< standard deviations of the pose
};

/// Knowledge of the stones of a scene before it is viewed.
struct KnownScene {
  Arrangement before;             ///< where stones were seen last
  std::vector<StoneIndex> known;  ///< stones that are somewhere in the scene
  bool first = false;             ///< any stone may be there
};

/// Finds `wanted` stones in every view and keeps, for each, the sighting with the best score. Those that no
/// view shows are searched in all views at once, as one may show what another hides, if they are known, or in
/// a first observation. A stone that is not known counts only if all views at once show it: one view may see
/// little of a thing that is no stone. Stones that were seen before are looked for where they were first;
/// what is found there is not searched elsewhere, nor are stones of the stack that are hidden below one that
/// is found in its place.
[[nodiscard]] std::vector<Sighting> find_in_views(const std::vector<CameraView>& views,
                                                  const DetectionModels& models,
                                                  const std::vector<StoneIndex>& wanted,
                                                  const KnownScene& scene, const DetectionOptions& options);

}  // namespace stonestack::stacking

#pragma GCC visibility pop
