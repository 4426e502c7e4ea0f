#pragma once
#include <functional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "stonestack/search/plan_wall.hpp"
#include "stonestack/stacking/action.hpp"
#include "stonestack/stacking/world_estimate.hpp"
#include "stonestack/stone/catalogue.hpp"

#pragma GCC visibility push(default)

/// Events of a run, as values: log lines, journal, report and tests are made from these.
namespace stonestack::stacking {

/// A stone (index into the catalogue) and a statement about it.
struct StoneNote {
  StoneIndex stone = kNoStone;  ///< index into the catalogue
  std::string note;             ///< statement for a person
};

// Observation
/// A new estimate of the world, without its views.
struct Observed {
  WorldEstimate world;  ///< estimate after the observation
  /// Some thousand of the points that the camera saw near stones and table, W [m]; for reports.
  std::vector<Eigen::Vector3f> cloud_W = {};
};
/// The wall that is built was measured.
struct WallMeasured {
  WallMetrics wall;  ///< figures of what stands
};
/// A stone of the stack was found beside where it was or was aimed.
struct StoneMoved {
  StoneIndex stone = kNoStone;  ///< index into the catalogue
  double shift = 0.0;           ///< distance, m
};
/// A stone is not in the stack any more.
struct StoneLeftStack {
  StoneIndex stone = kNoStone;  ///< index into the catalogue
};
/// Something in view is no stone that is known: an obstacle from now on.
struct UnknownObjectSeen {
  Eigen::Vector2d p_W{0.0, 0.0};  ///< its middle [m]
  double highest = 0.0;           ///< above the table [m]
};
/// A missing stone is looked for.
struct StoneSought {
  LookAgain view;  ///< view that is taken for it
};
/// A detection left open which stone it is, or how it lies.
struct StoneUncertain {
  StoneIndex stone = kNoStone;  ///< index into the catalogue
  double certainty = 1.0;       ///< certainty of the detection
};
/// The camera's mount and the table's plane were estimated anew from stones and table that were seen twice.
struct CameraRefined {
  double shift = 0;         ///< distance from the calibrated mount [m]
  double turn = 0;          ///< angle from the calibrated mount [rad]
  int marks = 0;            ///< stones seen twice
  double before = 0;        ///< distance between the views with the calibrated mount [m]
  double after = 0;         ///< distance between the views with the new mount [m]
  double table_height = 0;  ///< of the table above its nominal plane, below the views [m]
  double table_tilt = 0;    ///< of the table against it [rad]
  bool accepted = true;     ///< false: mount and plane stay as they were calibrated
};
/// There is no motion to a turned view: the mount stays as calibrated.
struct CameraNotTurned {};
/// Something lies on the site when the run begins.
struct SiteOccupied {};
/// The site was seen from one side only.
struct SiteSeenFromOneSide {};
/// The arm moved back because the gripper was too near to something.
struct BackedAway {};

// Choice
/// Stones that are unfit for gripper or arm, wherever they lie.
struct StonesUnfit {
  std::vector<StoneNote> stones;  ///< stones, and why each is unfit
};
/// Stones that the gripper cannot hold as they lie.
struct StonesNotHeld {
  std::vector<StoneNote> stones;  ///< stones, and why each cannot be held
};
/// A line of the search's progress.
struct SearchProgress {
  std::string line;  ///< line for a person
};
/// A search at one assumed friction came to its end.
struct SearchedAtFriction {
  double friction = 0.0;         ///< friction coefficient
  Route route = Route::kDirect;  ///< how the stone is brought to its place
  bool found = false;            ///< true if a placement was found
  double expected = 0.0;         ///< stones
  double levels = 0.0;           ///< that were searched for
  std::string reason;            ///< when nothing was found
};
/// The earlier plan still holds.
struct PlanHolds {
  double friction = 0.0;  ///< friction coefficient at which it was checked
};
/// The earlier plan does not hold any more.
struct PlanBroken {
  double friction = 0.0;  ///< friction coefficient at which it was checked
  std::string reason;     ///< reason for a person
};
/// An earlier plan is given up: no motion carries it out.
struct PlanAbandoned {
  std::string refusals;  ///< reasons for a person
};
/// No motion carries out the placements that were found.
struct PosesRefused {
  std::size_t count = 0;  ///< number of placements
  std::string refusals;   ///< reasons for a person
};
/// Grasps that failed before are allowed again.
struct GraspsRetried {};
/// A loose stone leans on the stack.
struct StoneLeans {
  StoneIndex stone = kNoStone;  ///< index into the catalogue
};
/// Stones are unstacked so that another tower can be built.
struct UnstackChosen {
  StoneIndex top = kNoStone;  ///< top stone of the stack
  double expected = 0.0;      ///< stones in the end
  int count = 0;              ///< unstacked for it
};
/// A stone is unstacked to free another.
struct UnstackToFree {
  StoneIndex top = kNoStone;    ///< top stone of the stack
  StoneIndex freed = kNoStone;  ///< stone that is freed
};

/// The next action, with the placements that the search offered, best first.
struct ActionChosen {
  Action action;                   ///< action that was chosen
  std::vector<Placement> offered;  ///< placements that the search offered, best first
  /// Placements that it compared with these and did not offer, best first; where an earlier plan is followed,
  /// those that the search compared when it made the plan.
  std::vector<Alternative> others = {};
};

// Motion and judgement
/// The arm begins to place a stone.
struct PlaceBegun {
  int level = 0;        ///< level of the stone, from 1 on the table
  Placement placement;  ///< placement that is carried out
};
/// The arm begins to set a stone down beside the tower.
struct SetDownBegun {
  Placement placement;     ///< stone, and the pose where it is set down
  bool reorients = false;  ///< true: to reorient it; false: to take it off the stack or away from its base
};
/// The arm begins to push a stone away from what keeps the fingers off it.
struct PushBegun {
  StoneIndex stone = kNoStone;  ///< index into the catalogue
  double distance = 0.0;        ///< over the table [m]
};
/// A grasp near the table: the gripper approaches until it touches.
struct FingertipGrasp {
  StoneIndex stone = kNoStone;  ///< index into the catalogue
};
/// No motion carries out an action.
struct MotionRefused {
  Action action;        ///< action that was refused
  std::string refusal;  ///< reason for a person
};
/// The observation after a placement was judged.
struct PlacementJudged {
  PlacementRecord record;  ///< record of the placement
};
/// The friction between a stone and the table was measured by dragging it.
struct FrictionMeasured {
  StoneIndex stone = kNoStone;  ///< index into the catalogue
  double friction = 0.0;        ///< coefficient
};
/// The estimate of the friction was updated.
struct FrictionUpdated {
  FrictionEstimate friction;  ///< new estimate
};
/// A stone toppled after it was set down.
struct StoneToppled {
  StoneIndex stone = kNoStone;  ///< index into the catalogue
};
/// A lifted object is too light for stone.
struct StoneTooLight {
  StoneIndex stone = kNoStone;  ///< index into the catalogue
  double weight = 0.0;          ///< measured [N]
};
/// The run ended.
struct RunEnded {
  RunEnd end = RunEnd::kAllPlaced;  ///< reason as a value
  std::string reason;               ///< reason for a person
};

// Steps of a motion
/// The executor began a step of a plan.
struct StepBegun {
  std::string name;  ///< name of the step
};
/// Load of the stone after the lift: measured weight, expected weight (N), offset of the line of action (m).
struct HoldMeasured {
  double weight = 0;    ///< measured weight [N]
  double expected = 0;  ///< expected weight [N]
  double offset = 0;    ///< distance of the line of action from the expected centre of mass [m]
};
/// Load of the stone before it is lowered.
struct CarriedMeasured {
  double weight = 0;       ///< measured weight [N]
  double expected = 0;     ///< expected weight [N]
  double offset = 0;       ///< distance of the line of action from the expected centre of mass [m]
  double uncertainty = 0;  ///< of the offset [m]
  bool held = false;       ///< true if the stone is still in the gripper
};
/// The descent ended.
struct TouchMeasured {
  bool touched = false;  ///< true if a contact ended it
  double force = 0;      ///< contact force, N
  double above_end = 0;  ///< height above the end of the step, m
};
/// Load on the gripper after release, and the largest load that counts as empty.
struct ReleaseMeasured {
  double weight = 0;      ///< load [N]
  double max_weight = 0;  ///< limit [N]
};
/// The gripper failed at a motion, answered without a fault when it was asked, and gets the command once
/// more.
struct GripperRetried {
  std::string problem;  ///< as the gripper reported it
};

/// Objects that are recognised as none of the stones are about to be viewed and modelled.
struct ModellingBegun {
  std::vector<StoneIndex> lost;  ///< stones that are out of sight
  bool in_sight = false;         ///< they are seen, but by their models they cannot rest as they do
};
/// An object that was none of the stones is one now: its model stands in the catalogue of the run.
struct StoneModelled {
  StoneIndex stone = kNoStone;   ///< index in the catalogue, the last one
  std::vector<StoneIndex> lost;  ///< stones that are out of sight, of which it may be one
  bool in_sight = false;         ///< it takes the place of the one stone that `lost` names
};

/// Anything that happens in a run.
using Event =
    std::variant<Observed, WallMeasured, StoneMoved, StoneLeftStack, StoneSought, StoneUncertain,
                 UnknownObjectSeen, CameraRefined, CameraNotTurned, SiteOccupied, SiteSeenFromOneSide,
                 BackedAway, StonesUnfit, StonesNotHeld, SearchProgress, SearchedAtFriction, PlanHolds,
                 PlanBroken, PlanAbandoned, PosesRefused, GraspsRetried, StoneLeans, UnstackChosen,
                 UnstackToFree, ActionChosen, PlaceBegun, SetDownBegun, PushBegun, FingertipGrasp,
                 MotionRefused, PlacementJudged, FrictionMeasured, FrictionUpdated, StoneToppled,
                 StoneTooLight, RunEnded, StepBegun, HoldMeasured, CarriedMeasured, TouchMeasured,
                 ReleaseMeasured, GripperRetried, ModellingBegun, StoneModelled>;
/// Receiver of events.
using Listener = std::function<void(const Event&)>;

/// A line for a person; empty for an event that is for the journal only.
[[nodiscard]] std::string to_text(const Event& event, const Catalogue& catalogue);
/// Kind and JSON data for the journal; an empty kind for an event that is not recorded.
[[nodiscard]] std::pair<std::string, std::string> to_record(const Event& event, const Catalogue& catalogue);
/// All events of one type, in order.
template <class E>
[[nodiscard]] std::vector<E> all_of(const std::vector<Event>& events) {
  std::vector<E> found;
  for (const Event& event : events)
    if (const E* one = std::get_if<E>(&event)) found.push_back(*one);
  return found;
}

}  // namespace stonestack::stacking

#pragma GCC visibility pop
