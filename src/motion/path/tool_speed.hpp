#pragma once
#include "motion/path/smooth_path.hpp"
#include "motion/timing.hpp"

/// Private to motion.
namespace stonestack::motion {

/// How fast the tool may be: T_F_T on the flange of `robot`, `speed` (m/s) where the joints are at q.
struct ToolLimit {
  const RobotModel& robot;
  Pose T_F_T;
  ToolSpeed speed;
};

inline constexpr double kToolLine =
    0.05;  ///< on such a piece of a line the tool's speed hardly changes [rad]

/// Fastest path speed ds/dt (rad/s) on the piece that keeps the limit; from points on the piece, with a share
/// to spare for those between. Infinity where the tool does not move.
[[nodiscard]] double fastest_with_tool(const PathPiece& piece, const ToolLimit& limit);

/// Speed limits of transits: options.near_speed where the tool is nearer than options.near_distance to an
/// object but `left_out`, options.tool_speed elsewhere. Distances are to the objects' bounding boxes. `reach`
/// (m): how far what the hand holds goes out from the tool's tip.
[[nodiscard]] ToolSpeed transit_speed(const PlanningScene& scene, const MotionOptions& options,
                                      int left_out = -1, double reach = 0.0);

}  // namespace stonestack::motion
