#include "descent_trial.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/constants.hpp"
#include "motion/cartesian.hpp"
#include "motion/clearance_below.hpp"
#include "motion/collision.hpp"
#include "motion/timing.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::bench {
namespace {

using Status = MotionResult::Status;

constexpr double kHighest = 0.12;   // m, between stone and support while the gripper moves aside
constexpr double kGap = 0.0005;     // m: contact that is reported further away is a false trigger
constexpr double kSlipped = 0.015;  // m, in the gripper: then another stone is taken
constexpr double kShoved = 0.005,
                 kShovedTurn = 0.09;  // m, rad: more than a lift does (stonestack-bench hold)
constexpr double kSeenShift = 0.0007,
                 kSeenTurn = 0.009;  // m, rad; one sigma an axis, as in stonestack-bench hold
constexpr double kMinSpeed = 0.003, kMaxSpeed = 0.007;   // m/s, the default is 0.005
constexpr double kCheckPeriod = 0.05;                    // s, along a descent
constexpr double kPushed = 0.0001, kPushedTurn = 0.001;  // m, rad: a support that moved was touched

double lowest(const Stone& stone, const Pose& T_W_O) {
  double z = 1e9;
  for (const Eigen::Vector3d& p : stone.scan.vertices) z = std::min(z, (T_W_O * p).z());
  return z;
}
double highest(const Stone& stone, const Pose& T_W_O) {
  double z = -1e9;
  for (const Eigen::Vector3d& p : stone.scan.vertices) z = std::max(z, (T_W_O * p).z());
  return z;
}

}  // namespace

bool DescentTrial::pick() {
  const auto truth = simulated_.truth();  // the setting of the experiment; nothing of it is used below
  PlanningScene scene;
  scene.robot = robot_;
  scene.T_F_T = layout_.T_F_T;
  for (std::size_t i = 0; i < 2; ++i)
    scene.objects.push_back({stones_[i].name, stones_[i].pieces, truth.T_W_O[i]});
  PickAndPlaceTask task;
  task.stone = &stones_[0];
  task.object = 0;
  task.T_W_O_pick = truth.T_W_O[0];
  task.T_W_O_place = task.T_W_O_pick;
  task.T_W_O_place.translation().head<2>() = layout_.site;
  task.q_start = cell_.arm.state().q;
  PickAndPlacePlan plan = plan_pick_and_place(scene, task);
  if (plan.status != PickAndPlacePlan::Status::kPlanned) return false;
  const auto lift = std::find_if(plan.steps.begin(), plan.steps.end(),
                                 [](const PlanStep& step) { return step.kind == PlanStep::Kind::kLift; });
  plan.steps.erase(lift + 1, plan.steps.end());
  if (execute(plan, stones_[0], scene, cell_, options_, nullptr).status != ExecutionResult::Status::kReleased)
    return false;
  T_W_aside_ = simulated_.truth().T_W_O[1];
  gripper_ = with_spacing(scene.gripper, plan.spacing);
  T_T_O_ = T_W_T().inverse() * simulated_.truth().T_W_O[0];
  return true;
}

bool DescentTrial::descend(bool on_stone, DescentTally& tally) {
  const Eigen::Vector2d at =
      layout_.site + Eigen::Vector2d(random_.uniform(-0.15, 0.15), random_.uniform(-0.10, 0.10));
  double support = 0.0;
  if (!go_up()) return false;
  if (on_stone) {  // it lies as it fell in the field, only elsewhere
    Pose T_W_O = simulated_.truth().T_W_O[1];
    T_W_O.translation().head<2>() = at + Eigen::Vector2d(random_.uniform(-0.02, 0.02), 0.0);
    simulated_.place(1_stone, T_W_O);
    simulated_.wait(0.5);
    support = highest(stones_[1], simulated_.truth().T_W_O[1]);
  } else {  // out of the workspace, where it was
    simulated_.place(1_stone, T_W_aside_);
    simulated_.wait(0.5);
  }
  if (!go_above(at, support + kHighest)) return true;
  const double gap = random_.uniform(0.005, 0.030);
  if (!go_down(kHighest - gap)) return true;
  ++tally.descents;
  ++descent_;
  tally.on_stone += on_stone ? 1 : 0;
  measure(gap + support, tally);
  if (!go_up()) return false;
  const PoseDifference moved = moved_in_gripper();
  shoved_ = shoved_ || moved.translation > kShoved || moved.angle > kShovedTurn;
  return moved.translation < kSlipped;
}

