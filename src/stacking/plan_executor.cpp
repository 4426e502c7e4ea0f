#include "stacking/plan_executor.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/constants.hpp"
#include "motion/cartesian.hpp"
#include "motion/collision.hpp"
#include "motion/constants.hpp"
#include "motion/grasp/finger_reach.hpp"
#include "motion/timing.hpp"
#include "stacking/back_away.hpp"
#include "stacking/constants.hpp"
#include "stacking/gripper_motion.hpp"
#include "stacking/record.hpp"
#include "stacking/reversed_trajectory.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::stacking {
namespace {

constexpr double kRetreatSpeed = 0.05;  // m/s: slow, the fingers leave the stone
constexpr double kSpeedBack = 0.25;     // m/s, from where a stone was lost
constexpr double kStrokeSpeed = 0.06;   // m/s, of the fingers when the plan names none
constexpr double kFingerForce = 60.0;   // N, when the plan names none
// A stone slips towards the finger tips by up to 2 mm while it is carried, so the gripper ends lower than
// planned: this near the table it goes back a little, with the stone loose, before fingers open into the
// table.
constexpr double kNearTable = 0.010;   // m, of the tool's tip
constexpr double kBackOff = 0.004;     // m
constexpr double kMinUpright = 0.3;    // cosine of the gripper's inclination, at least, for a way back
constexpr double kFarAbove = 1.0;      // m above the table: no finger is there
constexpr double kTableReach = 0.006;  // m above the end of an approach: what is met lower is the table
constexpr std::array kSharesBack{1.0, 0.75, 0.5, 0.25};  // of the way back that was asked for
constexpr double kAsPlanned = 0.005;  // rad, half of what the arm allows at the start of a motion
constexpr double kLightest = 0.3;     // N: less is not told from an empty gripper
// Less of a stone's weight than this [N, and of all] is not told from how the wrist errs while it is lowered.
constexpr double kBorne = 1.0, kBorneShare = 0.05;
constexpr double kRaised =
    0.3;  // of the way on which it was lowered, to see whether it then weighs as before
constexpr double kOffTable = 0.001;   // m, between finger tips that have felt the table and where they close
constexpr double kDrawnOut = 0.15;    // m that level fingers are drawn out further from beneath a stone, ...
constexpr int kDrawnParts = 5;        // ... in so many parts
constexpr double kFullyOpen = 0.003;  // m, of the opening: fingers so near to their end were stopped by it

using Status = ExecutionResult::Status;

}  // namespace

void PlanExecutor::intend(const PlanStep& step) const {
  record(journal, StepBegun{step.name});
}

GripperMass PlanExecutor::load(bool holding) const {
  const GripperMass gripper = carried_gripper_mass(scene.gripper, cell.layout);
  const GripperMass held{mass, p_F(plan.T_O_T.inverse() * stone.mass.p_O_M)};
  return holding ? together(gripper, held) : gripper;
}

void PlanExecutor::set_payload(bool holding) const {
  stacking::set_payload(cell.arm, load(holding));
}

ExecutionResult PlanExecutor::follow(const PlanStep& step) const {
  const MotionResult moved = cell.arm.follow(step.trajectory);
  if (moved.status == MotionResult::Status::kDone) return {};
  return {Status::kStopped, moved.force, step.name + ": " + moved.reason};
}

ExecutionResult PlanExecutor::carry(const PlanStep& lift, const PlanStep& step) const {
  const MotionResult moved = cell.arm.carry(step.trajectory);
  if (moved.status == MotionResult::Status::kDone) return {};
  if (moved.status != MotionResult::Status::kDropped)
    return {Status::kStopped, moved.force, step.name + ": " + moved.reason};
  const double weight = wrist.feel().weight, expected = kGravity * mass;
  const bool empty = weight < max_in_empty_gripper(expected);
  record(journal, CarriedMeasured{weight, expected, 0.0, 0.0, !empty});
  if (empty) set_payload(false);
  record(journal, StepBegun{concat("go back with ", stone.name, ", which the gripper no longer reports")});
  PlanStep back = step;
  back.trajectory = timed(way_back(step.trajectory, cell.arm.state().q), kSpeedBack);
  if (const auto home = follow(back); home.status == Status::kStopped) return home;
  if (const auto home = go_home({&lift + 1, &step}); home.status == Status::kStopped) return home;
  const std::string why = concat(moved.reason, ", and the wrist measures ", weight, " N");
  if (!empty) return put_back(lift, "uncertain in transit: " + why);
  const ExecutionResult opened = release("lost in transit: " + why);
  return {Status::kLost, 0.0, opened.reason};
}

