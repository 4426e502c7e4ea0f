#include "stacking/execute.hpp"
#include "stacking/plan_executor.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::stacking {

ExecutionResult execute_push(const PickAndPlacePlan& plan, const Stone& stone, const PlanningScene& scene,
                             Cell& cell, const MotionOptions& options, Journal* journal) {
  using Kind = PlanStep::Kind;
  using Status = ExecutionResult::Status;
  const PlanExecutor executor{plan, stone, scene, cell, options, journal};
  ExecutionResult result;
  const PlanStep* down = nullptr;  // behind the stone
  bool returned = false;           // along the way that it came on
  const auto give_up = [&](const char* why) {
    result.reason = why;
    returned = true;
  };
  for (const PlanStep& step : plan.steps) {
    throw_if_interrupted();
    if (returned && step.kind != Kind::kOpen) continue;
    executor.intend(step);
    ExecutionResult now;
    bool touched = false;
    switch (step.kind) {
      case Kind::kOpen:
        if (step.spacing > 0) cell.gripper.spread(step.spacing);
        executor.open(step);
        break;
      case Kind::kApproach:
        down = &step;
        now = executor.feel_down(step, &touched);
        if (!touched) break;
        now = executor.back_to_start(step);
        result.status = Status::kNotPicked;
        give_up("something is met behind the stone");
        break;
      case Kind::kDescent:
        now = executor.push(step, &touched);
        result.contact_force = now.contact_force;
        if (!touched) break;
        now = executor.back_to_start(step);
        if (now.status == Status::kReleased && down != nullptr) now = executor.back_to_start(*down);
        give_up("it resists: pushed a part of the way");
        break;
      default:
        now = executor.follow(step);
    }
    if (now.status != Status::kReleased) return now;
  }
  return result;
}

}  // namespace stonestack::stacking
