#include <algorithm>
#include <cmath>

#include "core/constants.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/stacking/event.hpp"

namespace stonestack::stacking {
namespace {

double tenth(double value) {
  return std::round(10 * value) / 10;
}

/// One event after the other in words; empty: nothing for a person.
struct Words {
  const Catalogue& catalogue;

  [[nodiscard]] const std::string& name(StoneIndex stone) const { return catalogue[stone].name; }
  [[nodiscard]] std::string names(const std::vector<StoneEstimate>& stones) const {
    std::string text;
    for (const auto& stone : stones) text += (text.empty() ? "" : ", ") + name(stone.stone);
    return text.empty() ? "none" : text;
  }

  std::string operator()(const Observed& e) const {
    return concat("stack: ", names(e.world.stack), "; loose: ", names(e.world.loose));
  }
  std::string operator()(const WallMeasured& e) const {
    if (e.wall.placed == 0) return "";
    if (e.wall.to_span > 0.0)
      return concat("bridge: ", e.wall.placed, " stones, ", std::round(1000 * e.wall.spanned), " of ",
                    std::round(1000 * e.wall.to_span), " mm spanned, bears ",
                    std::round(1000 * e.wall.margin) / 1000, " g sideways");
    return concat("wall: ", e.wall.placed, " stones, ", std::round(100 * e.wall.length) / 100, " m long, ",
                  std::round(100 * e.wall.height) / 100, " m high, bears ",
                  std::round(1000 * e.wall.margin) / 1000, " g sideways");
  }
  std::string operator()(const StoneMoved& e) const {
    return concat(name(e.stone), " of the stack is ", std::lround(1000 * e.shift), " mm from where it was");
  }
  std::string operator()(const StoneLeftStack& e) const {
    return name(e.stone) + " is no longer on the stack";
  }
  std::string operator()(const StoneSought& e) const {
    return concat("looking for ", name(e.view.stone),
                  e.view.where == LookAgain::Where::kWhereItWas ? " where it was" : " beside the site");
  }
  [[nodiscard]] std::string names(const std::vector<StoneIndex>& stones, const char* between) const {
    std::string text;
    for (const StoneIndex stone : stones) text += (text.empty() ? "" : between) + name(stone);
    return text;
  }
  std::string operator()(const ModellingBegun& e) const {
    if (e.in_sight)
      return concat("modelling ", names(e.lost, ", "),
                    " as it stands: by its model it cannot rest like that");
    return concat("modelling what is not recognised; out of sight: ", names(e.lost, ", "));
  }
  std::string operator()(const StoneModelled& e) const {
    if (e.in_sight) return concat(name(e.stone), " is modelled in the place of ", names(e.lost, ", "));
    return concat(name(e.stone), " is modelled, which may be ", names(e.lost, " or "),
                  " with another side up");
  }
  std::string operator()(const StoneUncertain& e) const {
    return concat(name(e.stone),
                  " may be turned or another stone of similar shape: it is seen with a certainty of ",
                  std::lround(100 * e.certainty), " %");
  }
  std::string operator()(const UnknownObjectSeen& e) const {
    return concat("something unknown at (", std::round(1e3 * e.p_W.x()) / 1e3, ", ",
                  std::round(1e3 * e.p_W.y()) / 1e3, ") m, ", std::round(1e3 * e.highest),
                  " mm high: kept clear of");
  }
  std::string operator()(const CameraRefined& e) const {
    return concat("camera mount: ", std::round(1e4 * e.shift) / 10, " mm and ",
                  std::round(e.turn * 572.9578) / 10, " deg beside its calibration by ", e.marks,
                  " stones seen twice, ", std::round(1e4 * e.before) / 10, " mm apart, then ",
                  std::round(1e4 * e.after) / 10, " mm; table ", std::round(1e4 * e.table_height) / 10,
                  " mm above its nominal plane, tilted by ", std::round(e.table_tilt * 572.9578) / 10, " deg",
                  e.accepted ? "" : "; not accepted: run `stonestack calibrate`");
  }
  std::string operator()(const CameraNotTurned&) const {
    return "the camera cannot be turned above the field; its mount is taken as calibrated";
  }
  std::string operator()(const SiteOccupied&) const { return "something stands at the site already"; }
  std::string operator()(const SiteSeenFromOneSide&) const {
    return "the site is seen from one side only: the camera does not reach another";
  }
  std::string operator()(const BackedAway&) const {
    return "the gripper stands too near to something to go on: it backs away first";
  }
  std::string operator()(const StonesUnfit& e) const {
    std::string text;
    for (const auto& [stone, why] : e.stones)
      text += concat(text.empty() ? "" : ", ", name(stone), " (", why, ")");
    return text.empty() ? "" : "left out, for gripper or arm cannot hold them: " + text;
  }
  std::string operator()(const StonesNotHeld& e) const {
    std::string text;
    for (const auto& [stone, why] : e.stones)
      text += concat(text.empty() ? "" : "; ", name(stone), ": ", why);
    return text.empty() ? "" : "no grasp holds a stone as it lies: " + text;
  }
  std::string operator()(const SearchProgress& e) const { return e.line; }
  std::string operator()(const SearchedAtFriction& e) const {
    return concat(
        "friction ", e.friction, e.route == Route::kReorienting ? ", stones reoriented: " : ": ",
        e.found ? concat(tenth(e.expected), " of ", e.levels, " stones are expected to stand") : e.reason);
  }
  std::string operator()(const PlanHolds&) const { return "the plan still holds"; }
  std::string operator()(const PlanBroken& e) const {
    return concat("friction ", e.friction, ": the plan does not hold any more: ", e.reason);
  }
  std::string operator()(const PlanAbandoned& e) const {
    return "the plan cannot be carried out: " + e.refusals;
  }
  std::string operator()(const PosesRefused& e) const {
    return concat("none of ", e.count, " poses can be reached, searching for others: ", e.refusals);
  }
  std::string operator()(const GraspsRetried&) const {
    return "nothing is left but grasps that failed before: they are tried again";
  }
  std::string operator()(const StoneLeans& e) const {
    return name(e.stone) + " leans on what is built: it goes back into the field";
  }
  std::string operator()(const UnstackChosen& e) const {
    return concat("nothing fits on ", name(e.top), ": built otherwise ", tenth(e.expected),
                  " stones are expected in all, so ", e.count,
                  e.count == 1 ? " stone is unstacked" : " stones are unstacked");
  }
  std::string operator()(const UnstackToFree& e) const {
    return concat(name(e.top), " is unstacked so that ", name(e.freed), " comes free");
  }
  std::string operator()(const ActionChosen&) const { return ""; }
  std::string operator()(const PlaceBegun& e) const {
    return concat("level ", e.level, ": ", name(e.placement.stone), ", cost ", e.placement.cost,
                  ", predicted success ", e.placement.predicted_success);
  }
  std::string operator()(const SetDownBegun& e) const {
    return e.reorients ? concat("no grasp brings ", name(e.placement.stone),
                                " there in one go: it is reoriented on the table first")
                       : "";
  }
  std::string operator()(const PushBegun& e) const {
    return concat(name(e.stone), " is pushed ", std::lround(1e3 * e.distance),
                  " mm over the table, to make room for fingers");
  }
  std::string operator()(const FingertipGrasp& e) const {
    return concat(name(e.stone),
                  " is held only with finger tips near the table: the gripper goes down until it touches");
  }
  std::string operator()(const MotionRefused& e) const {
    if (std::holds_alternative<Reorient>(e.action)) return "no stone can be reoriented for it: " + e.refusal;
    if (const auto* unstack = std::get_if<Unstack>(&e.action))
      return concat("no motion unstacks ", name(unstack->top.stone), ": ", e.refusal);
    if (const auto* clear = std::get_if<ClearBase>(&e.action))
      return concat(name(clear->stray.stone), " stays: ", e.refusal);
    if (const auto* push = std::get_if<Push>(&e.action))
      return concat(name(push->stone.stone), " is not pushed: ", e.refusal);
    return "";  // other candidates follow
  }
  std::string operator()(const PlacementJudged& e) const {
    return concat(e.record.stone, ": ", to_text(e.record.outcome),
                  e.record.note.empty() ? "" : ", " + e.record.note);
  }
  std::string operator()(const FrictionMeasured& e) const {
    return concat("friction of ", name(e.stone), " on the table: ", std::round(100 * e.friction) / 100);
  }
  std::string operator()(const FrictionUpdated& e) const {
    std::string text;
    for (std::size_t k = 0; k < e.friction.frictions.size(); ++k)
      text += concat(k == 0 ? "" : ", ", e.friction.frictions[k], ": ",
                     std::lround(100 * e.friction.weights[k]), " %");
    return "how likely each friction is after that fall: " + text;
  }
  std::string operator()(const StoneToppled& e) const {
    return name(e.stone) + " did not stay as it was set down";
  }
  std::string operator()(const StoneTooLight& e) const {
    return concat(name(e.stone), " weighs ", std::round(1e3 * e.weight / kGravity) / 1e3,
                  " kg, which is too little for stone: it is left where it lies");
  }
  std::string operator()(const RunEnded&) const { return ""; }  // who asked for the run prints it
  std::string operator()(const StepBegun&) const { return ""; }
  std::string operator()(const HoldMeasured&) const { return ""; }
  std::string operator()(const CarriedMeasured&) const { return ""; }
  std::string operator()(const TouchMeasured&) const { return ""; }
  std::string operator()(const ReleaseMeasured&) const { return ""; }
  std::string operator()(const GripperRetried& e) const {
    return "the gripper failed, and answers without a fault: once more. " + e.problem;
  }
};

}  // namespace

std::string to_text(RunEnd end) {
  switch (end) {
    case RunEnd::kAllPlaced:
      return "all_placed";
    case RunEnd::kHeightReached:
      return "height_reached";
    case RunEnd::kNoPose:
      return "no_feasible_pose";
    case RunEnd::kNoPlan:
      return "no_plan";
    case RunEnd::kPlacementFailed:
      return "placement_failed";
    case RunEnd::kNothingSeen:
      return "nothing_seen";
    case RunEnd::kStopped:
      return "stopped";
    case RunEnd::kInterrupted:
      return "interrupted";
    case RunEnd::kFailed:
      return "failed";
    case RunEnd::kPlanned:
      return "planned";
  }
  return "unknown";
}

std::string to_text(const Event& event, const Catalogue& catalogue) {
  return std::visit(Words{catalogue}, event);
}

}  // namespace stonestack::stacking