ExecutionResult PlanExecutor::lift(const PlanStep& step) const {
  const JointPath& route = step.trajectory.q;
  const Joints q = cell.arm.state().q;
  if (route.empty() || (q - route.front()).cwiseAbs().maxCoeff() < kAsPlanned) return follow(step);
  return straight_to(step, route.back());
}

ExecutionResult PlanExecutor::grasp(const PlanStep& step) const {
  const double speed = step.finger_speed > 0 ? step.finger_speed : kStrokeSpeed;
  try {
    const GripperState held = cell.gripper.move(0.0, speed, step.force > 0 ? step.force : kFingerForce);
    if (!held.object) return give_up(step, "the fingers closed on nothing");
  } catch (const DeviceError& problem) {  // jammed: the arm has not moved, so opening is safe
    return give_up(step, problem.what());
  }
  const std::string refusal = take_payload();
  return refusal.empty() ? ExecutionResult{} : give_up(step, refusal);
}

std::string PlanExecutor::take_payload() const {
  const GripperMass carried = load(true);
  try {
    cell.arm.set_payload(carried.mass, carried.p_F_gripper);
  } catch (const InvalidArgument& refusal) {
    return refusal.what();
  }
  return {};
}

ExecutionResult PlanExecutor::give_up(const PlanStep& step, const std::string& why) const {
  move_gripper(cell, journal, scene.gripper.max_opening, kStrokeSpeed, kFingerForce);
  const ExecutionResult back = go_back(step, options.approach);
  if (back.status == Status::kStopped) return back;
  return {Status::kNotPicked, 0.0, why};
}

ExecutionResult PlanExecutor::check_hold(const PlanStep& lift) {
  const WristLoad load = wrist.feel();
  std::string refusal;
  if (weighs && load.weight > kLightest && cell.gripper.state().object) {
    mass = load.weight / kGravity;
    refusal = take_payload();
  }
  const double expected = kGravity * mass;
  const double off = swing(load);
  record(journal, HoldMeasured{load.weight, expected, off});
  if (load.weight < kMinHeldShare * expected) {
    const std::string why =
        concat("slipped out of the gripper: it holds ", load.weight, " N, not ", expected, " N");
    // A stone that is still held is set down, also where the wrist alone does not feel it; one that lies
    // below must not be hit from above.
    const bool reported = cell.gripper.state().object;
    const bool held = load.weight > kEmptyGripper * expected || reported;
    ExecutionResult back = held ? put_back(lift, why) : release(why);
    if (reported && load.weight > kLightest) back.weight = load.weight;
    return back;
  }
  if (off > kMaxSwing || !refusal.empty()) {
    ExecutionResult back = put_back(lift, refusal.empty() ? turned(off) : refusal);
    if (weighs) back.weight = load.weight;
    return back;
  }
  ExecutionResult held;
  held.weight = load.weight;
  return held;
}

double PlanExecutor::swing(const WristLoad& load) const {
  return beside(load, p_F(plan.T_O_T.inverse() * stone.mass.p_O_M));
}

std::string PlanExecutor::turned(double off) {
  return concat("turned in the gripper: its load acts ", std::lround(1e3 * off),
                " mm beside the planned point");
}

