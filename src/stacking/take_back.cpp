#include "stacking/take_back.hpp"

#include <algorithm>
#include <limits>
#include <span>

#include "motion/timing.hpp"
#include "stacking/arrangement.hpp"
#include "stacking/plan_executor.hpp"
#include "stacking/record.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"

namespace stonestack::stacking {
namespace {

constexpr double kOnPath = 0.05;    // rad, of a joint: further away the path says nothing about what is free
constexpr double kPathStep = 0.01;  // rad, between points of the way back
constexpr double kSampleTime = 0.02;     // s, between the points that are compared with where the arm stands
constexpr double kSmallShare = 0.02;     // of a step that is as good as done
constexpr double kTakeBackSpeed = 0.25;  // m/s, of the tool; of reduced speed in ISO 10218-1

using Kind = PlanStep::Kind;

/// Place on the path of a plan.
struct OnPath {
  const PlanStep* step = nullptr;
  double time = 0.0;                                          ///< since the step began [s]
  double distance = std::numeric_limits<double>::infinity();  ///< of the joint that is furthest [rad]
};

/// Where the arm stands on the path of some steps. Of equal places the first.
OnPath nearest_on(std::span<const PlanStep> steps, const Joints& q) {
  OnPath nearest;
  for (const PlanStep& step : steps) {
    if (step.trajectory.q.empty()) continue;
    const double end = step.trajectory.duration();
    const int count = 1 + static_cast<int>(end / kSampleTime);
    for (int k = 0; k <= count; ++k) {
      const double time = end * k / count;
      const double distance = (sample(step.trajectory, time).q - q).cwiseAbs().maxCoeff();
      if (distance < nearest.distance) nearest = {&step, time, distance};
    }
  }
  return nearest;
}

/// Appends the path of a step between two times, in either direction.
void append(JointPath& path, const PlanStep& step, double from, double to) {
  const int count = 1 + static_cast<int>(std::abs(to - from) / kSampleTime);
  for (int k = 0; k <= count; ++k) {
    const Joints q = sample(step.trajectory, from + (to - from) * k / count).q;
    if ((q - path.back()).cwiseAbs().maxCoeff() >= kPathStep || (k == count && q != path.back()))
      path.push_back(q);
  }
}

/// The plan's first step of that kind; null: it has none.
const PlanStep* first_of(const PickAndPlacePlan& plan, Kind kind) {
  const auto found = std::find_if(plan.steps.begin(), plan.steps.end(),
                                  [&](const PlanStep& step) { return step.kind == kind; });
  return found == plan.steps.end() ? nullptr : &*found;
}

/// One plan that was broken off.
struct Leaving {
  Workcell& w;
  const PickAndPlacePlan& plan;
  const std::string& stone;
  PlanExecutor executor;
  Journal* journal;
  std::size_t lift, release;  ///< steps between which the stone is carried

  [[nodiscard]] std::span<const PlanStep> steps(std::size_t from, std::size_t to) const {
    return std::span(plan.steps).subspan(from, to - from);
  }
  [[nodiscard]] std::size_t index(const OnPath& at) const {
    return static_cast<std::size_t>(at.step - plan.steps.data());
  }

  [[nodiscard]] const PlanStep* first(Kind kind) const { return first_of(plan, kind); }

  [[nodiscard]] JointTrajectory timed(const JointPath& path) const {
    TimingLimits limits = timing_limits(executor.scene.robot, executor.options);
    limits.tool_speed = kTakeBackSpeed;
    return time_path(path, limits, executor.scene.robot, executor.scene.T_F_T);
  }
  void intend(const std::string& what) const { record(journal, StepBegun{what}); }
  /// Follows the path; the arm stands at its first point.
  void follow(const std::string& what, const JointPath& path) const {
    if (path.size() < 2) return;
    intend(what);
    const MotionResult moved = w.cell.arm.follow(timed(path));
    if (moved.status != MotionResult::Status::kDone)
      throw DeviceError("arm", concat("stopped on its way back: ", moved.reason),
                        concat("free the arm and take ", stone, " out of the gripper, then resume"));
  }
  static void check(const ExecutionResult& done) {
    if (done.status == ExecutionResult::Status::kStopped)
      throw DeviceError("arm", "stopped as it left a stone: " + done.reason, "free the arm, then resume");
  }

  /// The stone is held: back to the end of the lift, down, open, up.
  void take_back() const {
    const Joints q = w.cell.arm.state().q;
    const OnPath at = nearest_on(steps(lift, release), q);
    if (at.distance > kOnPath)
      throw DeviceError("gripper",
                        concat("holds ", stone, ", and the arm stands ", at.distance,
                               " rad beside the path that it followed"),
                        concat("take ", stone,
                               " out of the gripper and open it, put the stone into the field, then resume"));
    log_info(concat("the gripper holds ", stone, ": it goes back to where it was picked"));
    executor.set_payload(true);
    const PlanStep& up = plan.steps[lift];
    PlanStep below = up;  // the part of the lift that leads from the pick to where the arm is
    JointPath lifted{up.trajectory.q.front()};
    if (at.step == &up) {
      append(lifted, up, 0.0, at.time);
      if (lifted.size() < 2) return set_down_here();
      lifted.back() = q;
    } else {
      JointPath back{q};
      append(back, *at.step, at.time, 0.0);
      for (std::size_t k = index(at) - 1; k > lift; --k)
        if (!plan.steps[k].trajectory.q.empty())
          append(back, plan.steps[k], plan.steps[k].trajectory.duration(), 0.0);
      follow(concat("take ", stone, " back"), back);
      append(lifted, up, 0.0, up.trajectory.duration());
    }
    below.trajectory = timed(lifted);
    intend(concat("set ", stone, " down where it was picked"));
    check(executor.put_back(below, "the run was broken off"));
  }
  void set_down_here() const {
    intend(concat("let go of ", stone, " where it was picked"));
    executor.set_payload(false);
    check(executor.give_up(plan.steps[lift], "the run was broken off"));
  }

