#pragma once
#include <optional>
#include <span>
#include <vector>

#include "motion/regrasp.hpp"

namespace stonestack::motion {

/// A way to let go of a stone so that it comes to lie on another side.
struct TurnTo {
  Eigen::Quaterniond R_W_O = Eigen::Quaterniond::Identity();       ///< in which it is let go of
  Eigen::Quaterniond R_W_O_rest = Eigen::Quaterniond::Identity();  ///< in which it comes to lie
  /// Room that it needs to all sides [m]: what falls over needs more than what stays as it is set down.
  double apart = 0.01;
  bool certain = true;  ///< false: it is so near to its balance that it may fall back
};

/// How a stone comes to lie that is let go of on a table: it tips over, without momentum, until its centre of
/// mass is above its support. Within 2 deg.
[[nodiscard]] Eigen::Quaterniond tipped_over(const Stone& stone, Eigen::Quaterniond R_W_O);

/// Ways to turn a stone over that lies with R_W_O: set down on each other side on which it stays, and on an
/// edge beyond which it falls over, turned as little as that takes. A flat stone that cannot be turned far
/// beyond its edge is turned less far, and may fall back.
[[nodiscard]] std::vector<TurnTo> ways_to_turn(const Stone& stone, const Eigen::Quaterniond& R_W_O);

/// A plan that turns a stone over.
struct TurnPlan {
  PickAndPlacePlan plan;
  TurnTo way;                     ///< that of those that were asked for
  Pose T_W_O = Pose::Identity();  ///< where it should come to lie
  double height = 0.0;            ///< above the table, at which it is let go of [m]
};

/// Plans the first of some ways to turn a loose stone over for which a grasp serves both ends, at the free
/// place nearest to where it lies. A tilted gripper may meet the table before the stone does; where none
/// serves otherwise, the stone is let go of 10 mm above the table, or 20 mm. The task's target is not used.
/// Empty where no grasp does.
[[nodiscard]] std::optional<TurnPlan> plan_turn(const PlanningScene& scene, const PickAndPlaceTask& task,
                                                std::span<const TurnTo> ways,
                                                const MotionOptions& options = {});

}  // namespace stonestack::motion
