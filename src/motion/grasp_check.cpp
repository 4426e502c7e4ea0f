#include "stonestack/motion/grasp_check.hpp"

#include <optional>

#include "motion/grasp_wrench.hpp"
#include "motion/hand_check.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/kinematics/inverse.hpp"
#include "stonestack/motion/collision.hpp"

namespace stonestack {
namespace {

constexpr double kGravity = 9.81;

/// What has to be free at one end: the pose of the hand there and the pose at the far end of each straight
/// motion that leads to or from it.
struct End {
  GraspFault table, object, reach, arm;
};
constexpr End kPick{GraspFault::kTableAtPick, GraspFault::kObjectAtPick, GraspFault::kReachAtPick,
                    GraspFault::kArmAtPick};
constexpr End kPlace{GraspFault::kTableAtPlace, GraspFault::kObjectAtPlace, GraspFault::kReachAtPlace,
                     GraspFault::kArmAtPlace};

bool within_limits(const RobotModel& robot, const Joints& q) {
  return (q.array() >= robot.lower.array()).all() && (q.array() <= robot.upper.array()).all();
}

/// The closed fingers fill nothing but the space of the stone between them, so this checker sees the arm and
/// the palm; HandCheck sees the open fingers.
CollisionRules arm_rules(const MotionOptions& options, int object) {
  CollisionRules rules;
  rules.padding = options.approach_padding;
  rules.opening = 0.0;
  rules.left_out = object;
  return rules;
}

}  // namespace

struct GraspFinder::Parts {
  Parts(const PlanningScene& the_scene, const Stone& the_stone, int object, const MotionOptions& the_options)
      : scene(the_scene),
        stone(the_stone),
        options(the_options),
        set(cached_grasps(stone, scene.gripper)),
        hand(scene, options.approach, object),
        arm(scene, arm_rules(options, object)) {}

  const PlanningScene& scene;
  const Stone& stone;
  MotionOptions options;
  std::shared_ptr<const GraspSet> set;
  HandCheck hand;
  CollisionChecker arm;
  GraspCheck pick;  ///< of the pick side alone