ExecutionResult PlanExecutor::check_carried(const PlanStep* lift, const PlanStep& next,
                                            const PlanStep* lowering, bool* rests) {
  if (lift == nullptr) return {};
  const double least = (1.0 - kBorneShare) * carried_weight - kBorne;  // of what nothing below bears
  const double expected = kGravity * mass;
  const CarriedLoad carried = feel_carried(wrist, cell, expected, kMinHeldShare);
  const double off = swing(carried.load);
  carried_weight = carried.load.weight;
  record(journal, CarriedMeasured{carried_weight, expected, off, carried.load.uncertainty, carried.held});
  if (lowering != nullptr && carried_weight < least && (carried.held || reports_object_at_rest(cell))) {
    record(journal, StepBegun{concat("raise ", stone.name, ", which weighs less once it is lowered")});
    if (const ExecutionResult up = follow_from_here(*lowering, -kRaised); up.status == Status::kStopped)
      return up;
    const double raised = wrist.feel().weight;
    *rests = raised > least;
    if (*rests) {
      carried_weight = raised;
      return {};
    }
    const ExecutionResult down = straight_to(*lowering, lowering->trajectory.q.back());
    if (down.status == Status::kStopped) return down;
  }
  // What has swung would not come to stand where it is let go of.
  if (carried.held && off > kMaxSwing + carried.load.uncertainty) {
    const ExecutionResult home = go_home({lift + 1, &next});
    return home.status == Status::kStopped ? home : put_back(*lift, turned(off));
  }
  if (carried.held) return {};
  // A wrist that has failed measures nothing either: what the fingers still hold is not dropped.
  const bool reported = reports_object_at_rest(cell);
  if (!reported) set_payload(false);
  const ExecutionResult home = go_home({lift + 1, &next});
  if (home.status == Status::kStopped) return home;
  const std::string measured = concat("the wrist measures ", carried_weight, " N, not ", expected, " N");
  if (reported && reports_object_at_rest(cell))
    return put_back(*lift, concat("uncertain in transit: the gripper reports an object, and ", measured));
  const ExecutionResult opened = release("lost in transit: " + measured);
  return {Status::kLost, 0.0, opened.reason};
}

ExecutionResult PlanExecutor::go_home(std::span<const PlanStep> carried) const {
  for (auto step = carried.rbegin(); step != carried.rend(); ++step) {
    PlanStep back = *step;
    back.trajectory = reversed(step->trajectory);
    const ExecutionResult moved = follow(back);
    if (moved.status == Status::kStopped) return moved;
  }
  return {};
}

ExecutionResult PlanExecutor::release(const std::string& why) const {
  move_gripper(cell, journal, scene.gripper.max_opening, kStrokeSpeed, kFingerForce);
  set_payload(false);
  return {Status::kNotPicked, 0.0, why};
}

ExecutionResult PlanExecutor::put_back(const PlanStep& lift, const std::string& why) const {
  // A stone that has swung may hang low, and be met anywhere on the way.
  const JointPath way(lift.trajectory.q.rbegin(), lift.trajectory.q.rend());
  GuardedMotion down;
  if (!way.empty()) down.trajectory = timed(way, std::min(options.approach_speed, motion::kGuardedSpeed));
  down.threshold = options.early_threshold;
  const MotionResult moved = cell.arm.follow_guarded(down);
  if (moved.status != MotionResult::Status::kContact && moved.status != MotionResult::Status::kNoContact)
    return {Status::kStopped, moved.force, "putting " + stone.name + " back: " + moved.reason};
  // Fingers that stand on the table cannot open.
  if (const ExecutionResult up = go_back(lift, kBackOff); up.status == Status::kStopped) return up;
  set_payload(false);
  return give_up(lift, why);
}

Eigen::Vector3d PlanExecutor::tip(const Joints& q) const {
  return (cell.layout.T_W_R * forward(scene.robot, q) * scene.T_F_T).translation();
}

double PlanExecutor::above_end(const PlanStep& step) const {
  if (step.trajectory.q.empty()) return 0.0;
  return (tip(cell.arm.state().q) - tip(step.trajectory.q.back())).z();
}

double PlanExecutor::held_opening() const {
  const auto grasp = std::find_if(plan.steps.begin(), plan.steps.end(),
                                  [](const PlanStep& step) { return step.kind == PlanStep::Kind::kGrasp; });
  return grasp == plan.steps.end() ? 0.0 : grasp->opening;
}

double PlanExecutor::closing_advance() const {
  const auto open = std::find_if(plan.steps.begin(), plan.steps.end(),
                                 [](const PlanStep& step) { return step.kind == PlanStep::Kind::kOpen; });
  if (open == plan.steps.end()) return 0.0;
  return furthest_tip(scene.gripper, held_opening(), open->opening) -
         tip_advance(scene.gripper, open->opening);
}

