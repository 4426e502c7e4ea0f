#pragma once
#include <string>
#include <vector>

#include "stonestack/motion/pick_and_place.hpp"

namespace stonestack {

/// How a stone is turned over. Numbers without a source are ours.
struct RegraspOptions {
  double rest_margin = 0.006;  ///< m, centre of mass inside the support polygon of a pose of rest, least
  double flat = 0.0015;        ///< m, scan points that near the table carry the stone
  int turns = 8;               ///< about the vertical, each pose of rest
  double beside = 0.10;        ///< m, from where it lies to the other places that are tried
  double apart = 0.01;         ///< m, between the stone where it is set down and everything else
  int attempts = 6;            ///< pairs of plans made, most
};
[[nodiscard]] FieldList fields(RegraspOptions& options);

/// Orientations R_W_O in which the stone can stand on a level table, by its convex hull; the one with the
/// largest margin first. Throws InvalidArgument for a stone without scan or mass.
[[nodiscard]] std::vector<Eigen::Quaterniond> rest_orientations(const Stone& stone,
                                                                const RegraspOptions& options = {});

/// Two plans, one after the other; or why there are none.
struct RegraspPlan {
  bool planned = false;
  std::string reason;
  Pose T_W_O_between = Pose::Identity();  ///< where the stone is set down on the table
  PickAndPlacePlan first;                 ///< from where it lies to T_W_O_between
  PickAndPlacePlan second;                ///< from there to the target, the arm starting where `first` ends
};

/// For a stone that no grasp brings to its target in one go: sets it down in another pose of rest near where
/// it lies and grasps it anew. Deterministic. Between the two plans the caller looks where the stone really
/// came to lie; `second` holds for a stone that lies exactly at T_W_O_between. Throws InvalidArgument as
/// `plan_pick_and_place`.
[[nodiscard]] RegraspPlan plan_regrasp(const PlanningScene& scene, const PickAndPlaceTask& task,
                                       const MotionOptions& options = {}, const RegraspOptions& regrasp = {});

}  // namespace stonestack