  /// Nothing is held: fingers that may stand around a stone open and withdraw.
  void withdraw() const {
    executor.set_payload(false);
    const Joints q = w.cell.arm.state().q;
    const OnPath at = nearest_on(plan.steps, q);
    if (at.distance > kOnPath) return;
    const std::size_t k = index(at);
    JointPath out{q};
    if (k == lift || (k < lift && at.step->kind == Kind::kApproach)) {
      intend(concat("open the fingers around ", stone));
      if (const auto* open = first(Kind::kOpen)) executor.open(*open);
      append(out, *at.step, at.time, k == lift ? at.step->trajectory.duration() : 0.0);
      return follow(concat("leave ", stone, " where it lies"), out);
    }
    const PlanStep* const retreat = first(Kind::kRetreat);
    if (at.step->kind == Kind::kDescent && retreat != nullptr) {
      intend(concat("let go of ", stone));
      if (w.cell.gripper.state().opening < plan.steps[release].opening) executor.open(plan.steps[release]);
      const PlanStep& wide = plan.steps[static_cast<std::size_t>(retreat - plan.steps.data()) - 1];
      if (wide.kind == Kind::kRelease) {
        check(executor.clear_table(wide, wide.opening));
        executor.open(wide);
      }
      return check(executor.retreat(*retreat));
    }
    if (at.step->kind != Kind::kRetreat) return;
    append(out, *at.step, at.time, at.step->trajectory.duration());
    follow(concat("leave ", stone), out);
  }

  /// A push was broken off: back along the way behind the stone, or on up, then the fingers open.
  void leave_push() const {
    const Joints q = w.cell.arm.state().q;
    const OnPath at = nearest_on(plan.steps, q);
    if (at.distance > kOnPath || at.step->kind == Kind::kTransit) return;
    if (at.step->kind == Kind::kRetreat) {
      // From where the arm stands: a stone that was felt early was left before the planned place.
      intend(concat("leave ", stone));
      double left = 1.0 - at.time / at.step->trajectory.duration();
      for (std::size_t k = index(at); k < plan.steps.size() && plan.steps[k].kind == Kind::kRetreat; ++k) {
        if (left > kSmallShare) check(executor.follow_from_here(plan.steps[k], left));
        left = 1.0;
      }
    } else {
      JointPath out{q};
      append(out, *at.step, at.time, 0.0);
      for (std::size_t k = index(at);
           k-- > 0 && (plan.steps[k].kind == Kind::kApproach || plan.steps[k].kind == Kind::kDescent);)
        append(out, plan.steps[k], plan.steps[k].trajectory.duration(), 0.0);
      follow(concat("leave ", stone), out);
    }
    executor.open(plan.steps.back());
  }
};

}  // namespace

bool leave_motion(Workcell& w, const WorldEstimate& world, const RunMemory& memory,
                  const PickAndPlacePlan* plan, Journal* journal) {
  const bool holds = w.cell.gripper.state().object;
  const PlanStep* const lift = plan == nullptr ? nullptr : first_of(*plan, Kind::kLift);
  const PlanStep* const release = plan == nullptr ? nullptr : first_of(*plan, Kind::kRelease);
  const bool pushes = memory.attempt && plan != nullptr && !plan->steps.empty() && !holds &&
                      std::holds_alternative<Push>(memory.attempt->action);
  if (!pushes && (!memory.attempt || lift == nullptr || release == nullptr || release < lift)) {
    if (holds)
      throw DeviceError("gripper", "holds something, and the run was not bringing a stone anywhere",
                        "take it out of the gripper and open it, then resume");
    return false;
  }
  const PlanningScene scene =
      make_planning_scene(w.cell.layout, *w.models.robot, *w.models.catalogue, at_rest(world));
  const StoneIndex stone = memory.attempt->placement.stone;
  const Leaving leaving{w,
                        *plan,
                        w.models.name(stone),
                        {*plan, w.models.stone(stone), scene, w.cell, w.options.motion, journal},
                        journal,
                        pushes ? 0 : static_cast<std::size_t>(lift - plan->steps.data()),
                        pushes ? 0 : static_cast<std::size_t>(release - plan->steps.data())};
  const double start = w.cell.clock.now();
  if (pushes)
    leaving.leave_push();
  else if (holds)
    leaving.take_back();
  else
    leaving.withdraw();
  w.seconds.motion += w.cell.clock.now() - start;
  return holds;
}

}  // namespace stonestack::stacking
