#include "stacking/plan_motion.hpp"

#include <algorithm>

#include "motion/push.hpp"
#include "motion/regrasp.hpp"
#include "motion/transit.hpp"
#include "stacking/choose_placement.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::stacking {
namespace {

void name_useless_grasps(PickAndPlaceTask& task, const RunMemory& memory,
                         const std::map<StoneIndex, std::vector<Pose>>& no_pick, StoneIndex stone) {
  task.avoid = failed_twice(memory, stone);
  if (const auto failed = memory.failed_grasps.find(stone); failed != memory.failed_grasps.end())
    task.failed_once = failed->second;
  if (const auto none = no_pick.find(stone); none != no_pick.end()) task.no_pick = none->second;
}

void add_refusal(MotionPlan& plan, const std::string& refusal) {
  plan.refusal += concat(plan.refusal.empty() ? "" : "; ", refusal);
}

/// One kind of action after the other.
struct Planner {
  Workcell& w;
  const RunMemory& memory;
  Arrangement arrangement;
  Reach reach;
  MotionPlan plan;
  Joints q;

  [[nodiscard]] PickAndPlaceTask task_for(StoneIndex stone, const Pose& T_W_O) const {
    auto task = make_task(*w.models.catalogue, arrangement, stone, T_W_O, q);
    name_useless_grasps(task, memory, plan.no_pick, stone);
    return task;
  }
  /// True if the plan for the task is one.
  bool accept(PickAndPlacePlan made, const Placement& placement) {
    plan.found = made.status == PickAndPlacePlan::Status::kPlanned;
    plan.placement = placement;
    plan.pick_and_place = std::move(made);
    return plan.found;
  }

  void operator()(const Place& action) {
    if (w.options.correct_aim) plan.p_W_aim = placing_bias(memory.records);
    for (const Placement& placement : action.candidates) {
      throw_if_interrupted();
      const StoneIndex stone = placement.stone;
      const Pose T_W_O_aim = Eigen::Translation3d(-plan.p_W_aim) * placement.T_W_O;
      if (accept(plan_pick_and_place(plan.scene, task_for(stone, T_W_O_aim), reach.options_for(stone)),
                 placement)) {
        if (reach.is_low(stone)) w.emit(FingertipGrasp{stone});
        return;
      }
      add_refusal(plan, concat(w.models.name(stone), ": ", plan.pick_and_place.reason));
      auto& useless = plan.no_pick[stone];
      useless.insert(useless.end(), plan.pick_and_place.no_pick.begin(), plan.pick_and_place.no_pick.end());
    }
  }

  void operator()(const Reorient& action) {
    for (const Placement& placement : action.candidates) {
      throw_if_interrupted();
      const StoneIndex stone = placement.stone;
      RegraspPlan made = plan_regrasp(plan.scene, task_for(stone, placement.T_W_O), reach.options_for(stone),
                                      regrasp_options(memory, stone));
      if (!made.planned) {
        add_refusal(plan, made.reason);
        continue;
      }
      plan.followed = placement;
      Placement down;
      down.stone = stone;
      down.T_W_O = made.T_W_O_between.front();
      static_cast<void>(accept(std::move(made.plans.front()), down));
      plan.found = true;
      if (reach.is_low(stone)) w.emit(FingertipGrasp{stone});
      return;
    }
  }

  void set_down(PickAndPlaceTask task, StoneIndex stone, const std::vector<Pose>& T_W_O_down) {
    plan.refusal = "the field has no free space";
    for (const Pose& T_W_O : T_W_O_down) {
      task.T_W_O_place = T_W_O;
      Placement down;
      down.stone = stone;
      down.T_W_O = T_W_O;
      if (accept(plan_pick_and_place(plan.scene, task, w.options.motion), down)) return;
      plan.refusal = plan.pick_and_place.reason;
    }
  }

  void operator()(const Unstack& action) {
    PickAndPlaceTask task;
    task.stone = &w.models.stone(action.top.stone);
    task.object = static_cast<int>(arrangement.stack.size()) - 1;
    task.T_W_O_pick = action.top.T_W_O;
    task.q_start = q;
    name_useless_grasps(task, memory, plan.no_pick, action.top.stone);
    set_down(task, action.top.stone, action.T_W_O_down);
  }

