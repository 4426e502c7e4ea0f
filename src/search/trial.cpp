#include "search/trial.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "physics/settle.hpp"
#include "search/held_support.hpp"
#include "search/parallel.hpp"
#include "search/pose_cost.hpp"
#include "search/rest_uncertainty.hpp"
#include "search/resting_height.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::search {
namespace {

constexpr double kDrop = 0.001;  ///< distance [m] above the first touch
constexpr double kNearlyStill =
    1e-6;                   ///< motion in 0.1 s [m]: 2 % of what a stone may move in displaced worlds
constexpr int kFewer = 50;  ///< iterations, in displaced worlds

// Limits for stones of a wall that slide and tip a little when another is put on them, and rest again: on
// walls that were put down with errors they moved by 0.2 to 3.3 mm and 0.4 to 2.7 deg (design choice: twice
// that).
constexpr double kRockShift = 0.006;              // m
constexpr double kRockTurn = 6.0 * M_PI / 180.0;  // rad

/// How a placement fares where it is displaced, and shapes and centres of mass are not what they seem.
enum class Fate { kOutlasts, kStands, kFalls, kUndecidable };

Stack with(const Stack& stack, StoneIndex stone, const Pose& T_W_O) {
  Stack higher = stack;
  higher.stones.push_back({stone, T_W_O});
  return higher;
}

/// The shapes of a world, and the geometry of the stone that is placed in it.
struct Shapes {
  ShapeList list;
  const StoneGeometry* placed = nullptr;
};

Shapes shapes_as_known(const SearchContext& context, StoneIndex stone) {
  return {context.shapes(), &at(context.geometry, stone)};
}

/// In the k-th of the worlds the placed stone has one of the shapes that it may have.
Shapes possible_shapes(const SearchContext& context, StoneIndex stone, int k) {
  Shapes shapes = shapes_as_known(context, stone);
  if (context.possible_geometry.empty()) return shapes;
  const std::size_t draw = static_cast<std::size_t>(k) % context.possible_geometry.size();
  const auto& shape = at((*context.problem->possible_shapes)[draw], stone);
  if (!shape) return shapes;
  at(shapes.list, stone) = shape;
  shapes.placed = &at(context.possible_geometry[draw], stone);
  return shapes;
}

/// A proposed pose lifted to just above the first touch.
Pose lifted(const SearchContext& context, const Stack& below, const StoneGeometry& stone, const Pose& T_W_O) {
  BodyPose body = body_pose(stone, T_W_O);
  body.p_W_M.z() = resting_height(bodies_of(context, below), body) + kDrop;
  return stone_pose(body);
}

SettleResult lowered(const SearchContext& context, const Shapes& shapes, const Stack& below, StoneIndex stone,
                     const Pose& T_W_O, const Eigen::Vector3d& com_error_O = Eigen::Vector3d::Zero()) {
  SettleOptions options;
  options.world.friction = context.options->friction;
  options.com_error_O = com_error_O;
  options.any_support = !context.tower;
  return settle(shapes.list, below, stone, lifted(context, below, *shapes.placed, T_W_O), options);
}

Eigen::Vector3d com_of(const SearchContext& context, const PlacedStone& placed) {
  return placed.T_W_O * at(context.geometry, placed.stone).p_O_M;
}

/// The placement at rest, with its polygon, eq. (2) and the figures beside it.
Placement placement_of(const SearchContext& context, const Stack& below, const SettleResult& at_rest,
                       const Trial& trial) {
  ContactPose pose;
  pose.p_W_com = com_of(context, {trial.stone, at_rest.T_W_O});
  pose.support = support_polygon(at_rest.contacts, pose.p_W_com);
  pose.kinetic_energy = at_rest.kinetic_energy;
  pose.p_W_previous_com << context.problem->site, 0.0;
  if (!below.stones.empty()) pose.p_W_previous_com = com_of(context, below.stones.back());
  const PoseCost cost = pose_cost(pose, *context.options);
  Placement placement = trial.placement;
  placement.stone = trial.stone;
  placement.T_W_O = at_rest.T_W_O;
  placement.cost = cost.total;
  placement.terms = cost.terms;
  placement.terms["margin"] = trial.margin;
  placement.terms["a_est"] = trial.estimate;
  placement.terms["look_ahead"] = trial.look_ahead;
  placement.terms["travel"] = at_rest.travel;
  placement.support = pose.support;
  return placement;
}

/// A pose displaced by the placement uncertainty, about the centre of mass.
Pose displaced(const SearchContext& context, StoneIndex stone, const Pose& T_W_O, int k) {
  const SearchOptions& o = *context.options;
  Random random =
      Random::stream(static_cast<std::uint64_t>(o.seed), 0x70657274ULL + static_cast<std::uint64_t>(k));
  BodyPose body = body_pose(at(context.geometry, stone), T_W_O);
  for (int axis = 0; axis < 3; ++axis) body.p_W_M[axis] += random.normal(0.0, o.placement_sigma_translation);
  Eigen::Vector3d turn;
  for (int axis = 0; axis < 3; ++axis) turn[axis] = random.normal(0.0, o.placement_sigma_rotation);
  if (turn.norm() > 1e-12)
    body.R_W_O = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix() * body.R_W_O;
  return stone_pose(body);
}

/// How far the true centre of mass of a stone may lie from the known one, in the k-th of the worlds that are
/// tried. The same wherever the stone lies: such an error goes with the stone.
Eigen::Vector3d com_error(const SearchContext& context, StoneIndex stone, int k) {
  Random random = Random::stream(static_cast<std::uint64_t>(context.options->seed),
                                 concat("centre of mass ", stone, " ", k));
  Eigen::Vector3d error_O;
  for (int axis = 0; axis < 3; ++axis) error_O[axis] = random.normal(0.0, context.options->com_sigma);
  return error_O;
}

void let_rock(StandOptions& stand) {
  stand.max_shift = kRockShift;
  stand.max_turn = kRockTurn;
}

/// How a stack is judged in the k-th of the worlds.
StandOptions displaced_verdict(const SearchContext& context, const Stack& stack, int k, bool may_rock) {
  StandOptions stand;
  if (may_rock) let_rock(stand);
  stand.friction = context.options->friction;
  stand.seconds = context.options->perturbed_seconds;
  stand.still = kNearlyStill;
  stand.step = kVerdictStep;
  stand.iterations = kFewer;
  stand.fall = 0.0;
  stand.held = context.problem->held;
  for (const PlacedStone& placed : stack.stones)
    stand.com_error_O.push_back(com_error(context, placed.stone, k));
  return stand;
}

/// Is what stands on the held stones of a tower in the k-th of the worlds too much for them?
bool tips_held_stones(const SearchContext& context, const Stack& stack, int k) {
  const int held = context.problem->held;
  return context.tower && held > 0 &&
         tips_held(bodies_of(context, stack), stack.stones, held,
                   static_cast<std::uint64_t>(context.options->seed), k);
}

/// Does a stack stand in the k-th of the worlds?
bool stands(const SearchContext& context, const ShapeList& shapes, const Stack& stack, int k, bool may_rock) {
  if (tips_held_stones(context, stack, k)) return false;
  const StandVerdict verdict = judge_stack(shapes, stack, displaced_verdict(context, stack, k, may_rock));
  return verdict.stands && (verdict.clean || !context.tower);
}

/// How the placement fares in the k-th of the worlds, whatever the stack below would do without it.
Fate try_world(const SearchContext& context, const Candidate& candidate, int k) {
  const Stack& below = *candidate.below;
  const Trial& trial = *candidate.trial;
  const Shapes shapes = possible_shapes(context, trial.stone, k);
  const SettleResult at_rest =
      lowered(context, shapes, below, trial.stone, displaced(context, trial.stone, trial.placement.T_W_O, k),
              com_error(context, trial.stone, k));
  const Stack higher = with(below, trial.stone, at_rest.T_W_O);
  if (at_rest.rests && stands(context, shapes.list, higher, k, trial.may_rock)) {
    if (!candidate.shake) return Fate::kStands;
    const int left =
        standing_when_shaken(shapes.list, higher, displaced_verdict(context, higher, k, trial.may_rock));
    return left == static_cast<int>(higher.stones.size()) ? Fate::kOutlasts : Fate::kStands;
  }
  return Fate::kFalls;
}

/// A placement in one of the worlds.
struct TriedWorld {
  std::size_t candidate;
  int world;
  Fate fate = Fate::kFalls;
};

/// A world in which the stack falls without the new stone carries no information about this placement: the
/// stack stands already, or whether it will was counted against the stone before. Stacks are judged once in
/// each world that asks for it, and what is found is noted with the stack.
void discard_undecidable(const SearchContext& context, std::span<const Candidate> candidates,
                         std::vector<TriedWorld>& tried) {
  struct Question {
    const Candidate* candidate;  ///< one of those that are put on the stack
    int world;
    bool stands = true;
  };
  const auto stack_of = [&](const TriedWorld& one) { return candidates[one.candidate].below; };
  const auto may_fall = [&](const TriedWorld& one) {
    return one.fate == Fate::kFalls && !stack_of(one)->stones.empty() &&
           (context.options->com_sigma > 0.0 || context.problem->held > 0);
  };
  std::map<std::pair<const Stack*, int>, bool> stands_alone;
  std::vector<Question> questions;
  for (const TriedWorld& one : tried) {
    const Candidate& candidate = candidates[one.candidate];
    if (!may_fall(one) || !stands_alone.emplace(std::pair(candidate.below, one.world), true).second) continue;
    const std::map<int, bool>* known = candidate.below_stands;
    if (known != nullptr && known->contains(one.world))
      stands_alone[{candidate.below, one.world}] = known->at(one.world);
    else
      questions.push_back({&candidate, one.world});
  }
  run_tasks(context.options->threads, questions.size(), [&](std::size_t q) {
    const Candidate& asked = *questions[q].candidate;
    questions[q].stands =
        stands(context, context.shapes(), *asked.below, questions[q].world, asked.trial->may_rock);
  });
  for (const Question& answered : questions) {
    stands_alone[{answered.candidate->below, answered.world}] = answered.stands;
    if (std::map<int, bool>* known = answered.candidate->below_stands)
      (*known)[answered.world] = answered.stands;
  }
  for (TriedWorld& one : tried)
    if (may_fall(one) && !stands_alone.at({stack_of(one), one.world})) one.fate = Fate::kUndecidable;
}

/// Forces on the whole stack as it stands, but for what is held.
Equilibrium balance_of(const SearchContext& context, const Stack& stack) {
  EquilibriumOptions statics;
  statics.friction = context.options->friction;
  statics.min_friction = false;
  return stack_equilibrium(context.shapes(), stack, statics, context.problem->held);
}

/// Horizontal acceleration (g) at which a tower tips over held stones that rest as is usual; endless without.
double limit_of_held(const SearchContext& context, const Stack& stack) {
  const int held = context.problem->held;
  if (!context.tower || held == 0) return std::numeric_limits<double>::infinity();
  return tipping_limit(held_interfaces(bodies_of(context, stack), held), 0.0, Eigen::Vector3d::Zero());
}

Trial dropped(Trial trial, const std::string& why) {
  trial.alive = false;
  trial.outcome = why;
  return trial;
}

}  // namespace

