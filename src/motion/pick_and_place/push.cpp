#include "motion/push.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/constants.hpp"
#include "kinematics/inverse.hpp"
#include "motion/cartesian.hpp"
#include "motion/constants.hpp"
#include "motion/grasp/finger_reach.hpp"
#include "motion/grasp/gripper_check.hpp"
#include "motion/path/round_corners.hpp"
#include "motion/path/tool_speed.hpp"
#include "motion/pick_and_place/pick_attempt.hpp"
#include "motion/timing.hpp"
#include "motion/transit.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::motion {
namespace {

constexpr double kPushSpeed = 0.02;      ///< [m/s]
constexpr double kDownSpeed = 0.03;      ///< [m/s]: what is met is felt late
constexpr double kPushHeight = 0.35;     ///< of the stone's height, where the tips push: it slides
constexpr double kTipsOffTable = 0.010;  ///< [m]
constexpr double kBehindStep = 0.002;    ///< between places behind the stone that are tried [m]
constexpr double kMetStep = 0.001;       ///< where the gripper meets the stone [m]
constexpr double kBehindMost = 0.15;     ///< from its centre of mass [m]
/// On the way down, from the stone and everything else [m]; the first is more than the arm and what was seen
/// err by together.
constexpr std::array kClearances{0.008, 0.004, 0.002};
/// Ways on which the stone is sought from there [m]; the first leads some 15 mm past where it was seen. A way
/// that ends before it is none; with the last the push itself begins there and ends as far past where the
/// stone was seen.
constexpr std::array kSought{0.025, 0.015, 0.008, 0.0};
constexpr double kUpStep = 0.01;          ///< between places from where a free way up is asked for [m]
constexpr std::array kAbove{0.12, 0.08};  ///< straight down and up again [m]
constexpr std::array kPastMiddle{0.0, 0.015, -0.015};  ///< aside, of the line of the push [m]
constexpr double kBackOff = 0.010;                     ///< from the stone before the gripper goes up [m]
constexpr double kPushBlend = 0.0003;                  ///< [rad]
constexpr double kPushEffort = 1.0;                    ///< for the transit [s]
constexpr double kWidestPushBlend = 0.2;               ///< corners of the transit cut, most [rad]
constexpr double kPushForceShare = 1.5;                ///< of the stone's weight, more than its friction
constexpr double kMinPushForce = 15.0;                 ///< [N]
constexpr double kNoiseAlone = 6.0;                    ///< sigmas of the force that noise does not reach
constexpr double kStoneFelt = 3.0;                     ///< [N]: less than most stones' friction on the table

using Kind = PlanStep::Kind;

struct Paths {
  JointPath to_stone, down, up_to_it, push, off, up;
  double blend = 0.0;  ///< of the transit [rad]
};

/// Gripper straight down, its closing direction along `n_W` (unit, level).
Eigen::Matrix3d pointing_down(const Eigen::Vector3d& n_W) {
  Eigen::Matrix3d R_W_T;
  R_W_T.col(0) = n_W;
  R_W_T.col(2) = -Eigen::Vector3d::UnitZ();
  R_W_T.col(1) = R_W_T.col(2).cross(n_W);
  return R_W_T;
}

/// With fingers B and C drawn together where the gripper can.
PlanningScene compact(PlanningScene scene) {
  if (scene.gripper.narrow_spacing > 0)
    scene.gripper = with_spacing(std::move(scene.gripper), scene.gripper.narrow_spacing);
  return scene;
}

/// One way after the other to stand behind the stone.
class PushPlanner {
 public:
  PushPlanner(const PlanningScene& scene, const PushTask& task, const MotionOptions& options)
      : scene_(compact(scene)),
        task_(task),
        options_(options),
        n_W_(Eigen::Vector3d(task.p_W_shift.x(), task.p_W_shift.y(), 0.0).normalized()),
        wide_(scene_, rules(options.transit_padding, 0.0, -1)),
        pushing_(scene_, rules(options.approach_padding, 0.0, task.object)),
        opened_(scene_, rules(options.approach_padding, scene.gripper.max_opening, task.object)),
        gripper_(with_stone_alone(scene_, task), 0.0, -1) {
    double highest = -std::numeric_limits<double>::infinity();
    for (const Mesh& piece : task.stone->pieces)
      for (const Eigen::Vector3d& p_O : piece.vertices) highest = std::max(highest, (task.T_W_O * p_O).z());
    for (const double clearance : kClearances)
      among_.emplace_back(scene_, rules(std::max(clearance, options.approach_padding), 0.0, -1));
    const double tips = std::max(kTipsOffTable, kPushHeight * (highest - scene.table_z));
    p_W_middle_ = task.T_W_O * task.stone->mass.p_O_M;
    p_W_middle_.z() = scene.table_z + tips + tip_advance(scene.gripper, 0.0);
  }

