#include "stonestack/motion/pick_and_place.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/constants.hpp"
#include "kinematics/inverse.hpp"
#include "motion/cartesian.hpp"
#include "motion/constants.hpp"
#include "motion/grasp_check.hpp"
#include "motion/pick_and_place/pick_attempt.hpp"
#include "motion/pick_and_place/pick_candidates.hpp"
#include "motion/timing.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/motion/planning_scene.hpp"

namespace stonestack::motion {
namespace {

constexpr double kInTable = 0.003;  ///< what a scan and a measured pose may err by [m]

using Status = PickAndPlacePlan::Status;

constexpr std::size_t kMaxHard =
    8;  ///< candidates whose transit is hard to find, before one gets much effort
constexpr double kNearGrasp = 0.020;     ///< a grasp that near to one that failed would fail as well [m]
constexpr double kNearGraspTurn = 0.35;  ///< [rad]

PickAndPlacePlan refused(Status status, std::string reason) {
  PickAndPlacePlan plan;
  plan.status = status;
  plan.reason = std::move(reason);
  return plan;
}

/// Why a stone has no grasp at all, wherever it lies.
PickAndPlacePlan no_grasp(const PlanningScene& scene, const Stone& stone, const GraspSet& set) {
  const GripperModel& gripper = scene.gripper;
  if (set.too_heavy > 0)
    return refused(Status::kTooHeavy,
                   concat(stone.name, " weighs ", stone.mass.mass, " kg; all ", set.too_heavy,
                          " grasps of it need more than ", gripper.force, " N a finger"));
  if (set.too_wide > std::max(set.slips, set.gripper_in_stone)) {
    const double widest = gripper.max_opening - GraspOptions{}.finger_clearance;
    return refused(Status::kTooWide,
                   concat(stone.name, " is at least ", set.narrowest,
                          " m wide between the pads; the gripper takes ", gripper.min_object, " to ", widest,
                          " m, so that it opens to ", gripper.max_opening, " m beside it"));
  }
  return refused(Status::kNoGrasp,
                 concat(stone.name, " offers no grasp: of ", set.tried, " samples ", set.no_contact,
                        " touch with less than all pads, ", set.too_wide, " are too wide, ",
                        set.gripper_in_stone, " bring the gripper into the stone, ", set.slips, " slip"));
}

/// Some grasps exist, but none serves both ends.
PickAndPlacePlan none_usable(const Stone& stone, const GraspCheck& check) {
  const auto count = [&](GraspFault f) { return check.refused[static_cast<std::size_t>(f)]; };
  const int reach = count(GraspFault::kReachAtPick) + count(GraspFault::kReachAtPlace);
  const bool weak = count(GraspFault::kTooWeak) == check.total;
  const Status status = weak ? Status::kTooHeavy : reach == check.total ? Status::kNoReach : Status::kNoGrasp;
  return refused(status, concat(stone.name, ": ", check.text()));
}

/// Number of candidates that failed on each part of the path.
class FaultCounts {
 public:
  void add(PathFault fault) { ++counts_[static_cast<std::size_t>(fault)]; }
  [[nodiscard]] std::string text() const {
    std::string parts;
    for (std::size_t i = 1; i < counts_.size(); ++i)
      if (counts_[i] > 0)
        parts += concat(parts.empty() ? "" : ", ", counts_[i], " ", to_text(static_cast<PathFault>(i)));
    return parts;
  }

 private:
  std::array<int, 7> counts_{};
};

/// Which grasps failed each time where the stone lies, so that another target does not help them.
class PickFaults {
 public:
  void add(int grasp, PathFault fault) {
    const bool at_pick = fault == PathFault::kApproach || fault == PathFault::kLift;
    const auto [it, is_new] = only_at_pick_.try_emplace(grasp, at_pick);
    if (!is_new) it->second = it->second && at_pick;
  }
  [[nodiscard]] std::vector<Pose> grasps(const GraspSet& set) const {
    std::vector<Pose> list;
    for (const auto& [grasp, at_pick] : only_at_pick_)
      if (at_pick) list.push_back(set.grasps[static_cast<std::size_t>(grasp)].T_O_T);
    return list;
  }