Trial settled_trial(const SearchContext& context, const Stack& below, Trial trial) {
  const SettleResult at_rest =
      lowered(context, shapes_as_known(context, trial.stone), below, trial.stone, trial.T_W_O);
  trial.placement.T_W_O = at_rest.T_W_O;
  if (!at_rest.rests) return dropped(std::move(trial), concat("does not come to rest: ", at_rest.reason));
  const Equilibrium balance = balance_of(context, with(below, trial.stone, at_rest.T_W_O));
  trial.margin = balance.stands ? std::min(balance.margin,
                                           limit_of_held(context, with(below, trial.stone, at_rest.T_W_O)))
                                : 0.0;
  trial.placement = placement_of(context, below, at_rest, trial);
  if (!balance.stands) return dropped(std::move(trial), "no contact forces hold the stack");
  if (balance.margin < context.options->min_margin)
    return dropped(std::move(trial), concat("bears less than ", context.options->min_margin, " g sideways"));
  trial.turn_sigma = rest_uncertainty(context, below, {trial.stone, at_rest.T_W_O}, at_rest.contacts);
  if (trial.turn_sigma > 0.0) trial.placement.terms["turn_sigma"] = trial.turn_sigma;
  trial.score = std::min(trial.margin, context.options->friction) + trial.look_ahead;
  return trial;
}