  /// With the fingers that face A in front, then with A, then with the sides of the fingers, which takes less
  /// room beside the stone; through the centre of mass, then past it.
  [[nodiscard]] std::optional<Paths> plan(std::string* fault) {
    const Eigen::Vector3d n_W_aside = Eigen::Vector3d::UnitZ().cross(n_W_);
    const Eigen::Vector3d p_W_through = p_W_middle_;
    for (const CollisionChecker& among : among_)
      for (const double past : kPastMiddle) {
        p_W_middle_ = p_W_through + past * n_W_aside;
        for (const Eigen::Vector3d& n_W :
             {Eigen::Vector3d(-n_W_), n_W_, n_W_aside, Eigen::Vector3d(-n_W_aside)})
          if (auto paths = plan_turned(pointing_down(n_W), among, fault)) return paths;
      }
    return std::nullopt;
  }

 private:
  [[nodiscard]] static PlanningScene with_stone_alone(PlanningScene scene, const PushTask& task) {
    scene.objects = {{task.stone->name, task.stone->pieces, task.T_W_O}};
    return scene;
  }
  /// Where the gripper meets the stone on its way along the push from `begin` [m]; empty where it passes it.
  [[nodiscard]] std::optional<double> met(const Eigen::Matrix3d& R_W_T, double begin) const {
    const GripperCheck::Fingers closed{0.0, tip_advance(scene_.gripper, 0.0)};
    for (double along = begin; along < kBehindMost; along += kMetStep)
      if (gripper_.touches_object(tool(R_W_T, along, 0.0), closed, 0.0)) return along;
    return std::nullopt;
  }

  [[nodiscard]] Pose tool(const Eigen::Matrix3d& R_W_T, double along, double above) const {
    Pose T_W_T = Pose::Identity();
    T_W_T.linear() = R_W_T;
    T_W_T.translation() = p_W_middle_ + along * n_W_ + above * Eigen::Vector3d::UnitZ();
    return T_W_T;
  }
  [[nodiscard]] std::optional<JointPath> straight(const Joints& q, const Pose& T_W_T) const {
    return straight_path(scene_.robot, scene_.T_F_T, q, scene_.T_W_R.inverse() * T_W_T);
  }

  [[nodiscard]] std::optional<Paths> plan_turned(const Eigen::Matrix3d& R_W_T, const CollisionChecker& among,
                                                 std::string* fault) const {
    *fault = "there is no room for the gripper behind it";
    for (double behind = 0.0; behind < kBehindMost; behind += kBehindStep) {
      const Pose T_W_T = tool(R_W_T, -behind, 0.0);
      bool found = false;
      for (const IkSolution& solution :
           inverse(scene_.robot, scene_.T_W_R.inverse() * T_W_T * scene_.T_F_T.inverse(), task_.q_start)) {
        if (among.collides(solution.q)) continue;
        found = true;
        for (const double sought : kSought)
          if (auto paths = plan_from(R_W_T, behind, sought, solution.q, among, fault)) return paths;
      }
      if (found) return std::nullopt;  // further behind is no better
    }
    return std::nullopt;
  }

  /// `sought`: length of the way on which the stone is sought.
  [[nodiscard]] std::optional<Paths> plan_from(const Eigen::Matrix3d& R_W_T, double behind, double sought,
                                               const Joints& q_behind, const CollisionChecker& among,
                                               std::string* fault) const {
    throw_if_interrupted();
    *fault = "the gripper cannot stand near enough behind it";
    const auto at_stone = met(R_W_T, -behind);
    if (!at_stone || (sought > 0 && sought - behind < *at_stone)) return std::nullopt;
    const double latest = sought > 0 ? sought - behind : *at_stone;
    const double far = latest + task_.p_W_shift.norm();
    *fault = "no straight push is free";
    auto up_to_it =
        sought > 0 ? straight(q_behind, tool(R_W_T, latest, 0.0)) : std::optional(JointPath{q_behind});
    if (!up_to_it || !is_free(pushing_, *up_to_it)) return std::nullopt;
    auto push = straight(up_to_it->back(), tool(R_W_T, far, 0.0));
    if (!push || !is_free(pushing_, *push)) return std::nullopt;
    *fault = "nothing leads straight down behind it and up again";
    auto off = straight(push->back(), tool(R_W_T, far - kBackOff, 0.0));
    if (!off) return std::nullopt;
    for (const double above : kAbove) {
      auto down = straight(q_behind, tool(R_W_T, -behind, above));
      if (!down || !is_free(among, *down) || opened_.collides(down->back())) continue;
      auto up = way_up(R_W_T, *off, far - kBackOff, sought, above);
      if (!up) continue;
      std::reverse(down->begin(), down->end());
      Paths paths;
      paths.down = *std::move(down);
      paths.up_to_it = sought > 0 ? *std::move(up_to_it) : JointPath{};
      paths.push = *std::move(push);
      paths.off = *std::move(off);
      paths.up = *std::move(up);
      *fault = "no path leads there";
      return with_transit(std::move(paths), among);
    }
    return std::nullopt;
  }

