#pragma once
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "stonestack/detection/detect_stones.hpp"
#include "stonestack/hardware/cell.hpp"
#include "stonestack/motion/pick_and_place.hpp"
#include "stonestack/search/find_next_pose.hpp"
#include "stonestack/stacking/journal.hpp"
#include "stonestack/stacking/observe.hpp"
#include "stonestack/stone/catalogue.hpp"

namespace stonestack::stacking {

/// Options of the whole loop.
struct BuildOptions {
  BuildOptions() {
    search.largest_tilt = 1.0;  // one grasp serves pick and place: turned little, as in the paper
    // Measured with the camera refined, planned against measured poses of `stonestack run`, seeds 1 and 7:
    // 0.5 to 1.8 mm and 0.4 to 1.2 deg in all for stones that hold at once.
    search.placement_sigma_translation = 0.0015;
    search.placement_sigma_rotation = 0.015;
    search.com_sigma = 0.001;  // centres of mass are known to 2 mm, say evenly in a ball: 0.9 mm an axis
  }
  DetectionOptions detection;
  SearchOptions search;
  MotionOptions motion;
  int most_stones = 0;          ///< stop at this height; 0: all that are seen
  double look_distance = 0.62;  ///< m from camera to what it looks at; SR300: 0.2 to 1.5 m
  double placed_shift = 0.030;  ///< m: measured nearer than this to the planned pose counts as placed
  double placed_turn = 0.35;    ///< rad
  double moved_shift =
      0.012;  ///< m: a stone of the stack seen further from where it was (or was aimed) is reported
  /// The search starts at search.friction and climbs to this while it finds no sure pose: dry limestone on
  /// limestone slides at more (ours).
  double most_friction = 0.475;
  double friction_step = 0.125;
  int first_rounds = 2;       ///< of the search at each friction but the last: what they did not finish
                              ///< begins the search at the next
  double sure_success = 0.8;  ///< share of the tower that is expected to stand, which ends the climb
  /// Stones that must be expected to stand by a placement and what follows it, over all frictions; less is
  /// not tried, as a fall takes the stones below with it.
  double least_expected = 0.4;
  int most_failures = 3;  ///< placements that may fail before the run ends; the paper ends at the first
  bool refine_camera =
      true;  ///< two first looks, half a turn and 10 cm apart, tell where the camera really sits
  /// false: what is seen near where it was planned is believed to lie as planned; for telling what measuring
  /// is worth
  bool measure_placed = true;
  bool correct_aim = true;   ///< aim beside the target by how far earlier stones were seen beside theirs
  int most_taken_off = 6;    ///< stones put back into the field to try another way; the paper never does
  int most_turned_over = 3;  ///< stones laid down another way because no grasp served both ends
  int pick_attempts = 3;     ///< of one stone that the gripper misses or drops
};
[[nodiscard]] FieldList fields(BuildOptions& options);

/// One attempted placement.
struct PlacementRecord {
  enum class Outcome { kPlaced, kMoved, kFallen, kNotPicked, kDropped, kLost, kTakenOff, kTurnedOver };
  std::string stone;
  Placement planned;
  std::optional<Pose> T_W_O_measured;
  Outcome outcome = Outcome::kPlaced;
  std::string note;
  int level = 0;  ///< that it was meant for, from 1 on the table; 0: for none (taken off, turned over)
};
/// "placed", "moved", "fallen", "not picked", "dropped" (out of the hand, on the way), "lost" (let go of, not
/// seen afterwards), "taken off", "turned over".
[[nodiscard]] std::string to_text(PlacementRecord::Outcome outcome);

/// Host seconds for which the arm waited (detection, search, planning) and arm seconds (motion, by the cell's
/// clock). What was detected and searched beside a motion, as far as it was no longer than that, is counted
/// apart.
struct StageSeconds {
  double detection = 0, search = 0, planning = 0, motion = 0, beside_motion = 0;
};

/// What a run did, as the program knows it.
struct RunResult {
  int height = 0;  ///< stones that the last observation shows stacked
  std::vector<PlacementRecord> placements;
  std::string ended;  ///< why it stopped
  enum class End {
    kAllPlaced,
    kHeightReached,
    kNoPose,
    kNoPlan,
    kPlacementFailed,
    kNothingSeen,
    kStopped,
    kInterrupted
  };
  End end = End::kAllPlaced;
  StageSeconds seconds;
  Belief belief;  ///< as last measured
};

/// "all_placed", "height_reached", "no_feasible_pose", "no_plan", "placement_failed", "nothing_seen",
/// "stopped", "interrupted".
[[nodiscard]] std::string to_text(RunResult::End end);

/// Who is told what happens.
struct BuildHooks {
  std::function<void(const std::string&)> report;  ///< a line of progress
  Journal* journal = nullptr;                      ///< intents and outcomes; none: not kept
};

/// The paper's loop (figure 1): observe, search, plan, execute, observe again, judge, until no pose is
/// feasible, a placement failed, or all stones are placed. Stops the arm and returns what was done when
/// interrupted or when a device fails. The journal's last line, of kind "end", says how the run ended and
/// why.
[[nodiscard]] RunResult build_tower(Cell& cell, const Catalogue& catalogue, const RobotModel& robot,
                                    const BuildOptions& options, const BuildHooks& hooks = {});

}  // namespace stonestack::stacking
