#include <algorithm>

#include "stacking/execute.hpp"
#include "stacking/gripper_motion.hpp"
#include "stacking/plan_executor.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::stacking {

ExecutionResult execute_push(const PickAndPlacePlan& plan, const Stone& stone, const PlanningScene& scene,
                             Cell& cell, const MotionOptions& options, Journal* journal) {
  using Kind = PlanStep::Kind;
  using Status = ExecutionResult::Status;
  const PlanExecutor executor{plan, stone, scene, cell, options, journal};
  ExecutionResult result;
  std::vector<const PlanStep*> done;  // down behind the stone, and the first towards it
  bool returned = false;              // along the way that it came on
  const auto give_up = [&](const char* why) {
    result.reason = why;
    returned = true;
  };
  const auto last = std::find_if(plan.steps.rbegin(), plan.steps.rend(),
                                 [](const PlanStep& step) { return step.kind == Kind::kDescent; });
  for (const PlanStep& step : plan.steps) {
    throw_if_interrupted();
    if (returned && step.kind != Kind::kOpen) continue;
    executor.intend(step);
    ExecutionResult now;
    bool touched = false;
    switch (step.kind) {
      case Kind::kOpen:
        if (step.spacing > 0) spread_gripper(cell, journal, step.spacing);
        executor.open(step);
        break;
      case Kind::kApproach:
        done.push_back(&step);
        now = executor.feel_down(step, &touched);
        if (!touched) break;
        now = executor.back_to_start(step);
        result.status = Status::kNotPicked;
        give_up("something is met behind the stone");
        break;
      case Kind::kDescent:
        if (done.empty() || done.back()->kind != Kind::kDescent) done.push_back(&step);
        now = executor.push(step, &touched);
        result.contact_force = now.contact_force;
        if (!touched || &step != &*last) break;  // the first goes up to the stone
        for (; !done.empty() && now.status == Status::kReleased; done.pop_back())
          now = executor.back_to_start(*done.back());
        give_up("it resists: pushed a part of the way");
        break;
      case Kind::kRetreat:
        now = executor.follow_from_here(step);
        break;
      default:
        now = executor.follow(step);
    }
    if (now.status != Status::kReleased) return now;
  }
  return result;
}

}  // namespace stonestack::stacking
