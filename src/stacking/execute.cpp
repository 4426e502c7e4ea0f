#include "stonestack/stacking/execute.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "stacking/hand_load.hpp"
#include "stacking/way_back.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/kinematics/forward.hpp"
#include "stonestack/motion/cartesian.hpp"
#include "stonestack/motion/timing.hpp"

namespace stonestack {
namespace {

constexpr double kRetreatSpeed = 0.05;  // m/s: slow, the fingers leave the stone
constexpr double kStrokeSpeed = 0.06;   // m/s, of the fingers when the plan names none
constexpr double kFingerForce = 60.0;   // N, when the plan names none
constexpr double kGravity = 9.81;       // m/s^2
// A stone slips towards the finger tips by up to 2 mm while it is carried, so the hand ends lower than
// planned: this near the table it goes back a little, with the stone loose, before fingers open into the
// table.
constexpr double kNearTable = 0.010;  // m, of the tool's tip
constexpr double kBackOff = 0.004;    // m
constexpr double kOffTable = 0.001;   // m, between finger tips that have felt the table and where they close

using Status = ExecutionResult::Status;

/// Carries one plan through.
struct Hands {
  const PickAndPlacePlan& plan;
  const Stone& stone;
  const PlanningScene& scene;
  Cell& cell;
  const MotionOptions& options;
  Journal* journal;
  double hangs = 0.0;  ///< N, when the stone was carried last
  Wrist wrist{cell, scene.robot, sensed_hand(scene.gripper, cell.layout)};

  void intend(const PlanStep& step) const {
    if (journal != nullptr) journal->record("step", concat("{\"name\": \"", step.name, "\"}"));
  }

  [[nodiscard]] Eigen::Vector3d p_F(const Eigen::Vector3d& p_T) const { return cell.layout.T_F_T * p_T; }

  /// Mass and centre of mass of the hand alone, or with the stone in it.
  void set_payload(bool holding) const {
    const HandMass hand = carried_hand(scene.gripper, cell.layout);
    const HandMass held{stone.mass.mass, p_F(plan.T_O_T.inverse() * stone.mass.p_O_M)};
    stonestack::set_payload(cell.arm, holding ? together(hand, held) : hand);
  }

  [[nodiscard]] ExecutionResult follow(const PlanStep& step) const {
    const MotionResult moved = cell.arm.follow(step.trajectory);
    if (moved.status == MotionResult::Status::kDone) return {};
    return {Status::kStopped, moved.force, step.name + ": " + moved.reason};
  }

  [[nodiscard]] ExecutionResult grasp(const PlanStep& step) const {
    const double speed = step.finger_speed > 0 ? step.finger_speed : kStrokeSpeed;
    try {
      const GripperState held = cell.gripper.move(0.0, speed, step.force > 0 ? step.force : kFingerForce);
      if (!held.object) return give_up(step, "the fingers closed on nothing");
      set_payload(true);
    } catch (const DeviceError& problem) {  // jammed, or refused: the arm has not moved, so opening is safe
      return give_up(step, problem.what());
    }
    return {};
  }

  /// Opens and goes back out, so that the next look starts free.
  [[nodiscard]] ExecutionResult give_up(const PlanStep& step, const std::string& why) const {
    cell.gripper.move(scene.gripper.largest_opening, kStrokeSpeed, kFingerForce);
    const ExecutionResult back = go_back(step, options.approach);
    if (back.status == Status::kStopped) return back;
    return {Status::kNotPicked, 0.0, why};
  }

  /// What the wrist says of the stone that hangs in the hand, against what should hang there: its weight, and
  /// where it pulls.
  [[nodiscard]] ExecutionResult check_hold(const PlanStep& lift) const {
    const WristLoad load = wrist.feel();
    const double expected = kGravity * stone.mass.mass;
    const double off = swing(load);
    if (journal != nullptr)
      journal->record("hold", concat("{\"weight\": ", load.weight, ", \"expected\": ", expected,
                                     ", \"off\": ", off, "}"));
    if (load.weight < options.least_held * expected) {
      const std::string why =
          concat("slipped out of the hand: ", load.weight, " N hang there, not ", expected, " N");
      // What still hangs is set down; what lies below already must not be met from above.
      return load.weight > kEmptyHand * expected ? put_back(lift, why) : let_go(why);
    }
    if (off > options.largest_swing) return put_back(lift, turned(off));
    return {};
  }

  /// m: how far from where the stone's centre of mass is in the hand, held as planned, it pulls.
  [[nodiscard]] double swing(const WristLoad& load) const {
    return beside(load, p_F(plan.T_O_T.inverse() * stone.mass.p_O_M));
  }