  void operator()(const ClearBase& action) {
    PickAndPlaceTask task = task_for(action.stray.stone, Pose::Identity());
    task.support = -1;
    set_down(task, action.stray.stone, action.T_W_O_down);
  }

  void operator()(const Push& action) {
    const PickAndPlaceTask lies = task_for(action.stone.stone, action.stone.T_W_O);
    for (const Eigen::Vector2d& shift : action.p_W_shifts) {
      Placement there;
      there.stone = action.stone.stone;
      there.T_W_O = Eigen::Translation3d(shift.x(), shift.y(), 0.0) * action.stone.T_W_O;
      const PushTask task{lies.stone, lies.object, lies.T_W_O_pick, shift, q};
      if (accept(plan_push(plan.scene, task, w.options.motion), there)) return;
      plan.refusal = plan.pick_and_place.reason;
    }
  }

  void operator()(const LookAgain& action) {
    const PlanningScene scene = scene_of_view(w, arrangement);
    const Pose T_C_F = (w.cell.layout.T_F_T * w.cell.layout.T_T_C).inverse();
    for (const Pose& T_W_C : view_poses(w.cell.layout, action.p_W_target, w.options.view_distance))
      if (auto route = plan_transit(scene, q, Pose(T_W_C * T_C_F), w.options.motion)) {
        plan.route = *std::move(route);
        plan.found = true;
        return;
      }
  }

  void operator()(const ModelAnew&) { plan.found = true; }  // views are planned one after the other
  void operator()(const Stop&) {}
};

}  // namespace

MotionPlan plan_motion(Workcell& w, const WorldEstimate& world, const Action& action,
                       const RunMemory& memory) {
  const Stopwatch watch;
  const Arrangement arrangement = at_rest(world);
  PlanningScene scene = make_planning_scene(w.cell.layout, *w.models.robot, *w.models.catalogue, arrangement);
  // Asked before the rest is made: GCC 12 destroys members of an aggregate twice where a later one throws.
  const Joints q = w.cell.arm.state().q;
  Planner planner{w,  memory, arrangement, Reach(arrangement, scene, *w.models.catalogue, w.options.motion),
                  {}, q};
  planner.plan.scene = std::move(scene);
  planner.plan.no_pick = memory.no_pick;
  std::visit(planner, action);
  w.seconds.planning += watch.seconds();
  if (!planner.plan.found) w.emit(MotionRefused{action, planner.plan.refusal});
  return std::move(planner.plan);
}

ExecutionResult execute(Workcell& w, const Action& action, const MotionPlan& plan, std::size_t stack_before,
                        Journal* journal) {
  if (const auto* view = std::get_if<LookAgain>(&action))
    w.emit(StoneSought{*view});
  else if (std::holds_alternative<Place>(action))
    w.emit(PlaceBegun{static_cast<int>(stack_before) + 1, plan.placement});
  else if (const auto* push = std::get_if<Push>(&action))
    w.emit(PushBegun{plan.placement.stone, difference(push->stone.T_W_O, plan.placement.T_W_O).translation});
  else
    w.emit(SetDownBegun{plan.placement, std::holds_alternative<Reorient>(action)});
  const double start = w.cell.clock.now();
  ExecutionResult done;
  if (std::holds_alternative<LookAgain>(action)) {
    w.emit(StepBegun{"move to a view"});
    const MotionResult moved = w.cell.arm.follow(plan.route);
    if (moved.status != MotionResult::Status::kDone)
      done = {ExecutionResult::Status::kStopped, moved.force, "on the route to a view: " + moved.reason};
  } else if (std::holds_alternative<Push>(action)) {
    done = execute_push(plan.pick_and_place, w.models.stone(plan.placement.stone), plan.scene, w.cell,
                        w.options.motion, journal);
  } else {
    done = execute(plan.pick_and_place, w.models.stone(plan.placement.stone), plan.scene, w.cell,
                   w.options.motion, journal,
                   w.options.measure_friction && std::holds_alternative<Place>(action) && stack_before == 0
                       ? LetGo::kDragged
                       : LetGo::kResting);
    if (done.friction) w.emit(FrictionMeasured{plan.placement.stone, *done.friction});
  }
  w.seconds.motion += w.cell.clock.now() - start;
  return done;
}

}  // namespace stonestack::stacking