Trial judged_trial(const SearchContext& context, const Stack& below, Trial trial) {
  const SearchOptions& o = *context.options;
  StandOptions stand;
  stand.friction = o.friction;
  stand.seconds = o.verdict_seconds;
  stand.still = kStill;
  stand.step = kVerdictStep;
  stand.fall = 0.0;
  stand.held = context.problem->held;
  if (trial.may_rock) let_rock(stand);
  Stack higher = with(below, trial.stone, trial.placement.T_W_O);
  const StandVerdict verdict = judge_stack(context.shapes(), higher, stand);
  if (!verdict.stands)
    return dropped(std::move(trial), "the stack does not stand for the time of the verdict");
  if (!verdict.clean && context.tower)
    return dropped(std::move(trial), "a stone touches more than the one below it");
  if (!trial.may_rock) return trial;
  trial.T_W_O_loaded = verdict.T_W_O;
  for (std::size_t k = 0; k < higher.stones.size(); ++k) higher.stones[k].T_W_O = verdict.T_W_O[k];
  const Equilibrium balance = balance_of(context, higher);
  trial.margin = balance.stands ? balance.margin : 0.0;
  trial.placement.terms["margin"] = trial.margin;
  if (trial.margin < o.min_margin)
    return dropped(std::move(trial), concat("bears less than ", o.min_margin, " g sideways"));
  return trial;
}

