#pragma once
#include <optional>
#include <string>
#include <vector>

#include "stonestack/core/options.hpp"
#include "stonestack/detection/detect_stones.hpp"
#include "stonestack/hardware/cell.hpp"
#include "stonestack/motion/pick_and_place.hpp"
#include "stonestack/search/find_next_pose.hpp"
#include "stonestack/search/plan_wall.hpp"
#include "stonestack/stacking/action.hpp"
#include "stonestack/stacking/event.hpp"
#include "stonestack/stacking/world_estimate.hpp"
#include "stonestack/stone/catalogue.hpp"

#pragma GCC visibility push(default)

namespace stonestack::stacking {

/// Options of the whole loop.
struct BuildOptions {
  DetectionOptions detection;   ///< options of detection
  SearchOptions search;         ///< options of the search
  MotionOptions motion;         ///< options of motion planning
  int max_stones = 0;           ///< stop at this height; 0: all that are seen
  double view_distance = 0.62;  ///< distance from the camera to its target, m; SR300: 0.2 to 1.5 m
  double placed_shift =
      0.030;  ///< distance measured to the planned pose up to which a stone counts as placed, m
  double placed_turn = 0.35;  ///< angle likewise, rad
  double moved_shift =
      0.012;  ///< shift from where a stone of the stack was (or was aimed) from which it is reported, m
  /// The search starts at search.friction and climbs to this while it finds no sure pose: dry limestone on
  /// limestone slides at more (design choice).
  double max_friction = 0.475;
  double friction_step = 0.125;  ///< step between the friction coefficients that are searched with
  int first_rounds = 2;          ///< of the search at each friction but the last: what they did not finish
                                 ///< begins the search at the next
  double sure_success = 0.8;     ///< share of the tower that is expected to stand, which ends the climb
  /// Stones that must be expected to stand by a placement and what follows it, over all frictions; less is
  /// not tried, as a fall takes the stones below with it.
  double min_expected = 0.4;
  int max_failures = 3;  ///< placements that may fail before the run ends; the paper ends at the first
  bool refine_camera =
      true;  ///< two first views, half a turn and 10 cm apart, show where the camera is mounted
  /// false: what is seen near where it was planned is taken to lie as planned; for measuring what measuring
  /// is worth
  bool measure_placed = true;
  /// the first stone is dragged over the table by 16 mm before it is released: a slippery set is known to be
  /// slippery before a stone is stacked
  bool measure_friction = true;
  bool correct_aim = true;  ///< aim beside the target by how far earlier stones were seen beside theirs
  int max_unstacked = 6;    ///< stones unstacked to build otherwise; the paper never does
  int max_reoriented = 3;   ///< stones reoriented because no grasp served both ends
  int pick_attempts = 3;    ///< of one stone that the gripper misses or drops
  /// Path of the finger tips that plans count on: parallel or three_finger (motion::Linkage).
  std::string linkage = "parallel";
  /// Wall that is built: stones a course ("4+3+2+1"), metres and courses ("0.8x3") or a target file
  /// (`read_wall_target`); empty: a tower. Needs the default search.
  std::string wall;
  /// Gripper of the simulated cell, by its name or a YAML; empty: of the cell file, or robotiq-3f.
  std::string gripper;
  /// The stones are in no catalogue: the arm's camera models them before anything is built (`model_field`).
  /// For who makes the catalogue; `build_tower` itself is given one, and adds nothing to it.
  bool unseen = false;
  bool save_states = false;  ///< writes the state before each decision into the run's folder, for `decide`
};
/// Names the options of the loop.
[[nodiscard]] FieldList fields(BuildOptions& options);
/// Refuses, before anything moves, options that cannot be, or not together.
/// @throws InvalidArgument, FileError for a target file
void check_options(const BuildOptions& options);

/// The frictions that are assumed in turn: rising, from search.friction to max_friction.
[[nodiscard]] std::vector<double> assumed_frictions(const BuildOptions& options);

/// Host seconds for which the arm waited (detection, search, planning) and arm seconds (motion, by the cell's
/// clock). What was detected and searched beside a motion, as far as it was no longer than that, is counted
/// apart.
struct StageSeconds {
  double detection = 0;      ///< [s] of the host
  double search = 0;         ///< [s] of the host
  double planning = 0;       ///< [s] of the host
  double motion = 0;         ///< [s] by the cell's clock
  double beside_motion = 0;  ///< detection and search while the arm moved [s]
};

/// State of arm and gripper at one time, as the devices reported it.
struct MotionSample {
  double time = 0.0;          ///< of the cell's clock [s]
  Joints q = Joints::Zero();  ///< joint angles [rad]
  double opening = 0.155;     ///< between the finger pads [m]
  double spacing = 0.073;     ///< of fingers B and C [m]
  double force = 0.0;         ///< at the wrist, last reading [N]
  bool holds = false;         ///< the fingers were stopped by an object
};

/// History of a run over time. Between two samples the joints move in a straight line.
struct Timeline {
  std::vector<MotionSample> samples;  ///< samples in the order of time
  std::vector<double> event_time;     ///< of each event of the result [s]
};

/// A step that is yet to be carried out.
struct PlannedStep {
  std::string name;         ///< name of the step
  double seconds = 0.0;     ///< duration of the arm's motion [s]; 0: of the fingers alone
  double tool_speed = 0.0;  ///< largest speed of the tool's tip [m/s]
  /// Smallest distance between things that must not touch [m]; empty: not measured
  std::optional<double> clearance = std::nullopt;
};
/// "move above limestone_3: 2.4 s, tool up to 0.250 m/s"
[[nodiscard]] std::string to_text(const PlannedStep& step);

/// Result of a run, as the program knows it: made from its events.
struct RunResult {
  /// End of a run, by the name that it has in results.
  using End = RunEnd;
  int height = 0;                           ///< stones that the last observation shows stacked
  std::vector<PlacementRecord> placements;  ///< stones that were handled, in order
  std::string ended;                        ///< why it stopped
  End end = End::kAllPlaced;                ///< reason why the run ended
  StageSeconds seconds;                     ///< durations of the stages
  WorldEstimate world;                      ///< as last observed
  std::optional<WallMetrics> wall;          ///< figures of the wall as last observed; empty for a tower
  std::vector<Event> events;                ///< events in order
  Timeline timeline;                        ///< motion of arm and stones over time
  std::vector<PlannedStep> planned;         ///< of a dry run: what it would do first
};

class Journal;  // private: the append-only record that a run's folder holds

/// Asked before each motion of arm and fingers, which waits meanwhile; false ends the run as interrupted. May
/// come from another thread than the run's.
using BeforeMotion = std::function<bool(const PlannedStep&)>;

/// Listeners of a run.
struct BuildHooks {
  Listener listener;           ///< every event, from one thread
  Journal* journal = nullptr;  ///< intents and outcomes; none: not kept
  std::string states_folder;   ///< where `run.save_states` writes; empty: nowhere
  BeforeMotion before_motion;  ///< empty: nobody is asked
};

/// The paper's loop (figure 1), for a tower or, with `options.wall`, for a wall: observe, choose, plan,
/// execute, observe again, judge, learn, until no pose is feasible, a placement failed, or all stones are
/// placed. Stops the arm and returns what was done when interrupted or when a device fails. The journal's
/// last line, of kind "end", records how the run ended and why.
[[nodiscard]] RunResult build_tower(Cell& cell, const Catalogue& catalogue, const RobotModel& robot,
                                    const BuildOptions& options, const BuildHooks& hooks = {});

/// The first step of a run, planned and not carried out.
struct FirstStep {
  RunResult result;       ///< ended as `RunEnd::kPlanned`, or why no step was found
  PlanningScene scene;    ///< as it was seen
  PickAndPlacePlan plan;  ///< of the stone that is brought; no steps where the arm would only look again
  std::optional<PickAndPlaceTask> task;  ///< the plan's, which points into the catalogue; of loose stones
};
/// Takes one view from where the arm stands and plans the first action that a motion is found for. Commands
/// no device. Camera mount and table are taken to be as the cell states them, and a site out of view to be
/// free. Listens and records as `build_tower`.
[[nodiscard]] FirstStep plan_first_step(Cell& cell, const Catalogue& catalogue, const RobotModel& robot,
                                        const BuildOptions& options, const BuildHooks& hooks = {});

}  // namespace stonestack::stacking

#pragma GCC visibility pop
