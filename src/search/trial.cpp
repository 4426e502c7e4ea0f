#include "search/trial.hpp"

#include <algorithm>
#include <cmath>

#include "search/pose_cost.hpp"
#include "search/resting_height.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/physics/settle.hpp"

namespace stonestack {
namespace {

constexpr double kDrop = 0.001;  ///< m above the first touch
constexpr int kLonger = 4;       ///< times the perturbations, where the first of them disagree

Stack with(const Stack& stack, int stone, const Pose& T_W_O) {
  Stack higher = stack;
  higher.stones.push_back({stone, T_W_O});
  return higher;
}

/// A proposed pose lifted to just above the first touch.
Pose lifted(const SearchContext& context, const Stack& below, int stone, const Pose& T_W_O) {
  BodyPose body = body_pose(context.geometry[static_cast<std::size_t>(stone)], T_W_O);
  body.p_W_M.z() = resting_height(bodies_of(context, below), body) + kDrop;
  return stone_pose(body);
}

SettleResult let_down(const SearchContext& context, const Stack& below, int stone, const Pose& T_W_O) {
  SettleOptions options;
  options.world.friction = context.options->friction;
  return settle(context.shapes(), below, stone, lifted(context, below, stone, T_W_O), options);
}

Eigen::Vector3d com_of(const SearchContext& context, const PlacedStone& placed) {
  return placed.T_W_O * context.geometry[static_cast<std::size_t>(placed.stone)].p_O_M;
}

/// Polygon, eq. (2) and the figures beside it.
void fill_cost(const SearchContext& context, const Stack& below, const SettleResult& at_rest, Trial* trial) {
  ContactPose pose;
  pose.p_W_com = com_of(context, {trial->stone, at_rest.T_W_O});
  pose.support = support_polygon(at_rest.contacts, pose.p_W_com);
  pose.kinetic_energy = at_rest.kinetic_energy;
  pose.p_W_previous_com << context.problem->site, 0.0;
  if (!below.stones.empty()) pose.p_W_previous_com = com_of(context, below.stones.back());
  const PoseCost cost = pose_cost(pose, *context.options);
  Placement& placement = trial->placement;
  placement.stone = trial->stone;
  placement.T_W_O = at_rest.T_W_O;
  placement.cost = cost.total;
  placement.terms = cost.terms;
  placement.terms["margin"] = trial->margin;
  placement.terms["a_est"] = trial->estimate;
  placement.terms["look_ahead"] = trial->look_ahead;
  placement.terms["travel"] = at_rest.travel;
  placement.support = pose.support;
}

/// A pose displaced by the placement uncertainty, about the centre of mass.
Pose displaced(const SearchContext& context, int stone, const Pose& T_W_O, int k) {
  const SearchOptions& o = *context.options;
  Random random =
      Random::stream(static_cast<std::uint64_t>(o.seed), 0x70657274ULL + static_cast<std::uint64_t>(k));
  BodyPose body = body_pose(context.geometry[static_cast<std::size_t>(stone)], T_W_O);
  for (int axis = 0; axis < 3; ++axis) body.p_W_M[axis] += random.normal(0.0, o.placement_sigma_translation);
  Eigen::Vector3d turn;
  for (int axis = 0; axis < 3; ++axis) turn[axis] = random.normal(0.0, o.placement_sigma_rotation);
  if (turn.norm() > 1e-12)
    body.R_W_O = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix() * body.R_W_O;
  return stone_pose(body);
}

bool survives(const SearchContext& context, const Stack& below, const Trial& trial, int k) {
  const SettleResult at_rest =
      let_down(context, below, trial.stone, displaced(context, trial.stone, trial.placement.T_W_O, k));
  if (!at_rest.rests) return false;
  StandOptions stand;
  stand.friction = context.options->friction;
  stand.seconds = context.options->perturbed_seconds;
  stand.still = kStill;
  const StandVerdict verdict = judge_stack(context.shapes(), with(below, trial.stone, at_rest.T_W_O), stand);
  return verdict.stands && verdict.clean;
}

void drop(Trial* trial, const std::string& why) {
  trial->alive = false;
  trial->outcome = why;
}

}  // namespace

void settle_trial(const SearchContext& context, const Stack& below, Trial* trial) {
  const SettleResult at_rest = let_down(context, below, trial->stone, trial->T_W_O);
  trial->placement.T_W_O = at_rest.T_W_O;
  if (!at_rest.rests) return drop(trial, concat("does not come to rest: ", at_rest.reason));
  EquilibriumOptions statics;
  statics.friction = context.options->friction;
  statics.least_friction = false;
  const Equilibrium balance =
      stack_equilibrium(context.shapes(), with(below, trial->stone, at_rest.T_W_O), statics);
  trial->margin = balance.stands ? balance.margin : 0.0;
  fill_cost(context, below, at_rest, trial);
  if (!balance.stands) return drop(trial, "no contact forces hold the stack");
  if (balance.margin < context.options->least_margin)
    return drop(trial, concat("bears less than ", context.options->least_margin, " g sideways"));
  trial->score = std::min(trial->margin, context.options->friction) + trial->look_ahead;
}

void judge_trial(const SearchContext& context, const Stack& below, Trial* trial) {
  const SearchOptions& o = *context.options;
  StandOptions stand;
  stand.friction = o.friction;
  stand.seconds = o.verdict_seconds;
  stand.still = kStill;
  const StandVerdict verdict =
      judge_stack(context.shapes(), with(below, trial->stone, trial->placement.T_W_O), stand);
  if (!verdict.stands || !verdict.clean)
    return drop(trial, "the stack does not stand for the time of the verdict");
  int survived = 0;
  for (int k = 0; k < o.perturbations; ++k) {
    if (survives(context, below, *trial, k)) ++survived;
    if (survived + o.perturbations - 1 - k < o.least_success * o.perturbations) break;  // cannot be reached
  }
  trial->placement.predicted_success =
      o.perturbations > 0 ? static_cast<double>(survived) / o.perturbations : 1.0;
  trial->placement.expected_height = trial->placement.predicted_success;
  if (trial->placement.predicted_success < o.least_success)
    drop(trial, concat("falls too often when placed with the expected error"));
}

void judge_longer(const SearchContext& context, const Stack& below, Trial* trial) {
  const SearchOptions& o = *context.options;
  Placement& placement = trial->placement;
  if (!trial->alive || placement.predicted_success >= 1.0 || o.perturbations == 0) return;
  int survived = static_cast<int>(std::lround(placement.predicted_success * o.perturbations));
  const int all = kLonger * o.perturbations;
  for (int k = o.perturbations; k < all; ++k)
    if (survives(context, below, *trial, k)) ++survived;
  placement.predicted_success = static_cast<double>(survived) / all;
  placement.expected_height = placement.predicted_success;
  if (placement.predicted_success < o.least_success)
    drop(trial, "falls too often when placed with the expected error");
}

double worth(const SearchContext& context, const Trial& trial) {
  const double friction = context.options->friction;
  const double reserve = std::clamp(trial.margin / friction, 0.0, 1.0);
  const bool last = context.available.size() <= 1;
  const double prospects = last ? 1.0 : std::clamp((trial.look_ahead / friction + 0.5) / 1.5, 0.0, 1.0);
  return trial.placement.predicted_success * (0.5 + 0.5 * reserve) * (0.25 + 0.75 * prospects);
}

}  // namespace stonestack
