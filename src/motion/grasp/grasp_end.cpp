#include "motion/grasp/grasp_end.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "core/constants.hpp"
#include "kinematics/inverse.hpp"
#include "motion/constants.hpp"
#include "motion/grasp/finger_reach.hpp"
#include "motion/grasp/grasp_wrench.hpp"

namespace stonestack::motion {
namespace {

constexpr std::size_t kFew = 4;            // grasps that pick a stone up, below which more are sampled,
constexpr int kDenser = 4;                 // so many times the directions;
constexpr std::size_t kFewOverTable = 12;  // and where most of them meet the table,
constexpr int kDenserFromAbove = 24;       // so many times,
constexpr double kFromAbove = 0.45;        // rad, as far from the vertical,
constexpr std::size_t kManyBlocked =
    100;  // grasps that all meet an object: denser ones between them will, too
constexpr double kTightClearance = 0.006;  // m, of the open fingers, which is twice what a seen pose errs by
constexpr double kOpeningStep = 0.02;      // m, to which openings are rounded up against the arm's own links

/// Returns the same arm pose with joints turned by whole turns into their limits, where those are not about
/// zero; false if one has no such angle there.
bool turn_into_limits(const RobotModel& robot, Joints& q) {
  constexpr double kTurn = 2.0 * std::numbers::pi;
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    if (q[i] < robot.lower[i]) q[i] += kTurn * std::ceil((robot.lower[i] - q[i]) / kTurn);
    if (q[i] > robot.upper[i]) q[i] -= kTurn * std::ceil((q[i] - robot.upper[i]) / kTurn);
    if (q[i] < robot.lower[i]) return false;
  }
  return true;
}

/// The closed fingers fill nothing but the space of the stone between them, so this checker sees the arm and
/// the palm; GripperCheck sees the open fingers against objects, `open_gripper` against the arm.
CollisionRules arm_rules(const MotionOptions& options, int object) {
  CollisionRules rules;
  rules.padding = options.approach_padding;
  rules.opening = 0.0;
  rules.left_out = object;
  return rules;
}

/// The arm itself and its gripper, which at a steep tilt comes near to the forearm, at openings up to the
/// largest. Objects are not seen; the table is, as near as the arm may come to it at a grasp.
std::vector<CollisionChecker> open_gripper(const PlanningScene& scene, const MotionOptions& options) {
  PlanningScene empty = scene;
  empty.objects.clear();
  CollisionRules rules;
  rules.padding = options.approach_padding;
  rules.gripper_may_touch = {kTableObject};
  std::vector<CollisionChecker> checkers;
  const double widest = scene.gripper.max_opening;
  for (double opening = kOpeningStep; opening < widest + kOpeningStep; opening += kOpeningStep) {
    rules.opening = std::min(opening, widest);
    checkers.emplace_back(empty, rules);
  }
  return checkers;
}

bool has_branch(const IkBranches& all, int branch) {
  for (int i = 0; i < all.count; ++i)
    if (all.solutions[static_cast<std::size_t>(i)].branch == branch) return true;
  return false;
}

}  // namespace

GraspEnd::GraspEnd(const PlanningScene& scene, const Stone& stone, int object, const MotionOptions& options)
    : scene_(scene), stone_(stone), options_(options) {
  make_grippers(scene, object);
  for (SpacedGripper& gripper : grippers_) {
    PlanningScene spaced = scene;
    spaced.gripper = with_spacing(scene.gripper, gripper.spacing);
    gripper.open = open_gripper(spaced, options);
  }
}

GraspEnd::GraspEnd(const GraspEnd& other, std::span<const SceneObject> objects)
    : scene_(other.scene_), stone_(other.stone_), options_(other.options_) {
  PlanningScene scene;
  scene.robot = scene_.robot;
  scene.gripper = scene_.gripper;
  scene.T_W_R = scene_.T_W_R;
  scene.T_F_T = scene_.T_F_T;
  scene.table_z = scene_.table_z;
  scene.paddings = scene_.paddings;
  scene.objects.assign(objects.begin(), objects.end());
  make_grippers(scene, -1);
}

GraspEnd GraspEnd::among(std::span<const SceneObject> objects) const {
  return {*this, objects};
}

void GraspEnd::make_grippers(const PlanningScene& scene, int object) {
  const auto add = [&](double spacing) {
    PlanningScene spaced = scene;
    spaced.gripper = with_spacing(scene.gripper, spacing);
    grippers_.push_back({spacing,
                         GripperCheck(spaced, options_.approach, object),
                         CollisionChecker(spaced, arm_rules(options_, object)),
                         {}});
  };
  add(scene.gripper.finger_spacing);
  if (scene.gripper.narrow_spacing > 0) add(scene.gripper.narrow_spacing);
}

const GraspEnd::SpacedGripper& GraspEnd::gripper(const Grasp& grasp) const {
  return grippers_.size() > 1 && grasp.spacing == grippers_[1].spacing ? grippers_[1] : grippers_[0];
}

// On approach, while they close and while they open again.
GripperCheck::Fingers GraspEnd::fingers(const Grasp& grasp) const {
  return {grasp.pre_opening, furthest_tip(scene_.gripper, grasp.opening, grasp.pre_opening)};
}

bool GraspEnd::too_weak(const Grasp& grasp, const Pose& T_W_T) const {
  const Eigen::Vector3d n_T_down = -T_W_T.linear().row(2).transpose();
  const double weight = kGravity * stone_.mass.mass;
  const double max = scene_.gripper.force / GraspOptions{}.force_factor;
  return holding_force(grasp, weight, n_T_down) > max &&  // a quick bound
         exact_holding_force(grasp, stone_.mass.p_O_M, scene_.gripper.friction, weight, n_T_down) > max;
}