std::optional<JointTrajectory> DescentTrial::straight(const Pose& T_W_T_goal, double speed) {
  const auto path =
      straight_path(robot_, layout_.T_F_T, cell_.arm.state().q, layout_.T_W_R.inverse() * T_W_T_goal);
  if (!path) return std::nullopt;
  TimingLimits limits = timing_limits(robot_, options_);
  limits.tool_speed = speed;
  limits.blend = 0.0003;
  return time_path(*path, limits, robot_, layout_.T_F_T);
}

Pose DescentTrial::T_W_T() {
  return layout_.T_W_R * forward(robot_, cell_.arm.state().q) * layout_.T_F_T;
}

bool DescentTrial::go(const Pose& T_W_T_goal, double speed) {
  const auto trajectory = straight(T_W_T_goal, speed);
  return trajectory && cell_.arm.follow(*trajectory).status == Status::kDone;
}

bool DescentTrial::go_up() {
  Pose T = T_W_T();
  const double z = lowest(stones_[0], simulated_.truth().T_W_O[0]);
  T.translation().z() += std::max(0.0, 0.30 - z);
  return go(T, 0.15);
}

bool DescentTrial::go_above(const Eigen::Vector2d& at, double stone_z) {
  const Pose T_W_O = simulated_.truth().T_W_O[0];
  Pose T = T_W_T();
  T.translation().head<2>() += at - T_W_O.translation().head<2>();
  T.translation().z() += stone_z - lowest(stones_[0], T_W_O);
  return go(T, 0.25);
}

bool DescentTrial::go_down(double by) {
  Pose T = T_W_T();
  T.translation().z() -= by;
  return go(T, options_.approach_speed);
}

void DescentTrial::measure(double far, DescentTally& tally) {
  const Pose T_W_T_start = T_W_T();
  const auto down = [&](double by) { return Pose(Eigen::Translation3d(0, 0, -by) * T_W_T_start); };
  const double whole = std::min(far, 0.060) + options_.descent_past, allowed = clearance(whole);
  const double speed = random_.uniform(kMinSpeed, kMaxSpeed);
  const auto all = straight(down(whole), speed), descent = straight(down(allowed), speed);
  if (!all || !descent) return void(--tally.descents);
  DescentEnds& ends = shoved_                     ? tally.shoved
                      : gripper_comes_first(*all) ? tally.gripper_first
                                                  : tally.planned;
  ++ends.descents;
  GuardedMotion motion;
  motion.trajectory = *descent;
  motion.threshold = contact_threshold(stones_[0].mass.mass, options_);
  cell_.force_torque.zero();
  const double rest = level_force();
  const PoseDifference before = moved_in_gripper();
  const Pose T_W_support = simulated_.truth().T_W_O[1];
  const MotionResult result = cell_.arm.follow_guarded(motion);
  double peak = result.force;
  for (int i = 0; i < 3; ++i) peak = std::max(peak, level_force() - rest);
  const PoseDifference pushed = difference(T_W_support, simulated_.truth().T_W_O[1]);
  const bool touches = touching() || pushed.translation > kPushed || pushed.angle > kPushedTurn;
  const bool no_clearance = result.status == Status::kNoContact && allowed < whole && peak < motion.threshold;
  if (no_clearance) ++ends.no_clearance;
  if (result.status == Status::kNoContact && !no_clearance) ++(touches ? ends.missed : ends.stopped);
  if (result.status == Status::kContact && !touches) ++ends.early;
  if (result.status != Status::kContact && result.status != Status::kNoContact) ++ends.stopped;
  if (peak > kForceMark) ++ends.hard;
  ends.peaks.push_back(peak);
  const bool well =
      no_clearance || ((result.status == Status::kContact) == touches && result.status <= Status::kNoContact);
  if (tally.results != nullptr && (!well || peak > kForceMark))
    print(tally, ends,
          concat(result.reason, "; peak ", peak, " N; the stone touches", touches ? "" : " nothing"), before);
}