  [[nodiscard]] bool too_weak(const Grasp& grasp, const Pose& T_W_T) const;
  [[nodiscard]] std::optional<GraspFault> fault(const Grasp& grasp, const Pose& T_W_O, const End& end) const;
};

bool GraspFinder::Parts::too_weak(const Grasp& grasp, const Pose& T_W_T) const {
  const Eigen::Vector3d n_T_down = -T_W_T.linear().row(2).transpose();
  const double weight = kGravity * stone.mass.mass;
  const double most = scene.gripper.force / GraspOptions{}.force_factor;
  return holding_force(grasp, weight, n_T_down) > most &&  // a quick bound
         exact_holding_force(grasp, stone.mass.p_O_M, scene.gripper.friction, weight, n_T_down) > most;
}

std::optional<GraspFault> GraspFinder::Parts::fault(const Grasp& grasp, const Pose& T_W_O,
                                                    const End& end) const {
  const Pose T_W_T = T_W_O * grasp.T_O_T;
  const HandCheck::Hit hit = hand.sweep(T_W_T, grasp.pre_opening, options.approach_padding);
  if (hit.what == HandCheck::Hit::What::kTableObject) return end.table;
  if (hit.what == HandCheck::Hit::What::kObject) return end.object;
  if (too_weak(grasp, T_W_T)) return GraspFault::kTooWeak;

  const Pose T_R_W = scene.T_W_R.inverse(), T_T_F = scene.T_F_T.inverse();
  const auto flange = [&](const Pose& T_W_tool) { return T_R_W * T_W_tool * T_T_F; };
  const Pose T_W_back = T_W_T * Pose(Eigen::Translation3d(0, 0, -options.approach));
  const Pose T_W_up = Pose(Eigen::Translation3d(0, 0, options.lift)) * T_W_T;
  const IkBranches at = inverse_branches(scene.robot, flange(T_W_T), Joints::Zero());
  const IkBranches back = inverse_branches(scene.robot, flange(T_W_back), Joints::Zero());
  const IkBranches up = inverse_branches(scene.robot, flange(T_W_up), Joints::Zero());
  const auto has = [](const IkBranches& all, int branch) {
    for (int i = 0; i < all.count; ++i)
      if (all.solutions[static_cast<std::size_t>(i)].branch == branch) return true;
    return false;
  };
  bool reached = false;
  for (int i = 0; i < at.count; ++i) {
    const IkSolution& s = at.solutions[static_cast<std::size_t>(i)];
    if (!within_limits(scene.robot, s.q) || !has(back, s.branch) || !has(up, s.branch)) continue;
    reached = true;
    if (!arm.collides(s.q)) return std::nullopt;
  }
  return reached ? end.arm : end.reach;
}

GraspFinder::GraspFinder(const PlanningScene& scene, const Stone& stone, int object, const Pose& T_W_O_pick,
                         const MotionOptions& options) {
  require(is_valid(T_W_O_pick), "the pose of ", stone.name, " is not a pose: ", to_text(T_W_O_pick));
  require(object >= -1 && object < static_cast<int>(scene.objects.size()), "stone ", stone.name,
          " is object ", object, " of ", scene.objects.size());
  parts_ = std::make_unique<Parts>(scene, stone, object, options);
  GraspCheck& pick = parts_->pick;
  pick.total = static_cast<int>(parts_->set->grasps.size());
  for (int i = 0; i < pick.total; ++i) {
    const Grasp& grasp = parts_->set->grasps[static_cast<std::size_t>(i)];
    if (const auto fault = parts_->fault(grasp, T_W_O_pick, kPick))
      ++pick.refused[static_cast<std::size_t>(*fault)];
    else
      pick.usable.push_back(i);
  }
}
GraspFinder::~GraspFinder() = default;
GraspFinder::GraspFinder(GraspFinder&&) noexcept = default;
GraspFinder& GraspFinder::operator=(GraspFinder&&) noexcept = default;

GraspCheck GraspFinder::check(const Pose& T_W_O_place, int enough) const {
  require(is_valid(T_W_O_place), "the target of ", parts_->stone.name,
          " is not a pose: ", to_text(T_W_O_place));
  GraspCheck result = parts_->pick;
  result.usable.clear();
  for (const int i : parts_->pick.usable) {
    if (const auto fault =
            parts_->fault(parts_->set->grasps[static_cast<std::size_t>(i)], T_W_O_place, kPlace))
      ++result.refused[static_cast<std::size_t>(*fault)];
    else
      result.usable.push_back(i);
    if (enough > 0 && static_cast<int>(result.usable.size()) >= enough) break;
  }
  return result;
}

bool GraspFinder::serves(const Pose& T_W_O_place) const {
  return !check(T_W_O_place, 1).usable.empty();
}

const GraspSet& GraspFinder::set() const {
  return *parts_->set;
}

const char* to_text(GraspFault fault) {
  static const std::array<const char*, kGraspFaults> what{"could not hold the weight",
                                                          "hit the table at pick",
                                                          "hit another object at pick",
                                                          "are out of reach at pick",
                                                          "bring the arm into something at pick",
                                                          "hit the table at the target",
                                                          "hit another object at the target",
                                                          "are out of reach at the target",
                                                          "bring the arm into something at the target"};
  return what[static_cast<std::size_t>(fault)];
}

std::string GraspCheck::text() const {
  std::string parts;
  for (std::size_t i = 0; i < kGraspFaults; ++i)
    if (refused[i] > 0)
      parts += concat(parts.empty() ? " " : ", ", refused[i], " ", to_text(static_cast<GraspFault>(i)));
  return concat("of ", total, " grasps", parts.empty() ? " none was refused" : parts);
}

bool can_grasp(const PlanningScene& scene, const PickAndPlaceTask& task, const MotionOptions& options) {
  require(task.stone != nullptr, "a task needs a stone");
  return GraspFinder(scene, *task.stone, task.object, task.T_W_O_pick, options).serves(task.T_W_O_place);
}

GraspCheck check_grasps(const PlanningScene& scene, const PickAndPlaceTask& task,
                        const MotionOptions& options) {
  require(task.stone != nullptr, "a task needs a stone");
  return GraspFinder(scene, *task.stone, task.object, task.T_W_O_pick, options).check(task.T_W_O_place);
}

}  // namespace stonestack
