#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "stonestack/search/find_next_pose.hpp"

#pragma GCC visibility push(default)

namespace stonestack::search {

/// A block that stands on the table before anything is built, of the density of stone (2600 kg/m^3).
struct TargetSupport {
  double from = 0.0;    ///< x where it begins [m]
  double to = 0.0;      ///< x where it ends [m]
  double height = 0.1;  ///< of its top over the table [m]
  double depth = 0.2;   ///< [m] across, half to either side of y = 0
};

/// A stretch of the x axis that stones are to lie over, without a gap, while nothing stands in it.
struct Span {
  double from = 0.0;    ///< x where it begins [m]
  double to = 0.0;      ///< x where it ends [m]
  double clear = 0.03;  ///< [m] over the table, below which there is no stone between the ends
};

/// Duty of a structure that is no wall: span, reach out, carry. Frame: x along, y across, z up, origin
/// on the table in the middle of the target.
struct SpanTask {
  std::vector<TargetSupport> supports;  ///< what may be built on, beside the table
  std::vector<Span> spans;              ///< at least one
  bool on_table = true;                 ///< stones may stand on the table, too
  /// A stone that has to lie on the others in the end, its centre of mass within 30 mm of this x [m]; empty:
  /// none.
  std::optional<double> carry;
};

/// A dry-stone wall: straight, in courses, its axis through its centre; or a task instead.
struct WallTarget {
  std::vector<int>
      courses;          ///< stones of each course, from the table up; empty: as `length` and `levels` say
  double length = 0.0;  ///< [m] length of the lowest course, where `courses` is empty
  int levels = 0;       ///< number of courses, where `courses` is empty
  std::optional<Eigen::Vector2d> centre_W;  ///< middle of the wall on the table, W [m]; empty: the site
  double yaw = 0.0;                         ///< angle of the wall's axis from the x axis of W, about z [rad]
  double joint_gap = 0.004;                 ///< [m] between neighbours of a course, at least
  std::optional<SpanTask> task;             ///< then there are no courses and no length
};

/// "4+3+2+1": stones of each course; "0.8x3": a wall of 0.8 m in three courses; "bridge:0.08": stones over a
/// gap of 80 mm in which nothing stands; or the path of a target file, YAML, schema "stonestack.target/1":
///
///   schema: stonestack.target/1
///   wall: {courses: [4, 3, 2, 1]}      # or {length: 0.8, levels: 3}, metres
///   centre: {x: 0.7, y: 0.28}          # middle of the wall on the table, W, metres; may be missing
///   yaw_deg: 0                         # of the wall's axis from x; may be missing
///   joint_gap: 0.004                   # between neighbours of a course, metres; may be missing
///
/// or, instead of a wall, all lengths in metres along the axis from the centre:
///
///   spans: [{from: -0.06, to: 0.06, clear: 0.1}]     # nothing stands in them below `clear`
///   supports: [{from: -0.26, to: -0.06, height: 0.1, depth: 0.2}]   # blocks that are there; may be missing
///   on_table: false                                  # stones may stand on the table; true if it is missing
///   carry: 0                                         # where a stone has to lie on top; may be missing
/// @throws InvalidArgument; FileError for a file that cannot be read or asks for what is impossible.
[[nodiscard]] WallTarget read_wall_target(const std::string& text);

/// A stone of a wall.
struct WallPlacement {
  Placement placement;  ///< stone, pose, and what was predicted
  int course = 0;  ///< from 0, the one on the table; of a task one more than the highest that it rests on
  /// Stones that it rests on, counted in the order in which they are built, those that stand already first;
  /// empty: the table, or a support of the target.
  std::vector<int> supports;
  /// Other stones and poses for the same place, best first, at most five. For a stone of an earlier plan:
  /// those that the plan names.
  std::vector<Alternative> alternatives = {};
};

/// A wall that stands in part: the stack of the search problem.
struct WallBegun {
  Pose T_W_V = Pose::Identity();  ///< frame of the wall: x along it, y across, z = 0 the table
  std::vector<int> courses;       ///< course of each stone of the stack, from 0
  /// Stones as an earlier plan meant to go on with, in order: tried first, as long as they hold.
  std::vector<WallPlacement> rest;
  bool rest_only = false;  ///< no other stones are searched for
};

/// Figures of a wall, as planned or as built.
struct WallMetrics {
  int placed = 0;       ///< stones that stand
  int asked = 0;        ///< stones that were asked for; 0: as many as the length takes
  double length = 0.0;  ///< [m] of the lowest course
  double height = 0.0;  ///< [m] mean height of the tops of the highest course
  double width = 0.0;   ///< [m] mean extent of the stones across the wall
  /// Share of the volume length x width x height of each course that is stone; courses count with their own
  /// length.
  double fill = 0.0;
  double face =
      0.0;         ///< share of the wall's face (seen across it, each course with its length) that is stone
  int joints = 0;  ///< joints between neighbours of a course with a course above them
  int open_joints = 0;  ///< of these, joints that run on through the course above: another joint within 15 mm
  double flatness = 0.0;  ///< [m] root mean square of the tops of a course about their mean, over all courses
  double margin = 0.0;    ///< [g] horizontal acceleration borne by the whole in the weakest of 16 directions
  double spanned = 0.0;   ///< [m] of the spans of a task that stones lie over
  double to_span = 0.0;   ///< [m] length of these spans; 0: a wall
};

/// A wall on paper.
struct WallPlan {
  std::vector<WallPlacement> placements;  ///< what is yet to be built, in order
  WallMetrics metrics;                    ///< of the whole, with the stones that stand already
  Pose T_W_V = Pose::Identity();          ///< frame of the wall, as in `WallBegun`
  std::string reason;                     ///< what stood in the way of more; empty: nothing
  long candidates = 0;                    ///< poses evaluated
  int unreachable = 0;                    ///< proposals that the arm could not bring about
  double seconds = 0.0;                   ///< duration [s]
};

/// Plans a wall, stone by stone from the table up: each stone rests on what stands, clear
/// of its neighbours, where it covers the joint below; it is let down in simulation, and what stands is
/// judged with each stone dynamic. Depth-first with backtracking where the number of stones is given, and in
/// passes that begin anew with what was left over. The plan with most stones is returned, for a length the
/// one whose courses are longest. A task is planned by a beam search over stones that reach further out, or
/// weigh down what reaches out, until the spans are closed. Where `reachable` is given, it is asked for every
/// stone among those that stand before it, and the wall's middle is where stones of the usual length put it,
/// to some centimetres.
/// @param begun required where the stack of the problem is not empty
/// @throws InvalidArgument for a target without courses, or with counts that are not positive, for a stack
/// and courses that do not go together, and as find_next_pose does. Ctrl-C and the budget end it with the
/// best so far.
[[nodiscard]] WallPlan plan_wall(const SearchProblem& problem, const WallTarget& target,
                                 const SearchOptions& options = {},
                                 const std::function<void(const std::string&)>& report = {},
                                 const std::optional<WallBegun>& begun = std::nullopt);

/// Figures of a wall, or of what does the target's task, that stands: the stack of the problem, with the
/// courses of `begun`; `asked` is 0.
/// @throws InvalidArgument as plan_wall does.
[[nodiscard]] WallMetrics measure_wall(const SearchProblem& problem, const WallTarget& target,
                                       const WallBegun& begun, const SearchOptions& options = {});

}  // namespace stonestack::search

#pragma GCC visibility pop
