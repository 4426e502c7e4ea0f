#pragma once
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "stonestack/search/find_next_pose.hpp"

#pragma GCC visibility push(default)

namespace stonestack::stacking {

/// How a stone is brought to its place: in one go, or set down in another resting pose before.
enum class Route { kDirect, kReorienting };

/// How a run ended.
enum class RunEnd {
  kAllPlaced,
  kHeightReached,
  kNoPose,
  kNoPlan,
  kPlacementFailed,
  kNothingSeen,
  kStopped,
  kInterrupted,
  kFailed,  ///< by an error that no caller expects
  kPlanned  ///< a dry run: the first step was planned, nothing moved
};
/// "all_placed", "height_reached", "no_feasible_pose", "no_plan", "placement_failed", "nothing_seen",
/// "stopped", "interrupted", "failed", "planned".
[[nodiscard]] std::string to_text(RunEnd end);

/// Put a stone on the stack: the first of these that a motion is found for.
struct Place {
  std::vector<Placement> candidates;  ///< best first
};
/// Set a stone down in another resting pose, from which it can be brought to its placement: the first of
/// these that a motion is found for.
struct Reorient {
  std::vector<Placement> candidates;  ///< placements that may be carried out, best first
};
/// Put the top stone back into the field.
struct Unstack {
  PlacedStone top;               ///< top stone of the stack
  std::vector<Pose> T_W_O_down;  ///< free places, best first
};
/// Put a stone that leans on the stack back into the field.
struct ClearBase {
  PlacedStone stray;             ///< loose stone that leans on the stack or lies at its base
  std::size_t level = 0;         ///< of the stack, that it touches
  std::vector<Pose> T_W_O_down;  ///< poses where it may be set down, best first
};
/// Push a loose stone over the table with the closed gripper, away from what keeps the fingers off it.
struct Push {
  PlacedStone stone;                        ///< as it lies
  std::vector<Eigen::Vector2d> p_W_shifts;  ///< how far it may be pushed and where to, best first [m]
};
/// Search for a stone that is out of sight.
struct LookAgain {
  /// Place that is looked at.
  enum class Where { kWhereItWas, kBesideSite };
  StoneIndex stone = kNoStone;       ///< stone that is missing; kNoStone for a place beside the site
  Where where = Where::kWhereItWas;  ///< place that is looked at
  Eigen::Vector3d p_W_target = Eigen::Vector3d::Zero();  ///< point that the camera turns to [m]
};
/// Model what lies in the cell and is recognised as none of the stones, as other stones: those that are out
/// of sight may be among it, and show a side that no model has.
struct ModelAnew {
  std::vector<StoneIndex> lost;  ///< stones that are out of sight
  bool in_sight = false;         ///< they are seen, but by their models they cannot rest as they do
};
/// End the run.
struct Stop {
  RunEnd end = RunEnd::kAllPlaced;  ///< reason as a value
  std::string reason;               ///< reason for a person
};

/// The next thing that the robot does.
using Action = std::variant<Place, Reorient, Unstack, ClearBase, Push, LookAgain, ModelAnew, Stop>;
/// "place", "reorient", "unstack", "clear_base", "push", "look_again", "model_anew", "stop".
[[nodiscard]] std::string name_of(const Action& action);

/// One attempted placement, or a stone that was set down in the field.
struct PlacementRecord {
  /// Outcome of a stone that was handled.
  enum class Outcome {
    kPlaced,
    kMoved,
    kFallen,
    kNotPicked,
    kDropped,
    kLost,
    kUnstacked,
    kReoriented,
    kPushed
  };
  std::string stone;                   ///< name of the stone
  Placement planned;                   ///< placement as it was planned
  std::optional<Pose> T_W_O_measured;  ///< where it was seen afterwards
  Outcome outcome = Outcome::kPlaced;  ///< outcome by the observation after it
  std::string note;                    ///< remark for a person
  /// Place that it was meant for in the order of the structure, from 1, the first on the table; 0: for none
  /// (unstacked, reoriented, pushed)
  int level = 0;
  int course = 0;                                     ///< of a wall, from 1 on the table; 0: of none
  std::optional<Pose> T_W_O_at_rest = std::nullopt;   ///< where it rests by physics, near `T_W_O_measured`
  Eigen::Vector3d p_W_aim = Eigen::Vector3d::Zero();  ///< shift of the aim against the bias, m
};
/// "placed", "moved", "fallen", "not picked", "dropped" (out of the gripper, on the route), "lost" (released,
/// not seen afterwards), "unstacked", "reoriented", "pushed".
[[nodiscard]] std::string to_text(PlacementRecord::Outcome outcome);

}  // namespace stonestack::stacking

#pragma GCC visibility pop
