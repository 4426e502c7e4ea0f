#include "motion/turn_over.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/constants.hpp"
#include "geometry/polygon.hpp"
#include "motion/grasp/grasp_end.hpp"
#include "motion/pick_and_place/set_down.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"

namespace stonestack::motion {
namespace {

constexpr double kTipStep = 0.026;    // rad
constexpr double kTouching = 0.0025;  // m above the lowest point: carries it, too
constexpr int kMaxTipSteps = 200;
constexpr int kAxes = 24;                // level axes that a stone is turned about
constexpr double kMinTurn = 0.6;         // rad: less brings no other side up
constexpr double kMaxTurn = 1.5;         // rad
constexpr double kTurnStep = 0.14;       // rad; beyond an edge by ...
constexpr int kSurelyBeyond = 2;         // ... so many of them a stone is sure to fall over, and by ...
constexpr int kBeyond = 1;               // ... so many a flat one may
constexpr double kSameSide = 0.35;       // rad between two rests on one side
constexpr double kRoomToFall = 0.05;     // m
constexpr std::size_t kPlacesEach = 24;  // that are tried for each way
constexpr int kMaxPlans = 10;            // from each height
constexpr std::array kLetGoAbove{0.0, 0.01, 0.02};  // m above the table: no higher than the gripper needs
constexpr double kDescentAbove = 0.002;             // m further down, at most

Eigen::Vector3d up_in(const Eigen::Quaterniond& R_W_O) {
  return R_W_O.conjugate() * Eigen::Vector3d::UnitZ();
}

bool same_side(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  return up_in(a).dot(up_in(b)) > std::cos(kSameSide);
}

/// Point of a convex outline (or of the segment or point that it may be) nearest to `p`; `p` if it is inside.
Eigen::Vector2d nearest_on(const Polygon2& outline, const Eigen::Vector2d& p) {
  bool inside = outline.size() >= 3;
  Eigen::Vector2d nearest = outline.front();
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d& a = outline[i];
    const Eigen::Vector2d side = outline[(i + 1) % outline.size()] - a;
    if (side.x() * (p - a).y() - side.y() * (p - a).x() < 0) inside = false;
    const double along =
        side.squaredNorm() < 1e-12 ? 0.0 : std::clamp(side.dot(p - a) / side.squaredNorm(), 0.0, 1.0);
    const Eigen::Vector2d q = a + along * side;
    if ((q - p).squaredNorm() < (nearest - p).squaredNorm()) nearest = q;
  }
  return inside ? p : nearest;
}

/// Turned about a level axis until it falls over an edge, beyond which it is turned by `beyond` steps.
std::optional<TurnTo> falling_over(const Stone& stone, const Eigen::Quaterniond& R_W_O, double axis,
                                   int beyond) {
  const Eigen::Vector3d n_W(std::cos(axis), std::sin(axis), 0.0);
  std::optional<Eigen::Quaterniond> last;  // where it came to lie turned a step less
  int same = 0;  // steps of turning that changed nothing about where it comes to lie
  for (double turn = kMinTurn; turn <= kMaxTurn; turn += kTurnStep) {
    const Eigen::Quaterniond let_go(Eigen::AngleAxisd(turn, n_W) * R_W_O);
    const Eigen::Quaterniond rest = tipped_over(stone, let_go);
    same = last && same_side(rest, *last) ? same + 1 : 0;
    if (!same_side(rest, R_W_O) && same >= beyond)
      return TurnTo{let_go, rest, kRoomToFall, beyond >= kSurelyBeyond};
    last = rest;
  }
  return std::nullopt;
}

}  // namespace