ExecutionResult PlanExecutor::approach_grasp(const PlanStep& step) const {
  GuardedMotion motion;
  motion.trajectory = step.trajectory;
  motion.threshold = step.threshold;
  const JointPath& route = step.trajectory.q;
  if (route.size() > 1) motion.n_W_direction = (tip(route.back()) - tip(route.front())).normalized();
  const MotionResult moved = cell.arm.follow_guarded(motion);
  if (moved.status == MotionResult::Status::kNoContact) return {};
  if (moved.status != MotionResult::Status::kContact)
    return {Status::kStopped, moved.force, step.name + ": " + moved.reason};
  const double above = above_end(step);
  record(journal, TouchMeasured{true, moved.force, above});
  if (above <= kTableReach) return go_back(step, kOffTable + closing_advance());
  const double done = route.empty() ? 0.0 : (tip(cell.arm.state().q) - tip(route.front())).norm();
  const ExecutionResult back = go_back(step, done);
  if (back.status == Status::kStopped) return back;
  return {Status::kNotPicked, moved.force,
          concat("a finger met something ", std::lround(1e3 * above), " mm above the grasp")};
}

ExecutionResult PlanExecutor::feel_down(const PlanStep& step, bool* touched) const {
  GuardedMotion motion;
  motion.trajectory = step.trajectory;
  motion.threshold = step.threshold;
  const MotionResult moved = cell.arm.follow_guarded(motion);
  *touched = moved.status == MotionResult::Status::kContact;
  record(journal, TouchMeasured{*touched, moved.force, above_end(step)});
  if (*touched || moved.status == MotionResult::Status::kNoContact)
    return {Status::kReleased, moved.force, ""};
  return {Status::kStopped, moved.force, step.name + ": " + moved.reason};
}

ExecutionResult PlanExecutor::feel_down_from_here(const PlanStep& step, bool* touched) const {
  const Pose T_R_T = forward(scene.robot, step.trajectory.q.back()) * scene.T_F_T;
  const auto path = straight_path(scene.robot, scene.T_F_T, cell.arm.state().q, T_R_T);
  if (!path) return {Status::kStopped, 0.0, step.name + ": no straight path from where the arm stands"};
  PlanStep actual = step;
  actual.trajectory = timed(*path, options.descent_speed);
  return feel_down(actual, touched);
}

void PlanExecutor::open(const PlanStep& step) const {
  move_gripper(cell, journal, step.opening, step.finger_speed > 0 ? step.finger_speed : kStrokeSpeed,
               kFingerForce);
}

double PlanExecutor::retreat_length(const PlanStep& step) const {
  const JointPath& route = step.trajectory.q;
  if (route.empty()) return options.approach;
  const Pose T_R_T_from = forward(scene.robot, route.front()) * scene.T_F_T;
  const Pose T_R_T_to = forward(scene.robot, route.back()) * scene.T_F_T;
  return difference(T_R_T_from, T_R_T_to).translation;
}

ExecutionResult PlanExecutor::retreat(const PlanStep& step) const {
  return go_back(step, retreat_length(step));
}

bool PlanExecutor::reports_object_between() const {
  const GripperState now = cell.gripper.state();
  return now.object && now.opening < scene.gripper.max_opening - kFullyOpen;
}

ExecutionResult PlanExecutor::check_empty(const PlanStep& step, bool may_open) const {
  const double max = max_in_empty_gripper(kGravity * mass);
  double left = wrist.feel().weight;
  const auto empty = [&] { return left <= max && !reports_object_between(); };
  if (!empty() && may_open) {
    if (const ExecutionResult opened = open_wide(step); opened.status != Status::kReleased) return opened;
    left = wrist.feel().weight;
  }
  record(journal, ReleaseMeasured{left, max});
  if (empty()) return {};
  set_payload(true);
  return {Status::kStopped, 0.0,
          concat(step.name, ": the gripper is not empty after release, it holds ", left, " N; take ",
                 stone.name, " out of the fingers")};
}