 private:
  std::map<int, bool> only_at_pick_;
};

/// Amount by which the stone at its target would reach into the table [m].
double depth_in_table(const PlanningScene& scene, const PickAndPlaceTask& task) {
  double lowest = scene.table_z;
  for (const Eigen::Vector3d& p : task.stone->scan.vertices)
    lowest = std::min(lowest, (task.T_W_O_place * p).z());
  return scene.table_z - lowest;
}

/// Why one end of the task is out of reach whatever the grasp; empty if it may not be.
std::string too_far(const PlanningScene& scene, const PickAndPlaceTask& task) {
  const RobotModel& robot = scene.robot;
  const Pose T_W_D = scene.T_W_R * robot.T_R_D;
  const Eigen::Vector3d p_W_shoulder = T_W_D * Eigen::Vector3d(0, 0, robot.d1);
  // No joint angles bring the tool's tip further from the shoulder than all lengths in one line.
  const double reach = std::abs(robot.a2) + std::abs(robot.a3) + std::abs(robot.d4) + std::abs(robot.d5) +
                       std::abs(robot.d6) + (robot.T_D6_F * scene.T_F_T).translation().norm();
  double radius = 0.0;
  for (const Eigen::Vector3d& v : task.stone->scan.vertices)
    radius = std::max(radius, (v - task.stone->mass.p_O_M).norm());
  for (const bool place : {false, true}) {
    const Pose& T_W_O = place ? task.T_W_O_place : task.T_W_O_pick;
    const double away = (T_W_O * task.stone->mass.p_O_M - p_W_shoulder).norm();
    if (away > reach + radius)
      return concat(place ? "the target of " : "", task.stone->name, " is ", std::lround(1e3 * away),
                    " mm from the robot's shoulder; stretched out, arm and gripper reach ",
                    std::lround(1e3 * reach), " mm");
  }
  return {};
}

/// Why the arm cannot set out from where it stands; empty if it can.
std::string outside_limits(const RobotModel& robot, const Joints& q) {
  constexpr double kSlack = 1e-6;  // rad
  constexpr const char* kJoints[] = {"base", "shoulder", "elbow", "wrist 1", "wrist 2", "wrist 3"};
  for (Eigen::Index i = 0; i < q.size(); ++i)
    if (q[i] < robot.lower[i] - kSlack || q[i] > robot.upper[i] + kSlack)
      return concat("the arm starts outside its limits: joint ", kJoints[i], " at ", q[i], " rad, limits ",
                    robot.lower[i], " to ", robot.upper[i], " rad");
  std::string outside = describe_outside_workspace(robot, q, -kWorkspaceMargin);
  if (outside.empty()) outside = describe_outside_fence(robot, q, -kWorkspaceMargin);
  return outside.empty() ? "" : "the arm starts where it must not be: " + outside;
}

double total_seconds(const std::vector<PlanStep>& steps) {
  double seconds = 0.0;
  for (const PlanStep& step : steps) seconds += step.trajectory.duration();
  return seconds;
}

/// A rough guess of what that attempt took [s]: it is what planning_effort counts, so that a busy machine
/// plans as an idle one does.
double effort_of(const PickAttempt::Result& result, PickAttempt::Effort effort) {
  constexpr double kStraight = 0.002, kFound = 0.03, kLittle = 0.1, kMuch = 0.5;
  if (result.fault == PathFault::kNone) return kFound;
  const bool transit = result.fault == PathFault::kTransit || result.fault == PathFault::kCarry;
  return !transit ? kStraight : effort == PickAttempt::Effort::kMuch ? kMuch : kLittle;
}

/// Tries candidates in order until enough have a free path; the quickest wins. Those whose transit is hard to
/// find are postponed, and get much effort where none of the others succeeded, or many were as hard.
PickAndPlacePlan plan_paths(const PlanningScene& scene, const PickAndPlaceTask& task,
                            const MotionOptions& options, const GraspSet& set, PickCandidates candidates) {
  FaultCounts faults;
  PickFaults pick_faults;
  PickAndPlacePlan best = refused(Status::kNoTransit, "");
  int found = 0, tried = 0;
  std::vector<PickCandidate> hard;
  std::size_t again = 0;  // of these, tried with much effort
  bool in_time = true;
  double best_cost = 0.0, spent = 0.0;  // s
  while (found < kPlans) {
    throw_if_interrupted();
    in_time = spent <= options.planning_effort;
    if (!in_time) break;
    const bool enough_hard = found == 0 && hard.size() - again >= kMaxHard;
    auto candidate = enough_hard ? std::nullopt : candidates.next();
    auto effort = PickAttempt::Effort::kLittle;
    if (!candidate && found == 0 && again < hard.size()) {
      candidate = hard[again++];
      effort = PickAttempt::Effort::kMuch;
    }
    if (!candidate) break;
    const bool first = effort == PickAttempt::Effort::kLittle;
    tried += first ? 1 : 0;
    const Grasp& grasp = set.grasps[static_cast<std::size_t>(candidate->grasp)];
    const PickAttempt attempt(scene, task, options, grasp);
    const PickAttempt::Result result = attempt.try_joints(candidate->q_pick, candidate->q_place, effort);
    spent += effort_of(result, effort);
    if (first) {
      faults.add(result.fault);
      pick_faults.add(candidate->grasp, result.fault);
      if (result.fault == PathFault::kTransit || result.fault == PathFault::kCarry)
        hard.push_back(*candidate);
    }
    if (result.fault != PathFault::kNone) continue;
    ++found;
    PickAndPlacePlan plan;
    plan.T_O_T = grasp.T_O_T;
    plan.spacing = grasp.spacing;
    plan.steps = timed_steps(scene, task, options, grasp, result.paths);
    plan.seconds = total_seconds(plan.steps);
    if (best.status == Status::kPlanned && plan.seconds + candidate->price >= best_cost) continue;
    best_cost = plan.seconds + candidate->price;
    best = std::move(plan);
  }
  if (best.status == Status::kPlanned) return best;
  best.no_pick = pick_faults.grasps(set);
  best.reason = concat(task.stone->name, ": of ", tried, " candidates tried with usable grasps ",
                       faults.text(), !in_time ? "; then planning time was over" : "");
  return best;
}

void check_task(const PlanningScene& scene, const PickAndPlaceTask& task) {
  require(task.stone != nullptr, "a task needs a stone");
  require(is_valid(task.T_W_O_pick) && is_valid(task.T_W_O_place), "the poses of ", task.stone->name,
          " are not poses: ", geometry::to_text(task.T_W_O_pick), " and ",
          geometry::to_text(task.T_W_O_place));
  require(task.q_start.allFinite(), "the arm's joints are not finite: ", task.q_start.transpose());
  const int objects = static_cast<int>(scene.objects.size());
  require(task.object >= -1 && task.object < objects && task.support >= -1 && task.support < objects,
          "the task names object ", task.object, " and support ", task.support, " of ", objects);
  require(!task.stone->pieces.empty(), "stone ", task.stone->name, " has no convex pieces");
}

}  // namespace

bool is_near_grasp(std::span<const Pose> failed, const Pose& T_O_T) {
  return std::any_of(failed.begin(), failed.end(), [&](const Pose& before) {
    const auto apart = difference(before, T_O_T);
    return apart.translation < kNearGrasp && apart.angle < kNearGraspTurn;
  });
}

PickAndPlacePlan plan_pick_and_place(const PlanningScene& scene, const PickAndPlaceTask& task,
                                     const MotionOptions& options) {
  check_task(scene, task);
  const Stone& stone = *task.stone;
  if (const std::string who = overload(stone.mass.mass, scene.gripper, scene.robot); !who.empty())
    return refused(Status::kTooHeavy, concat(stone.name, " weighs ", stone.mass.mass, " kg; ", who));
  if (std::string outside = outside_limits(scene.robot, task.q_start); !outside.empty())
    return refused(Status::kNoTransit, std::move(outside));
  if (const double depth = depth_in_table(scene, task); depth > kInTable)
    return refused(Status::kNoReach, concat("the target puts ", stone.name, ' ', std::lround(1e3 * depth),
                                            " mm into the table"));
  if (std::string far = too_far(scene, task); !far.empty()) return refused(Status::kNoReach, std::move(far));
  const GraspFinder finder(scene, stone, task.object, task.T_W_O_pick, options);
  if (finder.set().grasps.empty()) return no_grasp(scene, stone, finder.set());
  const GraspCheck check = finder.check(task.T_W_O_place);
  if (check.usable.empty()) return none_usable(stone, check);
  PickAndPlacePlan plan =
      plan_paths(scene, task, options, finder.set(),
                 PickCandidates(scene, task, options, finder.set(), check,
                                [&](int grasp, const Joints& q) { return finder.arm_is_free(grasp, q); }));
  if (plan.status == Status::kNoTransit)
    // Asked when no plan was found: which grasps do not lift the stone is worth knowing all the same.
    if (const std::string stands = start_problem(scene, task.q_start); !stands.empty())
      plan.reason = stands + "; " + plan.reason;
  return plan;
}

std::optional<JointTrajectory> plan_retreat(const PlanningScene& scene, const Joints& q, double opening,
                                            int object, const MotionOptions& options) {
  const Pose T_R_T = forward(scene.robot, q) * scene.T_F_T;
  const auto path =
      straight_path(scene.robot, scene.T_F_T, q, T_R_T * Pose(Eigen::Translation3d(0, 0, -options.approach)));
  CollisionRules rules;
  rules.padding = 0.0;
  rules.opening = opening;
  rules.left_out = object;
  if (!path || !is_free(CollisionChecker(scene, rules), *path)) return std::nullopt;
  TimingLimits limits = timing_limits(scene.robot, options);
  limits.tool_speed = options.approach_speed;
  return time_path(*path, limits, scene.robot, scene.T_F_T);
}

}  // namespace stonestack::motion