Alternative alternative_of(const Trial& trial) {
  const Placement& placement = trial.placement;
  Alternative other{trial.stone, placement.T_W_O, placement.cost, placement.terms, 0.0, 0.0, trial.outcome};
  if (trial.worlds > 0) other.predicted_success = placement.predicted_success;
  return other;
}

std::vector<Trial> predicted_trials(const SearchContext& context, std::span<const Candidate> candidates,
                                    int worlds) {
  std::vector<TriedWorld> tasks;
  for (std::size_t c = 0; c < candidates.size(); ++c)
    for (int k = candidates[c].trial->worlds; k < worlds; ++k) tasks.push_back({c, k});
  run_tasks(context.options->threads, tasks.size(), [&](std::size_t t) {
    tasks[t].fate = try_world(context, candidates[tasks[t].candidate], tasks[t].world);
  });
  discard_undecidable(context, candidates, tasks);
  std::vector<Trial> trials;
  for (const Candidate& candidate : candidates) trials.push_back(*candidate.trial);
  for (const TriedWorld& task : tasks) {
    Trial& trial = trials[task.candidate];
    trial.tried += task.fate != Fate::kUndecidable ? 1 : 0;
    trial.survived += task.fate == Fate::kStands || task.fate == Fate::kOutlasts ? 1 : 0;
    trial.shaken += task.fate == Fate::kOutlasts ? 1 : 0;
  }
  for (std::size_t c = 0; c < trials.size(); ++c) {
    Trial& trial = trials[c];
    Placement& placement = trial.placement;
    trial.worlds = std::max(trial.worlds, worlds);
    placement.predicted_success =
        trial.tried > 0 ? static_cast<double>(trial.survived) / trial.tried : (worlds > 0 ? 0.0 : 1.0);
    placement.expected_height = placement.predicted_success;
    if (candidates[c].shake && trial.tried > 0)
      placement.terms["outlasts_shake"] = static_cast<double>(trial.shaken) / trial.tried;
    if (placement.predicted_success < context.options->min_success)
      trial = dropped(std::move(trial), "falls too often when placed with the expected error");
  }
  return trials;
}

double worth(const SearchContext& context, const Trial& trial) {
  const double friction = context.options->friction;
  const double reserve = std::clamp(trial.margin / friction, 0.0, 1.0);
  const bool last = context.available.size() <= 1;
  const double prospects = last ? 1.0 : std::clamp((trial.look_ahead / friction + 0.5) / 1.5, 0.0, 1.0);
  return trial.placement.predicted_success * (0.5 + 0.5 * reserve) * (0.25 + 0.75 * prospects);
}

}  // namespace stonestack::search