ExecutionResult PlanExecutor::leave_empty(const PlanStep& step, bool over_table) const {
  const ExecutionResult first = check_empty(step, false);
  if (first.status != Status::kStopped) return first;
  record(journal, StepBegun{concat("set ", stone.name, " down once more, which hangs on the fingers")});
  const auto path = straight_path(scene.robot, scene.T_F_T, cell.arm.state().q,
                                  forward(scene.robot, cell.arm.state().q) * scene.T_F_T *
                                      Eigen::Translation3d(0, 0, retreat_length(step)));
  if (!path) return first;
  GuardedMotion down;
  // Fingers may be as low as a stone that hangs askew.
  down.trajectory = timed(*path, options.descent_speed);
  down.threshold = options.early_threshold;
  const MotionResult moved = cell.arm.follow_guarded(down);
  if (moved.status != MotionResult::Status::kContact && moved.status != MotionResult::Status::kNoContact)
    return {Status::kStopped, moved.force, concat("setting ", stone.name, " down once more: ", moved.reason)};
  record(journal, TouchMeasured{moved.status == MotionResult::Status::kContact, moved.force,
                                (tip(cell.arm.state().q) - tip(path->back())).z()});
  set_payload(false);
  if (const ExecutionResult opened = open_wide(step); opened.status != Status::kReleased) return opened;
  const ExecutionResult back = retreat(step);
  if (back.status != Status::kReleased) return back;
  const ExecutionResult second = check_empty(step, false);
  return second.status == Status::kStopped && over_table ? draw_out(step, second) : second;
}

ExecutionResult PlanExecutor::draw_out(const PlanStep& step, const ExecutionResult& not_empty) const {
  record(journal, StepBegun{concat("draw the fingers out from beneath ", stone.name)});
  CollisionRules rules;
  rules.opening = present_opening(cell, scene.gripper);
  for (std::size_t k = 0; k < scene.objects.size(); ++k)
    if (scene.objects[k].name == stone.name) rules.left_out = static_cast<int>(k);
  const CollisionChecker checker(scene, rules);
  for (int part = 0; part < kDrawnParts; ++part) {
    const Joints q = cell.arm.state().q;
    const auto path = straight_path(
        scene.robot, scene.T_F_T, q,
        forward(scene.robot, q) * scene.T_F_T * Eigen::Translation3d(0, 0, -kDrawnOut / kDrawnParts));
    if (!path || !is_free(checker, *path)) break;
    if (const ExecutionResult drawn = follow_slowly(step, *path); drawn.status != Status::kReleased)
      return drawn;
    if (check_empty(step, false).status != Status::kReleased) continue;
    set_payload(false);
    return {};
  }
  return not_empty;
}

double PlanExecutor::lowest_finger(double opening) const {
  const Pose T_W_T = cell.layout.T_W_R * forward(scene.robot, cell.arm.state().q) * scene.T_F_T;
  double lowest = kFarAbove;
  for (const GripperBox& box : scene.gripper.boxes) {
    if (box.finger_side == 0.0) continue;
    const Eigen::Vector3d p_W = T_W_T * box_centre(scene.gripper, box, opening);
    lowest = std::min(lowest, p_W.z() - 0.5 * T_W_T.linear().row(2).cwiseAbs().dot(box.size));
  }
  return lowest;
}

ExecutionResult PlanExecutor::clear_table(const PlanStep& step, double opening) const {
  const Pose T_R_T = forward(scene.robot, cell.arm.state().q) * scene.T_F_T;
  const double tip_z = furthest_tip(scene.gripper, held_opening(), opening);
  if ((cell.layout.T_W_R * T_R_T * Eigen::Vector3d(0, 0, tip_z)).z() > kNearTable) return {};
  return go_back(step, kBackOff);
}

ExecutionResult PlanExecutor::clear_table_empty(const PlanStep& step, double opening) const {
  const Pose T_W_T = cell.layout.T_W_R * forward(scene.robot, cell.arm.state().q) * scene.T_F_T;
  const double tip_z = furthest_tip(scene.gripper, 0.0, opening);
  const double upright = std::max(kMinUpright, -T_W_T.linear()(2, 2));
  const double low = std::min((T_W_T * Eigen::Vector3d(0, 0, tip_z)).z(), lowest_finger(opening));
  return low > kNearTable ? ExecutionResult{} : go_back(step, (kNearTable - low) / upright);
}

