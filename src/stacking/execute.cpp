#include "stacking/execute.hpp"

#include <algorithm>

#include "stacking/hands.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::stacking {
namespace {

/// The hand is still empty.
bool leads_to_grasp(const PickAndPlacePlan& plan, const PlanStep& step) {
  return std::any_of(plan.steps.data() + (&step - plan.steps.data()), plan.steps.data() + plan.steps.size(),
                     [](const PlanStep& later) { return later.kind == PlanStep::Kind::kGrasp; });
}

}  // namespace

ExecutionResult execute(const PickAndPlacePlan& plan, const Stone& stone, const PlanningScene& scene,
                        Cell& cell, const MotionOptions& options, Journal* journal) {
  Hands hands{plan, stone, scene, cell, options, journal};
  using Status = ExecutionResult::Status;
  ExecutionResult result;
  bool lowered = false, touched = false, loose = false;
  const PlanStep* lift = nullptr;
  for (const PlanStep& step : plan.steps) {
    throw_if_interrupted();
    hands.intend(step);
    ExecutionResult now;
    switch (step.kind) {
      case PlanStep::Kind::kOpen:
        if (step.spacing > 0) cell.gripper.spread(step.spacing);
        hands.open(step);
        break;
      case PlanStep::Kind::kGrasp:
        hands.wrist.zero();
        now = hands.grasp(step);
        break;
      case PlanStep::Kind::kDescent:
        if (touched) break;  // already while lowering
        now = hands.check_carried(lift, step);
        if (now.status != Status::kReleased) break;
        hands.wrist.zero(hands.hangs);
        now = hands.feel_down(step, &touched);
        lowered = true;
        result.contact_force = now.contact_force;
        if (!touched) result.reason = "no contact where the stone should touch; let go there";
        break;
      case PlanStep::Kind::kRelease:
        if (loose) now = hands.clear_table(step);
        if (now.status != Status::kReleased) break;
        loose = true;
        hands.open(step);
        hands.set_payload(false);
        break;
      case PlanStep::Kind::kRetreat:
        if (loose) now = hands.check_empty(step, true);
        if (now.status != Status::kReleased) break;
        now = lowered ? hands.retreat(step) : hands.follow(step);
        if (loose && now.status == Status::kReleased) now = hands.check_empty(step, false);
        break;
      case PlanStep::Kind::kApproach:
        if (step.threshold <= 0) {
          now = hands.follow(step);
          break;
        }
        if (leads_to_grasp(plan, step)) {
          now = hands.feel_table(step);
          break;
        }
        now = hands.check_carried(lift, step);
        if (now.status != Status::kReleased) break;
        now = hands.feel_down(step, &touched);
        lowered = touched;
        result.contact_force = now.contact_force;
        if (touched) result.reason = "touched early: the stone hangs otherwise than planned";
        break;
      case PlanStep::Kind::kLift:
        now = hands.follow(step);
        if (now.status == Status::kReleased) now = hands.check_hold(step);
        lift = &step;
        break;
      case PlanStep::Kind::kTransit:
        now = hands.follow(step);
        break;
    }
    if (now.status != Status::kReleased) return now;
  }
  return result;
}

}  // namespace stonestack::stacking