Eigen::Quaterniond tipped_over(const Stone& stone, Eigen::Quaterniond R_W_O) {
  for (int step = 0; step < kMaxTipSteps; ++step) {
    double lowest = std::numeric_limits<double>::infinity();
    for (const auto& v : stone.mesh.vertices) lowest = std::min(lowest, (R_W_O * v).z());
    std::vector<Eigen::Vector2d> support;
    for (const auto& v : stone.mesh.vertices)
      if (const Eigen::Vector3d p = R_W_O * v; p.z() < lowest + kTouching) support.push_back(p.head<2>());
    const Eigen::Vector2d middle = (R_W_O * stone.mass.p_O_M).head<2>();
    const Eigen::Vector2d over = middle - nearest_on(convex_hull(support), middle);
    if (over.norm() < 1e-6) break;
    const Eigen::Vector2d towards = over.normalized();
    R_W_O = Eigen::Quaterniond(Eigen::AngleAxisd(kTipStep, Eigen::Vector3d(-towards.y(), towards.x(), 0.0))) *
            R_W_O;
  }
  return R_W_O.normalized();
}

std::vector<TurnTo> ways_to_turn(const Stone& stone, const Eigen::Quaterniond& R_W_O) {
  std::vector<TurnTo> ways;
  const RegraspOptions firm;
  for (const RestPose& rest : rest_poses(stone))
    if (!same_side(rest.R_W_O, R_W_O) && rest.margin > firm.min_margin && rest.tilt > firm.min_tilt)
      ways.push_back({rest.R_W_O, rest.R_W_O, firm.apart, true});
  for (int k = 0; k < kAxes; ++k) {
    const double axis = kTwoPi * k / kAxes;
    auto falls = falling_over(stone, R_W_O, axis, kSurelyBeyond);
    if (!falls) falls = falling_over(stone, R_W_O, axis, kBeyond);
    if (falls) ways.push_back(*falls);
  }
  return ways;
}

std::optional<TurnPlan> plan_turn(const PlanningScene& scene, const PickAndPlaceTask& task,
                                  std::span<const TurnTo> ways, const MotionOptions& options) {
  require(task.stone != nullptr, "a task needs a stone");
  const PickSide pick(scene, *task.stone, task.object, task.T_W_O_pick, options);
  std::vector<int> all(pick.set->grasps.size());
  std::iota(all.begin(), all.end(), 0);
  const auto from = pick.end.serving(pick.set->grasps, all, task.T_W_O_pick);
  PickAndPlaceTask leg = task;
  leg.support = -1;
  leg.T_W_O_place = make_pose({100.0, 0.0, 0.0});  // where the stone lies is free for it
  int all_plans = 0;
  for (const double height : kLetGoAbove) {
    MotionOptions motion = options;
    // Held so far above the table because the gripper cannot go lower.
    if (height > 0) motion.descent_past = std::min(motion.descent_past, kDescentAbove);
    int plans = 0;
    for (const TurnTo& way : ways) {
      if (from.empty() || plans >= kMaxPlans) break;
      RegraspOptions room;
      room.apart = way.apart;
      auto places = SetDownPlaces(scene, leg, room).poses(way.R_W_O);
      for (std::size_t k = 0; k < std::min(places.size(), kPlacesEach) && plans < kMaxPlans; ++k) {
        throw_if_interrupted();
        places[k].translation().z() += height;
        if (pick.end.serving(pick.set->grasps, from, places[k], 1).empty()) continue;
        ++plans, ++all_plans;
        PickAndPlaceTask turned = leg;
        turned.T_W_O_place = places[k];
        PickAndPlacePlan plan = plan_pick_and_place(scene, turned, motion);
        if (plan.status != PickAndPlacePlan::Status::kPlanned) continue;
        // Let go of as it was turned about the vertical for this place.
        const Eigen::Quaterniond yaw = Eigen::Quaterniond(places[k].linear()) * way.R_W_O.conjugate();
        const Eigen::Vector2d p_W_M = (places[k] * task.stone->mass.p_O_M).head<2>();
        return TurnPlan{std::move(plan), way,
                        standing(*task.stone, yaw * way.R_W_O_rest, p_W_M, scene.table_z), height};
      }
    }
  }
  log_debug(concat(task.stone->name, ": ", all.size(), " grasps, ", from.size(), " lift it; ", ways.size(),
                   " ways to turn it, ", all_plans, " plans tried"));
  return std::nullopt;
}

}  // namespace stonestack::motion