  [[nodiscard]] static std::string turned(double off) {
    return concat("turned in the hand: it pulls ", std::lround(1e3 * off), " mm beside where it should");
  }

  /// Before the hand goes nearer to the tower: a stone that is gone is not set down. `lift` is the step that
  /// was followed last before the carry, or null if nothing was lifted.
  [[nodiscard]] ExecutionResult check_carried(const PlanStep* lift, const PlanStep& next) {
    if (lift == nullptr) return {};
    const double expected = kGravity * stone.mass.mass;
    const CarriedLoad carried = feel_carried(wrist, cell, expected, options.least_held);
    const double off = swing(carried.load);
    hangs = carried.load.weight;
    if (journal != nullptr)
      journal->record("carried", concat("{\"weight\": ", hangs, ", \"expected\": ", expected,
                                        ", \"off\": ", off, ", \"doubt\": ", carried.load.doubt,
                                        ", \"held\": ", carried.held ? "true" : "false", "}"));
    // What has swung would not come to stand where it is let go of.
    if (carried.held && off > options.largest_swing + carried.load.doubt) {
      const ExecutionResult home = go_home({lift + 1, &next});
      return home.status == Status::kStopped ? home : put_back(*lift, turned(off));
    }
    if (carried.held) return {};
    set_payload(false);
    const ExecutionResult home = go_home({lift + 1, &next});
    if (home.status == Status::kStopped) return home;
    cell.gripper.move(scene.gripper.largest_opening, kStrokeSpeed, kFingerForce);
    return {Status::kLost, 0.0,
            concat("lost on the way: ", hangs, " N hang in the hand, not ", expected, " N")};
  }

  /// To where the carry began, the way it came: of all ways that one is known to be free. An empty hand's
  /// fingers open there and not over the tower.
  [[nodiscard]] ExecutionResult go_home(std::span<const PlanStep> carried) const {
    for (auto step = carried.rbegin(); step != carried.rend(); ++step) {
      PlanStep back = *step;
      back.trajectory = reversed(step->trajectory);
      const ExecutionResult moved = follow(back);
      if (moved.status == Status::kStopped) return moved;
    }
    return {};
  }

  /// Opens where the hand is.
  [[nodiscard]] ExecutionResult let_go(const std::string& why) const {
    cell.gripper.move(scene.gripper.largest_opening, kStrokeSpeed, kFingerForce);
    set_payload(false);
    return {Status::kNotPicked, 0.0, why};
  }

  /// Down again the way it was lifted, until it touches; then lets go.
  [[nodiscard]] ExecutionResult put_back(const PlanStep& lift, const std::string& why) const {
    GuardedMotion down;
    down.trajectory = reversed(lift.trajectory);
    down.threshold = options.early_threshold;
    const MotionResult moved = cell.arm.follow_guarded(down);
    if (moved.status != MotionResult::Status::kContact && moved.status != MotionResult::Status::kNoContact)
      return {Status::kStopped, moved.force, "putting " + stone.name + " back: " + moved.reason};
    // Fingers that stand on the table cannot open.
    if (const ExecutionResult up = go_back(lift, kBackOff); up.status == Status::kStopped) return up;
    set_payload(false);
    return give_up(lift, why);
  }

  /// m, W.
  [[nodiscard]] Eigen::Vector3d tip(const Joints& q) const {
    return (cell.layout.T_W_R * forward(scene.robot, q) * scene.T_F_T).translation();
  }

  /// m, that the tool stands above where the step would have ended.
  [[nodiscard]] double above_end(const PlanStep& step) const {
    if (step.trajectory.q.empty()) return 0.0;
    return (tip(cell.arm.state().q) - tip(step.trajectory.q.back())).z();
  }

  /// To a grasp that brings the finger tips nearer to the table than the arm is exact: slowly, and what is
  /// met ends it. Fingers that stand on the table cannot close, so they are lifted a little then.
  [[nodiscard]] ExecutionResult feel_table(const PlanStep& step) const {
    GuardedMotion motion;
    motion.trajectory = step.trajectory;
    motion.threshold = step.threshold;
    const JointPath& way = step.trajectory.q;
    if (way.size() > 1) motion.n_W_direction = (tip(way.back()) - tip(way.front())).normalized();
    const MotionResult moved = cell.arm.follow_guarded(motion);
    if (moved.status == MotionResult::Status::kNoContact) return {};
    if (moved.status != MotionResult::Status::kContact)
      return {Status::kStopped, moved.force, step.name + ": " + moved.reason};
    if (journal != nullptr)
      journal->record("touch", concat("{\"touched\": true, \"force\": ", moved.force,
                                      ", \"above_end_m\": ", above_end(step), "}"));
    return go_back(step, kOffTable);
  }

