#include "stacking/execute.hpp"

#include <algorithm>

#include "stacking/gripper_motion.hpp"
#include "stacking/plan_executor.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::stacking {
namespace {

constexpr const char* kEarlyContact = "early contact: the stone is held otherwise than planned";

/// The gripper is still empty.
bool leads_to_grasp(const PickAndPlacePlan& plan, const PlanStep& step) {
  return std::any_of(plan.steps.data() + (&step - plan.steps.data()), plan.steps.data() + plan.steps.size(),
                     [](const PlanStep& later) { return later.kind == PlanStep::Kind::kGrasp; });
}

}  // namespace

ExecutionResult execute(const PickAndPlacePlan& plan, const Stone& stone, const PlanningScene& scene,
                        Cell& cell, const MotionOptions& options, Journal* journal, LetGo how) {
  PlanExecutor executor{plan, stone, scene, cell, options, journal, how == LetGo::kTippedOver};
  using Status = ExecutionResult::Status;
  ExecutionResult result;
  bool lowered = false, touched = false, rests = false, loose = false;
  const PlanStep *lift = nullptr, *lowering = nullptr;
  const auto go = [&](const PlanStep& step) {
    return lift != nullptr && !loose ? executor.carry(*lift, step) : executor.follow(step);
  };
  for (const PlanStep& step : plan.steps) {
    throw_if_interrupted();
    executor.intend(step);
    ExecutionResult now;
    switch (step.kind) {
      case PlanStep::Kind::kOpen:
        if (step.spacing > 0) spread_gripper(cell, journal, step.spacing);
        executor.open(step);
        break;
      case PlanStep::Kind::kGrasp:
        executor.wrist.zero();
        now = executor.grasp(step);
        break;
      case PlanStep::Kind::kDescent:
        if (touched) break;  // already while lowering
        now = executor.check_carried(lift, step, lowering, &rests);
        if (now.status != Status::kReleased) break;
        executor.wrist.zero(executor.carried_weight);
        now = rests ? executor.feel_down_from_here(step, &touched) : executor.feel_down(step, &touched);
        lowered = true;
        result.contact_force = now.contact_force;
        if (rests) result.reason = kEarlyContact;
        if (!touched) result.reason = "no contact where the stone should touch; let go there";
        if (touched && how == LetGo::kDragged && now.status == Status::kReleased) {
          now = executor.measure_friction();
          result.friction = now.friction;
        }
        break;
      case PlanStep::Kind::kRelease:
        if (loose)
          now = executor.clear_table(step, step.opening);
        else if (lowered && !reports_object_at_rest(cell))
          now = executor.clear_table_empty(step, step.opening);
        if (now.status != Status::kReleased) break;
        loose = true;
        executor.open(step);
        executor.set_payload(false);
        break;
      case PlanStep::Kind::kRetreat:
        if (loose && how != LetGo::kTippedOver) now = executor.check_empty(step, true);
        if (now.status != Status::kReleased) break;
        now = lowered ? executor.retreat(step) : executor.follow(step);
        if (loose && now.status == Status::kReleased)
          now = executor.leave_empty(step, how == LetGo::kTippedOver);
        break;
      case PlanStep::Kind::kApproach:
        if (step.threshold <= 0) {
          now = go(step);
          break;
        }
        if (leads_to_grasp(plan, step)) {
          now = executor.approach_grasp(step);
          break;
        }
        now = executor.check_carried(lift, step);
        if (now.status != Status::kReleased) break;
        now = executor.feel_down(step, &touched);
        lowering = &step;
        lowered = touched;
        result.contact_force = now.contact_force;
        if (touched) result.reason = kEarlyContact;
        break;
      case PlanStep::Kind::kLift:
        now = executor.lift(step);
        if (now.status == Status::kReleased) now = executor.check_hold(step);
        result.weight = now.weight;
        lift = &step;
        break;
      case PlanStep::Kind::kTransit:
        now = go(step);
        break;
    }
    if (now.status != Status::kReleased) return now;
  }
  return result;
}

}  // namespace stonestack::stacking