std::optional<EndFault> GraspEnd::gripper_fault(const Grasp& grasp, const Pose& T_W_O) const {
  const Pose T_W_T = T_W_O * grasp.T_O_T;
  const GripperCheck::Hit hit = gripper(grasp).check.sweep(T_W_T, fingers(grasp), options_.approach_padding);
  if (hit.what == GripperCheck::Hit::What::kTheTable) return EndFault::kTable;
  if (hit.what == GripperCheck::Hit::What::kObject) return EndFault::kObject;
  if (too_weak(grasp, T_W_T)) return EndFault::kTooWeak;
  return std::nullopt;
}

bool GraspEnd::arm_is_free(const Grasp& grasp, const Joints& q) const {
  const SpacedGripper& at = gripper(grasp);
  if (at.arm.collides(q)) return false;
  if (at.open.empty()) return true;
  const auto wide = static_cast<std::size_t>(grasp.pre_opening / kOpeningStep);
  return !at.open[std::min(at.open.size() - 1, wide)].collides(q);
}

std::optional<EndFault> GraspEnd::arm_fault(const Grasp& grasp, const Pose& T_W_T) const {
  const Pose T_R_W = scene_.T_W_R.inverse(), T_T_F = scene_.T_F_T.inverse();
  const auto branches = [&](const Pose& T_W_tool) {
    return inverse_branches(scene_.robot, T_R_W * T_W_tool * T_T_F, Joints::Zero());
  };
  const IkBranches at = branches(T_W_T);
  const IkBranches back = branches(T_W_T * Pose(Eigen::Translation3d(0, 0, -options_.approach)));
  const IkBranches up = branches(Pose(Eigen::Translation3d(0, 0, kLiftHeight)) * T_W_T);
  bool reached = false;
  for (int i = 0; i < at.count; ++i) {
    IkSolution s = at.solutions[static_cast<std::size_t>(i)];
    if (!turn_into_limits(scene_.robot, s.q) || !has_branch(back, s.branch) || !has_branch(up, s.branch))
      continue;
    reached = true;
    if (arm_is_free(grasp, s.q)) return std::nullopt;
  }
  return reached ? EndFault::kArm : EndFault::kReach;
}

std::optional<EndFault> GraspEnd::fault(const Grasp& grasp, const Pose& T_W_O) const {
  if (const auto gripper = gripper_fault(grasp, T_W_O)) return gripper;
  return arm_fault(grasp, T_W_O * grasp.T_O_T);
}

std::vector<int> GraspEnd::serving(std::span<const Grasp> grasps, std::span<const int> among,
                                   const Pose& T_W_O, std::size_t enough) const {
  std::vector<int> found;
  for (const int i : among) {
    if (enough > 0 && found.size() >= enough) break;
    if (!fault(grasps[static_cast<std::size_t>(i)], T_W_O)) found.push_back(i);
  }
  return found;
}

bool GraspEnd::all_blocked(std::span<const Grasp> grasps, const Pose& T_W_O,
                           const Eigen::Vector3d& n_O_towards, double cone) const {
  const double min = std::cos(cone);
  std::size_t seen = 0;
  for (const Grasp& grasp : grasps) {
    if (grasp.T_O_T.linear().col(2).dot(n_O_towards) < min) continue;
    ++seen;
    const GripperCheck& check = gripper(grasp).check;
    if (!check.touches_object(T_W_O * grasp.T_O_T, fingers(grasp), options_.approach_padding)) return false;
  }
  return seen >= kManyBlocked;
}

std::shared_ptr<const GraspSet> grasps_to_pick(const GraspEnd& end, const Stone& stone,
                                               const GripperModel& gripper, const Pose& T_W_O_pick) {
  auto usual = cached_grasps(stone, gripper);
  std::vector<int> all(usual->grasps.size());
  std::iota(all.begin(), all.end(), 0);
  const std::size_t serving = end.serving(usual->grasps, all, T_W_O_pick, kFewOverTable).size();
  if (serving >= kFewOverTable) return usual;
  const auto over_table = std::count_if(usual->grasps.begin(), usual->grasps.end(), [&](const Grasp& grasp) {
    const auto fault = end.gripper_fault(grasp, T_W_O_pick);
    return fault != EndFault::kTable && fault != EndFault::kTooWeak;
  });
  GraspOptions more;
  const Eigen::Vector3d n_O_down = -T_W_O_pick.linear().row(2).transpose();
  if (static_cast<std::size_t>(over_table) >= kFewOverTable) {  // neighbouring objects obstruct it
    if (serving >= kFew || usual->grasps.empty()) return usual;
    if (end.all_blocked(usual->grasps, T_W_O_pick, n_O_down, std::numbers::pi)) return usual;
    more.directions *= kDenser;
    return cached_grasps(stone, gripper, more);
  }
  if (end.all_blocked(usual->grasps, T_W_O_pick, n_O_down, kFromAbove)) return usual;
  more.directions *= kDenserFromAbove;
  more.cone = kFromAbove;
  more.finger_clearance = kTightClearance;
  // Rounded, so that another view of the stone gives the same ones.
  more.n_O_towards = (8.0 * n_O_down).array().round().matrix().normalized();
  return std::make_shared<const GraspSet>(joined(*usual, *cached_grasps(stone, gripper, more)));
}

}  // namespace stonestack::motion