double DescentTrial::clearance(double max) {
  PlanningScene estimated = gripper_and_support();
  Pose& T_W_O = estimated.objects.front().T_W_object;
  for (int i = 0; i < 3; ++i) T_W_O.translation()[i] += estimate_.normal(0.0, kSeenShift);
  const Eigen::Vector3d turn(estimate_.normal(0.0, kSeenTurn), estimate_.normal(0.0, kSeenTurn),
                             estimate_.normal(0.0, kSeenTurn));
  T_W_O.linear() = Eigen::AngleAxisd(turn.norm(), turn.normalized()) * T_W_O.linear();
  return clearance_below(estimated, cell_.arm.state().q, cell_.gripper.state().opening, -1, max);
}

void DescentTrial::print(const DescentTally& tally, const DescentEnds& ends, const std::string& end,
                         const PoseDifference& before) {
  const char* kind = &ends == &tally.gripper_first ? ", gripper first"
                     : &ends == &tally.shoved      ? ", shoved"
                                                   : "";
  const PoseDifference after = moved_in_gripper();
  tally.results->note(
      "  stone %d, descent %d, %.2f kg%s: %s; nearest to the gripper: %s; in the gripper it had moved %.1f "
      "mm, "
      "%.1f deg, and %.1f mm, %.1f deg afterwards",
      static_cast<int>(tally.stone), descent_, stones_[0].mass.mass, kind, end.c_str(),
      nearest_to_gripper(cell_.arm.state().q).c_str(), 1e3 * before.translation, before.angle / kDegree,
      1e3 * after.translation, after.angle / kDegree);
}

PlanningScene DescentTrial::gripper_and_support() {
  PlanningScene scene;
  scene.robot = robot_;
  scene.T_F_T = layout_.T_F_T;
  scene.gripper = gripper_;
  scene.objects.push_back({stones_[1].name, stones_[1].pieces, simulated_.truth().T_W_O[1]});
  return scene;
}

bool DescentTrial::gripper_comes_first(const JointTrajectory& descent) {
  const PlanningScene scene = gripper_and_support();
  CollisionRules gripper;
  gripper.padding = options_.approach_padding;
  gripper.opening = cell_.gripper.state().opening;
  gripper.gripper_may_touch = {kTableObject};
  CollisionRules stone = gripper;
  stone.padding = stone.self_padding = 0.0;
  stone.gripper_may_touch = {kTableObject, 0};
  const HeldObject held{stones_[0].name, stones_[0].pieces, T_W_T().inverse() * simulated_.truth().T_W_O[0]};
  const CollisionChecker of_gripper(scene, gripper), of_stone(scene, stone, &held);
  for (double t = 0.0; t < descent.duration(); t += kCheckPeriod) {
    const Joints q = sample(descent, t).q;
    if (of_gripper.collides(q)) return true;
    if (of_stone.collides(q)) return false;
  }
  return false;
}

std::string DescentTrial::nearest_to_gripper(const Joints& q) {
  CollisionRules rules;
  rules.opening = cell_.gripper.state().opening;
  const Clearance nearest = CollisionChecker(gripper_and_support(), rules).clearance(q);
  return concat(nearest.first, " and ", nearest.second, ", ", 1e3 * nearest.distance, " mm");
}

PoseDifference DescentTrial::moved_in_gripper() {
  return difference(T_T_O_, T_W_T().inverse() * simulated_.truth().T_W_O[0]);
}

double DescentTrial::level_force() {
  const Pose T_W_F = layout_.T_W_R * forward(robot_, cell_.arm.state().q);
  return (T_W_F.linear() * cell_.force_torque.read().force).z();
}

bool DescentTrial::touching() {
  const auto truth = simulated_.truth();
  if (lowest(stones_[0], truth.T_W_O[0]) < kGap) return true;
  return std::any_of(truth.contacts.begin(), truth.contacts.end(),
                     [](const Contact& c) { return c.above == 0 || c.below == 0; });
}

}  // namespace stonestack::bench