ExecutionResult PlanExecutor::open_wide(const PlanStep& step) const {
  const ExecutionResult clear = clear_table(step, scene.gripper.max_opening);
  if (clear.status == Status::kReleased && lowest_finger(scene.gripper.max_opening) > 0.0)
    move_gripper(cell, journal, scene.gripper.max_opening, kStrokeSpeed, kFingerForce);
  return clear;
}

ExecutionResult PlanExecutor::go_back(const PlanStep& step, double distance) const {
  const Joints q = cell.arm.state().q;
  const Pose T_R_T = forward(scene.robot, q) * scene.T_F_T;
  std::optional<JointPath> path;  // shorter where the arm cannot follow the whole line
  for (std::size_t k = 0; !path && k < kSharesBack.size(); ++k)
    path = straight_path(scene.robot, scene.T_F_T, q,
                         T_R_T * Eigen::Translation3d(0, 0, -kSharesBack[k] * distance));
  if (!path) return {Status::kStopped, 0.0, step.name + ": no straight path back"};
  return follow_slowly(step, *path);
}

ExecutionResult PlanExecutor::follow_slowly(const PlanStep& step, const JointPath& path) const {
  PlanStep actual = step;
  actual.trajectory = timed(path, kRetreatSpeed);
  return follow(actual);
}

JointTrajectory PlanExecutor::timed(const JointPath& path, double tool_speed) const {
  TimingLimits limits = timing_limits(scene.robot, options);
  limits.tool_speed = tool_speed;
  return time_path(path, limits, scene.robot, scene.T_F_T);
}

std::optional<JointPath> PlanExecutor::path_from_here(const PlanStep& step, double share) const {
  const Joints q = cell.arm.state().q;
  const JointPath& route = step.trajectory.q;
  const Eigen::Vector3d p_R_shift =
      share * (cell.layout.T_W_R.linear().transpose() * (tip(route.back()) - tip(route.front())));
  return straight_path(scene.robot, scene.T_F_T, q,
                       Eigen::Translation3d(p_R_shift) * forward(scene.robot, q) * scene.T_F_T);
}

ExecutionResult PlanExecutor::push(const PlanStep& step, bool* resisted) const {
  const JointPath& route = step.trajectory.q;
  const Eigen::Vector3d shift = tip(route.back()) - tip(route.front());
  const auto path = path_from_here(step);
  if (!path) return {Status::kStopped, 0.0, step.name + ": no straight path on"};
  GuardedMotion motion;
  motion.trajectory = timed(*path, shift.norm() / step.trajectory.duration());
  motion.threshold = step.threshold;
  motion.n_W_direction = shift.normalized();
  const MotionResult moved = cell.arm.follow_guarded(motion);
  *resisted = moved.status == MotionResult::Status::kContact;
  record(journal, TouchMeasured{*resisted, moved.force, 0.0});
  if (*resisted || moved.status == MotionResult::Status::kNoContact)
    return {Status::kReleased, moved.force, ""};
  return {Status::kStopped, moved.force, step.name + ": " + moved.reason};
}

ExecutionResult PlanExecutor::follow_from_here(const PlanStep& step, double share) const {
  const auto path = path_from_here(step, share);
  if (!path) return {Status::kStopped, 0.0, step.name + ": no straight path from where the arm stands"};
  return follow_slowly(step, *path);
}

ExecutionResult PlanExecutor::back_to_start(const PlanStep& step) const {
  return straight_to(step, step.trajectory.q.front());
}

ExecutionResult PlanExecutor::straight_to(const PlanStep& step, const Joints& q_end) const {
  const Pose T_R_T = forward(scene.robot, q_end) * scene.T_F_T;
  const auto path = straight_path(scene.robot, scene.T_F_T, cell.arm.state().q, T_R_T);
  if (!path) return {Status::kStopped, 0.0, step.name + ": no straight path from where the arm stands"};
  return follow_slowly(step, *path);
}

}  // namespace stonestack::stacking
