#pragma once
#include <functional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "stonestack/stacking/action.hpp"
#include "stonestack/stacking/world_estimate.hpp"
#include "stonestack/stone/catalogue.hpp"

#pragma GCC visibility push(default)

/// Events of a run, as values: log lines, journal, report and tests are made from these.
namespace stonestack::stacking {

/// A stone (index into the catalogue) and a statement about it.
struct StoneNote {
  int stone = -1;
  std::string note;
};

// Observation
struct Observed {  ///< without its views
  WorldEstimate world;
};
struct StoneMoved {  ///< a stone of the stack, beside where it was or was aimed
  int stone = -1;
  double shift = 0.0;  ///< distance, m
};
struct StoneLeftStack {
  int stone = -1;
};
struct StoneSought {
  LookAgain view;
};
struct StoneUncertain {  ///< which stone it is, or how it lies
  int stone = -1;
  double certainty = 1.0;
};
struct CameraRefined {
  double shift = 0, turn = 0;    ///< from the calibrated mount, m and rad
  int marks = 0;                 ///< stones seen twice
  double before = 0, after = 0;  ///< distance between the views, m
  bool accepted = true;
};
struct CameraNotTurned {};  ///< no motion to a turned view: the mount stays as calibrated
struct SiteOccupied {};     ///< when the run begins
struct SiteSeenFromOneSide {};
struct BackedAway {};  ///< the gripper stood too near to something

// Choice
struct StonesUnfit {  ///< for gripper or arm, wherever they lie
  std::vector<StoneNote> stones;
};
struct StonesNotHeld {  ///< as they lie
  std::vector<StoneNote> stones;
};
struct SearchProgress {
  std::string line;
};
struct SearchedAtFriction {
  double friction = 0.0;
  Route route = Route::kDirect;
  bool found = false;
  double expected = 0.0;  ///< stones
  double levels = 0.0;    ///< that were searched for
  std::string reason;     ///< when nothing was found
};
struct PlanHolds {
  double friction = 0.0;
};
struct PlanBroken {
  double friction = 0.0;
  std::string reason;
};
struct PlanAbandoned {  ///< no motion carries it out
  std::string refusals;
};
struct PosesRefused {
  std::size_t count = 0;
  std::string refusals;
};
struct GraspsRetried {};
struct StoneLeans {
  int stone = -1;
};
struct UnstackChosen {
  int top = -1;
  double expected = 0.0;  ///< stones in the end
  int count = 0;          ///< unstacked for it
};
struct UnstackToFree {
  int top = -1;
  int freed = -1;
};

struct ActionChosen {  ///< with the placements that the search offered, best first
  Action action;
  std::vector<Placement> offered;
};

// Motion and judgement
struct PlaceBegun {
  int level = 0;
  Placement placement;
};
struct SetDownBegun {
  Placement placement;
  bool reorients = false;
};
struct FingertipGrasp {  ///< near the table: the gripper approaches until it touches
  int stone = -1;
};
struct MotionRefused {
  Action action;
  std::string refusal;
};
struct PlacementJudged {
  PlacementRecord record;
};
struct FrictionMeasured {  ///< between a stone and the table, by dragging it
  int stone = -1;
  double friction = 0.0;
};
struct FrictionUpdated {
  FrictionEstimate friction;
};
struct StoneToppled {  ///< after it was set down
  int stone = -1;
};
struct RunEnded {
  RunEnd end = RunEnd::kAllPlaced;
  std::string reason;
};

// Steps of a motion
struct StepBegun {
  std::string name;
};
struct HoldMeasured {  ///< after the lift; N, N, m
  double weight = 0, expected = 0, offset = 0;
};
struct CarriedMeasured {  ///< before the stone is lowered; N, N, m, m
  double weight = 0, expected = 0, offset = 0, uncertainty = 0;
  bool held = false;
};
struct TouchMeasured {
  bool touched = false;
  double force = 0;      ///< contact force, N
  double above_end = 0;  ///< height above the end of the step, m
};
struct ReleaseMeasured {  ///< load on the gripper after release, and the largest load that counts as empty
                          ///< [N]
  double weight = 0, max_weight = 0;
};

using Event =
    std::variant<Observed, StoneMoved, StoneLeftStack, StoneSought, StoneUncertain, CameraRefined,
                 CameraNotTurned, SiteOccupied, SiteSeenFromOneSide, BackedAway, StonesUnfit, StonesNotHeld,
                 SearchProgress, SearchedAtFriction, PlanHolds, PlanBroken, PlanAbandoned, PosesRefused,
                 GraspsRetried, StoneLeans, UnstackChosen, UnstackToFree, ActionChosen, PlaceBegun,
                 SetDownBegun, FingertipGrasp, MotionRefused, PlacementJudged, FrictionMeasured,
                 FrictionUpdated, StoneToppled, RunEnded, StepBegun, HoldMeasured, CarriedMeasured,
                 TouchMeasured, ReleaseMeasured>;
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
