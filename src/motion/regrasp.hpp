#pragma once
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "stonestack/motion/pick_and_place.hpp"

namespace stonestack::motion {

/// Options of the reorientation of a stone. Values without a source are design choices.
struct RegraspOptions {
  double rest_margin = 0.004;  ///< centre of mass inside the support polygon of a resting pose, least [m]
  double rest_tilt = 0.17;     ///< by which a resting pose may be turned before it topples, least [rad]
  double min_margin = 0.002;   ///< the same where no chain leads over firmer resting poses [m]
  double min_tilt = 0.07;      ///< the same [rad]; in poses below it every stone fell
  double flat = 0.0015;        ///< scan points that near the table carry the stone [m]
  int turns = 8;               ///< about the vertical, each resting pose
  double around = 0.30;        ///< from where it lies to the farthest place to set it down, along x and y [m]
  double spacing = 0.06;       ///< between these places [m]
  double apart = 0.01;         ///< between the stone where it is set down and everything else [m]
  int max_set_downs = 2;       ///< number of intermediate set-downs
  int attempts = 8;            ///< times that plans are made, most
  /// Directions of the stone, frame O, that were up in resting poses which did not hold: these are left out.
  std::vector<Eigen::Vector3d> n_O_not_up = {};
};
[[nodiscard]] FieldList fields(RegraspOptions& options);

/// A resting pose of a stone on a level table.
struct RestPose {
  Eigen::Quaterniond R_W_O = Eigen::Quaterniond::Identity();
  double margin = 0.0;  ///< centre of mass inside the support polygon [m]
  double tilt = 0.0;    ///< turned by more than that about the nearest edge of its support it topples [rad]
};
/// All of a stone, by its convex hull; the one with the largest margin first. Throws InvalidArgument for a
/// stone without scan or mass.
[[nodiscard]] std::vector<RestPose> rest_poses(const Stone& stone, const RegraspOptions& options = {});

/// Answers for one loose stone whether it could be brought to a target by setting it down on the table in
/// between: grasps of the gripper, over the resting poses that lead there, which the arm can release at the
/// target. Only `plan_regrasp` decides whether there is free space on the table, and a path. What does not
/// depend on the target is worked out once. Const methods may be called from several threads.
class RegraspFinder {
 public:
  /// As GraspFinder; `avoid`: grasps T_O_T that must not pick it up where it lies now.
  RegraspFinder(const PlanningScene& scene, const Stone& stone, int object, const Pose& T_W_O_pick,
                std::span<const Pose> avoid = {}, const MotionOptions& options = {},
                const RegraspOptions& regrasp = {});
  ~RegraspFinder();
  RegraspFinder(RegraspFinder&&) noexcept;
  RegraspFinder& operator=(RegraspFinder&&) noexcept;

  /// `meanwhile`: as in GraspFinder::check.
  [[nodiscard]] bool serves(const Pose& T_W_O_place, std::span<const SceneObject> meanwhile = {}) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// Plans that follow each other; or why there are none.
struct RegraspPlan {
  bool planned = false;
  std::string reason;
  std::vector<Pose> T_W_O_between;      ///< where the stone is set down on the table, in order
  std::vector<double> tilts;            ///< RestPose [rad]::tilt of these poses
  std::vector<PickAndPlacePlan> plans;  ///< one more than `T_W_O_between`; each starts where the arm was left
};

/// For a stone that no grasp brings to its target in one go: sets it down on the table in another pose of
/// rest and grasps it anew, as seldom as possible. Which grasps the gripper can take in which resting pose
/// makes a graph (Tournassoud, Lozano-Perez and Mazer 1987); its shortest chains are tried first, at free
/// places near where the stone lies. Deterministic. Between plans the caller looks where the stone really
/// came to lie: a later plan holds for a stone that lies exactly at its `T_W_O_between`. Throws
/// InvalidArgument as `plan_pick_and_place`.
[[nodiscard]] RegraspPlan plan_regrasp(const PlanningScene& scene, const PickAndPlaceTask& task,
                                       const MotionOptions& options = {}, const RegraspOptions& regrasp = {});

}  // namespace stonestack::motion