  /// Up by `above` from the end of `off`, which is `along` the push, if that is free there and from up to
  /// `sought` nearer, where a stone that was felt early is left.
  [[nodiscard]] std::optional<JointPath> way_up(const Eigen::Matrix3d& R_W_T, const JointPath& off,
                                                double along, double sought, double above) const {
    std::optional<JointPath> up;
    for (double nearer = 0.0; nearer <= sought; nearer += kUpStep) {
      const auto from = straight(off.back(), tool(R_W_T, along - nearer, 0.0));
      if (!from) return std::nullopt;
      auto path = straight(from->back(), tool(R_W_T, along - nearer, above));
      if (!path || !is_free(pushing_, *path) || opened_.collides(path->back())) return std::nullopt;
      if (!up) up = std::move(path);
    }
    return up;
  }

  /// Adds the way to where it goes down.
  [[nodiscard]] std::optional<Paths> with_transit(Paths paths, const CollisionChecker& among) const {
    const Joints q_above = paths.down.front();
    const bool near = wide_.collides(task_.q_start) || wide_.collides(q_above);
    const CollisionChecker& checker = near ? among : wide_;
    MotionOptions options = options_;
    options.planning_effort = std::min(options.planning_effort, kPushEffort);
    auto transit = find_path(checker, task_.q_start, std::span(&q_above, 1), options, kPushEffort);
    if (!transit) return std::nullopt;
    TimingLimits limits = timing_limits(scene_.robot, options_);
    limits.blend = kWidestPushBlend;
    paths.blend = free_blend(checker, *transit, limits);
    paths.to_stone = *std::move(transit);
    return paths;
  }

  PlanningScene scene_;
  const PushTask& task_;
  const MotionOptions& options_;
  Eigen::Vector3d n_W_;         ///< of the push, unit, level
  Eigen::Vector3d p_W_middle_;  ///< of T where the tips would push beside the centre of mass
  /// Closed gripper, the stone there, one for each of kClearances.
  std::vector<CollisionChecker> among_;
  CollisionChecker wide_;     ///< the same with the padding of a transit
  CollisionChecker pushing_;  ///< closed gripper, the stone not there
  CollisionChecker opened_;   ///< open gripper, the stone not there
  GripperCheck gripper_;      ///< the gripper and the stone, nothing else
};

PlanStep fingers_step(const char* name, double opening) {
  PlanStep step;
  step.kind = Kind::kOpen;
  step.name = name;
  step.opening = opening;
  step.finger_speed = kFingerSpeed;
  return step;
}

}  // namespace

PickAndPlacePlan plan_push(const PlanningScene& scene, const PushTask& task, const MotionOptions& options) {
  require(task.stone != nullptr, "a push needs a stone");
  require(task.p_W_shift.allFinite() && task.p_W_shift.norm() > 0, "a push needs a direction and a length");
  require(is_valid(task.T_W_O), "the pose of ", task.stone->name, " is not a pose");
  PickAndPlacePlan plan;
  const std::string& name = task.stone->name;
  std::string fault;
  const auto paths = PushPlanner(scene, task, options).plan(&fault);
  if (!paths) {
    plan.status = PickAndPlacePlan::Status::kNoTransit;
    plan.reason = concat("pushing ", name, ": ", fault);
    return plan;
  }
  const auto add = [&](Kind kind, const std::string& what, const JointPath& path, TimingLimits limits,
                       double threshold, const ToolSpeed& tool_speed = {}) {
    PlanStep step;
    step.kind = kind;
    step.name = what;
    step.trajectory = time_path(path, limits, scene.robot, scene.T_F_T, tool_speed);
    step.threshold = threshold;
    plan.seconds += step.trajectory.duration();
    plan.steps.push_back(std::move(step));
  };
  const TimingLimits limits = timing_limits(scene.robot, options);
  TimingLimits transit = limits, slow = limits;
  transit.blend = paths->blend;
  slow.blend = kPushBlend;
  const auto at_speed = [&](double speed) {
    slow.tool_speed = speed;
    return slow;
  };
  plan.steps.push_back(fingers_step("close the gripper", 0.0));
  plan.steps.back().spacing = scene.gripper.narrow_spacing;
  add(Kind::kTransit, "move behind " + name, paths->to_stone, transit, 0.0, transit_speed(scene, options));
  add(Kind::kApproach, "go down behind " + name, paths->down,
      at_speed(std::min(options.approach_speed, kDownSpeed)), options.early_threshold);
  if (!paths->up_to_it.empty())
    add(Kind::kDescent, "go up to " + name, paths->up_to_it, at_speed(kPushSpeed),
        std::max(kStoneFelt, kNoiseAlone * options.force_noise));
  add(Kind::kDescent, "push " + name, paths->push, at_speed(kPushSpeed),
      std::max(kMinPushForce, kPushForceShare * kGravity * task.stone->mass.mass));
  add(Kind::kRetreat, "retreat from " + name, paths->off, at_speed(options.approach_speed), 0.0);
  add(Kind::kRetreat, "rise from " + name, paths->up, at_speed(options.approach_speed), 0.0);
  plan.steps.push_back(fingers_step("open the gripper", scene.gripper.max_opening));
  return plan;
}

}  // namespace stonestack::motion