  /// Down until the wrist feels something (paper §4.1: impact on the force-torque sensor). `touched` tells
  /// whether it did: above the guarded descent that means a stone that hangs otherwise than planned.
  [[nodiscard]] ExecutionResult feel_down(const PlanStep& step, bool* touched) const {
    GuardedMotion motion;
    motion.trajectory = step.trajectory;
    motion.threshold = step.threshold;
    const MotionResult moved = cell.arm.follow_guarded(motion);
    *touched = moved.status == MotionResult::Status::kContact;
    if (journal != nullptr)
      journal->record("touch", concat("{\"touched\": ", *touched ? "true" : "false", ", \"force\": ",
                                      moved.force, ", \"above_end_m\": ", above_end(step), "}"));
    if (*touched || moved.status == MotionResult::Status::kNoContact)
      return {Status::kReleased, moved.force, ""};
    return {Status::kStopped, moved.force, step.name + ": " + moved.reason};
  }

  void open(const PlanStep& step) const {
    cell.gripper.move(step.opening, step.finger_speed > 0 ? step.finger_speed : kStrokeSpeed, kFingerForce);
  }

  /// Out of the hand's own direction, from where the arm really stands, as far as the plan found room.
  [[nodiscard]] ExecutionResult retreat(const PlanStep& step) const {
    const JointPath& way = step.trajectory.q;
    if (way.empty()) return go_back(step, options.approach);
    const Pose T_R_T_from = forward(scene.robot, way.front()) * scene.T_F_T;
    const Pose T_R_T_to = forward(scene.robot, way.back()) * scene.T_F_T;
    return go_back(step, difference(T_R_T_from, T_R_T_to).translation);
  }

  /// Fingers that have opened may still have the stone: stuck, jammed between two, or wedged. What is felt
  /// counts, as a gripper only tells of an object that it closes on. `may_open`: as wide as it goes, once.
  [[nodiscard]] ExecutionResult check_empty(const PlanStep& step, bool may_open) const {
    const double most = most_in_empty_hand(kGravity * stone.mass.mass);
    double left = wrist.feel().weight;
    const auto empty = [&] { return left <= most && !cell.gripper.state().object; };
    if (!empty() && may_open) {
      cell.gripper.move(scene.gripper.largest_opening, kStrokeSpeed, kFingerForce);
      left = wrist.feel().weight;
    }
    if (journal != nullptr)
      journal->record("released", concat("{\"left\": ", left, ", \"most\": ", most, "}"));
    if (empty()) return {};
    set_payload(true);
    return {Status::kStopped, 0.0,
            concat(step.name, ": the hand is not empty after release, ", left, " N hang in it; take ",
                   stone.name, " out of the fingers")};
  }

  [[nodiscard]] ExecutionResult clear_table(const PlanStep& step) const {
    const Pose T_R_T = forward(scene.robot, cell.arm.state().q) * scene.T_F_T;
    if ((cell.layout.T_W_R * T_R_T).translation().z() > kNearTable) return {};
    return go_back(step, kBackOff);
  }

  [[nodiscard]] ExecutionResult go_back(const PlanStep& step, double distance) const {
    const Joints q = cell.arm.state().q;
    const Pose T_R_T = forward(scene.robot, q) * scene.T_F_T;
    const Pose T_R_T_goal = T_R_T * Eigen::Translation3d(0, 0, -distance);
    const auto path = straight_path(scene.robot, scene.T_F_T, q, T_R_T_goal);
    if (!path) return {Status::kStopped, 0.0, step.name + ": no straight way back"};
    TimingLimits limits = timing_limits(scene.robot, options);
    limits.tool_speed = kRetreatSpeed;
    PlanStep actual = step;
    actual.trajectory = time_path(*path, limits, scene.robot, scene.T_F_T);
    return follow(actual);
  }
};

/// The hand is still empty.
bool leads_to_grasp(const PickAndPlacePlan& plan, const PlanStep& step) {
  return std::any_of(plan.steps.data() + (&step - plan.steps.data()), plan.steps.data() + plan.steps.size(),
                     [](const PlanStep& later) { return later.kind == PlanStep::Kind::kGrasp; });
}

}  // namespace

ExecutionResult execute(const PickAndPlacePlan& plan, const Stone& stone, const PlanningScene& scene,
                        Cell& cell, const MotionOptions& options, Journal* journal) {
  Hands hands{plan, stone, scene, cell, options, journal};
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

}  // namespace stonestack
