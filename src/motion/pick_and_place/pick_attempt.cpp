#include "motion/pick_and_place/pick_attempt.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/constants.hpp"
#include "motion/cartesian.hpp"
#include "motion/clearance_below.hpp"
#include "motion/constants.hpp"
#include "motion/path/round_corners.hpp"
#include "motion/timing.hpp"
#include "motion/transit.hpp"

namespace stonestack::motion {
namespace {

constexpr double kTransitSeconds = 0.5;  ///< effort for one transit of one candidate [s]
constexpr double kLittleSeconds = 0.1;   ///< the same, until a first path is found, with little effort
constexpr double kWidestBlend = 0.2;     ///< corners cut, most [rad]
constexpr std::array kLifts{1.0, 0.5};   ///< of kLiftHeight, where the arm has no clearance for more
constexpr std::array kOut{0.03, 0.06};   ///< that a stone is taken out aslant before it goes up [m]
constexpr int kWaysOut = 8;              ///< aslant, evenly about the vertical
constexpr std::array kSlants{M_PI / 4, 5 * M_PI / 12};  ///< of them from the vertical [rad]
constexpr double kRub = 0.005;      ///< of a way aslant on which the stone may touch what is beside it [m]
constexpr double kFarBelow = 10.0;  ///< distance [m] at which a table is out of the way
constexpr std::array kShorterRetreats{0.75, 0.5};  ///< of MotionOptions::approach, the same

Pose raised(const Pose& T_W_T, double by) {
  return Pose(Eigen::Translation3d(0, 0, by)) * T_W_T;
}
Pose backed(const Pose& T_W_T, double by) {
  return T_W_T * Pose(Eigen::Translation3d(0, 0, -by));
}

JointPath reversed(JointPath path) {
  std::reverse(path.begin(), path.end());
  return path;
}
JointPath joined(JointPath a, const JointPath& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

PlanningScene spaced(PlanningScene scene, double spacing) {
  scene.gripper = with_spacing(std::move(scene.gripper), spacing);
  return scene;
}

}  // namespace

const char* to_text(PathFault fault) {
  switch (fault) {
    case PathFault::kApproach:
      return "have no free straight approach";
    case PathFault::kLift:
      return "cannot be lifted";
    case PathFault::kLower:
      return "cannot be lowered straight";
    case PathFault::kRetreat:
      return "have no free retreat";
    case PathFault::kTransit:
      return "have no path to the stone";
    case PathFault::kCarry:
      return "have no path to carry the stone";
    default:
      return "are free";
  }
}

CollisionRules rules(double padding, double opening, int left_out) {
  CollisionRules r;
  r.padding = padding;
  r.opening = opening;
  r.left_out = left_out;
  return r;
}

CollisionChecker links_beside(PlanningScene alone, const MotionOptions& options, double opening) {
  alone.table_z -= kFarBelow;
  CollisionRules links = rules(options.transit_padding, opening, -1);
  links.gripper_may_touch = {0};
  return CollisionChecker(alone, links);
}

PickAttempt::PickAttempt(const PlanningScene& scene, const PickAndPlaceTask& task,
                         const MotionOptions& options, const Grasp& grasp)
    : scene_(spaced(scene, grasp.spacing)),
      task_(task),
      options_(options),
      T_W_T_pick_(task.T_W_O_pick * grasp.T_O_T),
      T_W_T_place_(task.T_W_O_place * grasp.T_O_T),
      T_T_O_(grasp.T_O_T.inverse()),
      opening_(grasp.pre_opening),
      holding_(grasp.opening),
      open_(scene_, rules(options.approach_padding, grasp.pre_opening, task.object)),
      beside_picked_([this] { return links_beside(alone(task_.T_W_O_pick), options_, opening_); }),
      beside_placed_([this] { return links_beside(alone(task_.T_W_O_place), options_, opening_); }),
      open_wide_([this] { return empty_gripper(options_.transit_padding); }),
      open_tight_([this] { return empty_gripper(options_.approach_padding); }),
      held_([this] { return loaded_gripper(options_.approach_padding); }),
      held_wide_([this] { return loaded_gripper(options_.transit_padding); }) {}

CollisionChecker PickAttempt::empty_gripper(double padding) const {
  return CollisionChecker(scene_, rules(padding, opening_, -1));
}

CollisionChecker PickAttempt::loaded_gripper(double padding) const {
  const HeldObject held{task_.stone->name, task_.stone->pieces, T_T_O_};
  return CollisionChecker(scene_, rules(padding, holding_, task_.object), &held);
}

std::optional<JointPath> PickAttempt::straight(const Joints& q, const Pose& T_W_T) const {
  return straight_path(scene_.robot, scene_.T_F_T, q, scene_.T_W_R.inverse() * T_W_T);
}

std::optional<JointPath> PickAttempt::raised_straight(const Joints& q, const Pose& T_W_T) const {
  for (const double share : kLifts)
    if (auto path = straight(q, raised(T_W_T, share * kLiftHeight)); path && is_free(held_.get(), *path))
      return path;
  return std::nullopt;
}

std::optional<JointPath> PickAttempt::lifted(const Joints& q_pick) const {
  const double zone = std::min(kContactZone, kLiftHeight);
  if (auto loose = straight(q_pick, raised(T_W_T_pick_, zone)); loose && is_free(open_, *loose))
    if (const auto up = raised_straight(loose->back(), T_W_T_pick_)) return joined(std::move(*loose), *up);
  return lifted_aslant(q_pick);
}

std::optional<JointPath> PickAttempt::lifted_aslant(const Joints& q_pick) const {
  struct Way {
    Eigen::Vector3d along = Eigen::Vector3d::UnitZ();
    JointPath loose;
    double clearance = 0.0;
  };
  const auto out = [&](const Way& way, double by) {
    return Pose(Eigen::Translation3d(by * way.along) * T_W_T_pick_);
  };
  std::vector<Way> ways;
  for (const double slant : kSlants)
    for (int k = 0; k < kWaysOut; ++k) {
      const double azimuth = kTwoPi * k / kWaysOut;
      Way way;
      way.along << std::sin(slant) * std::cos(azimuth), std::sin(slant) * std::sin(azimuth), std::cos(slant);
      auto loose = straight(q_pick, out(way, kContactZone));
      if (!loose || !is_free(open_, *loose)) continue;
      way.clearance = held_.get().clearance(loose->back()).distance;
      way.loose = *std::move(loose);
      ways.push_back(std::move(way));
    }
  // The one that leads away from what is beside the stone first.
  std::stable_sort(ways.begin(), ways.end(),
                   [](const Way& a, const Way& b) { return a.clearance > b.clearance; });
  for (const Way& way : ways) {
    if (!comes_away(held_.get(), way.loose)) continue;
    for (const double by : kOut) {
      const auto clear = straight(way.loose.back(), out(way, by));
      if (!clear || !is_free(held_.get(), *clear)) break;
      if (const auto up = raised_straight(clear->back(), out(way, by)))
        return joined(joined(way.loose, *clear), *up);
    }
  }
  return std::nullopt;
}

std::optional<JointPath> PickAttempt::descend_past(const Joints& q) const {
  const double clearance = clearance_below(scene_, q, holding_, task_.object, options_.descent_past);
  return straight(q, raised(T_W_T_place_, -clearance));
}

std::optional<JointPath> PickAttempt::retreat(const Joints& q) const {
  const auto back = [&](double share) -> std::optional<JointPath> {
    auto path = straight(q, backed(T_W_T_place_, share * options_.approach));
    return path && is_free(open_, *path) && is_free(beside_placed_.get(), *path) ? path : std::nullopt;
  };
  if (auto whole = back(1.0)) return whole;
  std::optional<CollisionChecker> clear;
  for (const double share : kShorterRetreats) {
    auto path = back(share);
    if (!path) continue;
    if (!clear) clear.emplace(alone(task_.T_W_O_place), rules(options_.transit_padding, opening_, -1));
    if (!clear->collides(path->back())) return path;
  }
  return std::nullopt;
}

PlanningScene PickAttempt::alone(const Pose& T_W_O) const {
  PlanningScene scene = scene_;
  scene.objects = {{task_.stone->name, task_.stone->pieces, T_W_O}};
  return scene;
}

/// The parts with straight tool motion: where the arm may be in them is given, so they fail early.
PathFault PickAttempt::straight_parts(const Joints& q_pick, const Joints& q_place, PickPaths& paths) const {
  const double zone = std::min(kContactZone, kLiftHeight);
  const auto back = straight(q_pick, backed(T_W_T_pick_, options_.approach));
  if (!back || !is_free(open_, *back) || !is_free(beside_picked_.get(), *back)) return PathFault::kApproach;
  const auto lift = lifted(q_pick);
  if (!lift) return PathFault::kLift;

  const auto near = straight(q_place, raised(T_W_T_place_, zone));
  if (!near || !is_free(open_, *near)) return PathFault::kLower;
  const auto high = raised_straight(near->back(), T_W_T_place_);
  if (!high) return PathFault::kLower;
  const auto back_out = retreat(q_place);
  if (!back_out) return PathFault::kRetreat;
  // The guarded part starts at a waypoint of its own, so that it can be timed by itself.
  const auto start = straight(q_place, raised(T_W_T_place_, kDescentLength));
  if (!start) return PathFault::kLower;
  const auto past = descend_past(q_place);
  if (!past) return PathFault::kLower;
  const auto lower = straight(high->back(), raised(T_W_T_place_, kDescentLength));
  if (!lower) return PathFault::kLower;

  paths.approach = reversed(*back);
  paths.lift = *lift;
  paths.lower = *lower;
  paths.descent = joined(reversed(*start), *past);
  paths.descent.front() = paths.lower.back();
  paths.retreat = *back_out;
  return PathFault::kNone;
}

std::optional<Transit> PickAttempt::transit(const LazyChecker& wide, const LazyChecker& tight,
                                            const Joints& a, const Joints& b, Effort effort) const {
  // An end that is nearer to something than the padding of a transit leaves no choice.
  const bool near = wide.get().collides(a) || wide.get().collides(b);
  const CollisionChecker& checker = near ? tight.get() : wide.get();
  MotionOptions options = options_;  // a grasp whose path is hard to find is postponed
  options.planning_effort = std::min(options.planning_effort, kTransitSeconds);
  const double first = effort == Effort::kLittle ? kLittleSeconds : kTransitSeconds;
  auto path = find_path(checker, a, std::span(&b, 1), options, first);
  if (!path) return std::nullopt;
  Transit transit{std::move(*path), 0.0};
  TimingLimits limits = timing_limits(scene_.robot, options_);
  limits.blend = kWidestBlend;
  transit.blend = free_blend(checker, transit.path, limits);
  return transit;
}

PickAttempt::Result PickAttempt::try_joints(const Joints& q_pick, const Joints& q_place,
                                            Effort effort) const {
  Result result;
  result.fault = straight_parts(q_pick, q_place, result.paths);
  if (result.fault != PathFault::kNone) return result;
  PickPaths& paths = result.paths;
  const auto to_pick = transit(open_wide_, open_tight_, task_.q_start, paths.approach.front(), effort);
  const auto carry =
      to_pick ? transit(held_wide_, held_, paths.lift.back(), paths.lower.front(), effort) : std::nullopt;
  if (!carry) {
    result.fault = to_pick ? PathFault::kCarry : PathFault::kTransit;
    return result;
  }
  paths.to_pick = *to_pick;
  paths.carry = *carry;
  return result;
}

}  // namespace stonestack::motion
