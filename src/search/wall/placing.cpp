#include "search/wall/placing.hpp"

#include <algorithm>

#include "physics/shape.hpp"
#include "search/constants.hpp"
#include "search/orientations.hpp"
#include "search/parallel.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::search {
namespace {

constexpr double kAsPlanned = 0.015;  // m that a stone may come to rest beside where it was planned

constexpr double kCloseGap = 0.001;  // m between stones that counts as resting on each other

}  // namespace

WallStonePlaced standing(const SearchContext& context, const PlacedStone& stone, int course) {
  const StoneGeometry& geometry = at(context.geometry, stone.stone);
  const BodyPose body = body_pose(geometry, stone.T_W_O);
  return placed_in_wall({stone.stone, &geometry, {}}, standing_side(context, geometry, body.R_W_O),
                        body.R_W_O, body.p_W_M, course);
}

WallState standing_state(const SearchContext& context, const WallBegun& begun) {
  WallState state;
  const Pose T_V_W = begun.T_W_V.inverse();
  for (std::size_t k = 0; k < context.stack.stones.size(); ++k) {
    const PlacedStone& stone = context.stack.stones[k];
    state.stones.push_back(standing(context, {stone.stone, T_V_W * stone.T_W_O}, begun.courses[k]));
    state.trials.emplace_back();
    state.compared.emplace_back();
  }
  return state;
}

std::vector<std::vector<int>> rests_upon(const SearchContext& context, const WallState& state) {
  std::vector<std::vector<int>> supports(state.stones.size());
  for (const Contact& contact : geometric_contacts(context.shapes(), state.stack(), kCloseGap)) {
    auto& list = supports[static_cast<std::size_t>(contact.above)];
    if (contact.below == kTable || contact.n_W.z() < 0.3) continue;
    if (std::find(list.begin(), list.end(), contact.below) == list.end()) list.push_back(contact.below);
  }
  return supports;
}

SearchContext wall_context(const SearchProblem& problem, const SearchOptions& options,
                           const std::function<void(const std::string&)>& report) {
  SearchContext context = make_context(problem, options, report);
  context.tower = false;
  return context;
}

Pose frame_of(const WallTarget& target, const Eigen::Vector2d& site, double middle) {
  Pose T_W_V = Pose::Identity();
  T_W_V.linear() = yaw_rotation(target.yaw);
  T_W_V.translation() << target.centre_W.value_or(site), 0.0;
  return T_W_V * Eigen::Translation3d(-middle, 0.0, 0.0);
}

std::vector<Alternative> compared_in(const std::vector<Settled>& list, std::size_t chosen,
                                     const std::vector<Alternative>& refused) {
  std::vector<Alternative> others;
  for (std::size_t k = 0; k < list.size() && others.size() < kMaxAlternatives; ++k)
    if (k != chosen) others.push_back(alternative_of(list[k].trial));
  for (std::size_t k = 0; k < refused.size() && others.size() < kMaxAlternatives; ++k)
    others.push_back(refused[k]);
  return others;
}

WallPlacement in_world(const Pose& T_W_V, WallPlacement placement,
                       const std::shared_ptr<const std::vector<Alternative>>& compared) {
  Placement& chosen = placement.placement;
  chosen.T_W_O = T_W_V * chosen.T_W_O;
  chosen.support.p_W_centroid = T_W_V * chosen.support.p_W_centroid;
  chosen.support.n_W = T_W_V.linear() * chosen.support.n_W;
  for (Eigen::Vector3d& corner : chosen.support.corners_W) corner = T_W_V * corner;
  if (!compared) return placement;
  placement.alternatives = *compared;
  for (Alternative& other : placement.alternatives) other.T_W_O = T_W_V * other.T_W_O;
  return placement;
}

WallState with(const WallState& state, const Settled& next, std::vector<Alternative> compared) {
  WallState higher = state;
  higher.stones.push_back(next.placed);
  higher.trials.push_back(next.trial);
  higher.compared.push_back(
      compared.empty() ? nullptr : std::make_shared<const std::vector<Alternative>>(std::move(compared)));
  return higher;
}

bool Placing::is_reachable(const Placement& placement, const Stack& below_V) const {
  if (!context_.problem->reachable) return true;
  Stack below = context_.stack;  // in W; what the search has put there follows
  for (std::size_t k = below.stones.size(); k < below_V.stones.size(); ++k)
    below.stones.push_back({below_V.stones[k].stone, *T_W_V_ * below_V.stones[k].T_W_O});
  return context_.problem->reachable(placement.stone, placement.T_W_O, below);
}

void Placing::refuse(Alternative other) {
  if (refused.size() < kMaxAlternatives) refused.push_back(std::move(other));
}

std::vector<WallProposal> Placing::reachable(std::vector<WallProposal> list, const Stack& below,
                                             std::size_t keep) {
  refused.clear();
  if (!context_.problem->reachable) {
    list.resize(std::min(list.size(), keep));
    return list;
  }
  std::vector<WallProposal> kept;
  for (WallProposal& made : list) {
    if (kept.size() == keep) break;
    throw_if_interrupted();
    Placement placement;
    placement.stone = made.proposal.stone;
    placement.T_W_O = *T_W_V_ * stone_pose(made.proposal.body);
    if (is_reachable(placement, below))
      kept.push_back(std::move(made));
    else {
      ++unreachable;
      refuse({placement.stone,
              stone_pose(made.proposal.body),
              0.0,
              {},
              0.0,
              0.0,
              "the arm does not bring it there"});
    }
  }
  return kept;
}

std::vector<Settled> Placing::settled(const Stack& below, const std::vector<WallProposal>& proposals,
                                      int course) {
  std::vector<Settled> list(proposals.size());
  run_tasks(context_.options->threads, list.size(), [&](std::size_t k) {
    const WallProposal& made = proposals[k];
    Trial trial;
    trial.stone = made.proposal.stone;
    trial.T_W_O = stone_pose(made.proposal.body);
    trial.estimate = made.proposal.robust;
    list[k].trial = settled_trial(context_, below, std::move(trial));
    if (!list[k].trial.alive) return;
    const BodyPose body = body_pose(*made.stone->geometry, list[k].trial.placement.T_W_O);
    list[k].placed = placed_in_wall(*made.stone, *made.side, body.R_W_O, body.p_W_M, course);
  });
  for (const Settled& one : list)
    if (!one.trial.alive) {
      reason = one.trial.outcome;
      refuse(alternative_of(one.trial));
    }
  std::erase_if(list, [](const Settled& one) { return !one.trial.alive; });
  return list;
}

bool Placing::judge(const Stack& below, Settled& next) {
  ++judged;
  next.trial = judged_trial(context_, below, std::move(next.trial));
  if (next.trial.alive && context_.options->perturbations > 0) {
    const Candidate candidate{&below, &next.trial};
    next.trial = predicted_trials(context_, {&candidate, 1}, context_.options->perturbations).front();
  }
  if (!next.trial.alive) reason = next.trial.outcome;
  return next.trial.alive;
}

bool Placing::holds(const WallState& state, Settled& next) {
  const Stack below = state.stack();
  Settled rocking = next;
  if (judge(below, next)) return true;
  if (!may_rock) return false;
  rocking.trial.may_rock = true;
  next = std::move(rocking);
  return judge(below, next);
}

WallState Placing::loaded(const WallState& state, const Settled& next,
                          std::vector<Alternative> compared) const {
  WallState higher = with(state, next, std::move(compared));
  for (std::size_t k = 0; k < next.trial.T_W_O_loaded.size(); ++k)
    higher.stones[k] =
        standing(context_, {higher.stones[k].stone, next.trial.T_W_O_loaded[k]}, higher.stones[k].course);
  return higher;
}

std::optional<Settled> Placing::as_planned(const WallState& state, const WallPlacement& planned, bool ask) {
  const Stack below = state.stack();
  const Placement& placement = planned.placement;
  if (ask && !is_reachable(placement, below)) {
    reason = "the arm does not bring the next stone to its place";
    return std::nullopt;
  }
  Settled next;
  next.trial.stone = placement.stone;
  next.trial.T_W_O = T_W_V_->inverse() * placement.T_W_O;
  next.trial = settled_trial(context_, below, std::move(next.trial));
  if (next.trial.alive &&
      (next.trial.placement.T_W_O.translation() - next.trial.T_W_O.translation()).norm() > kAsPlanned) {
    next.trial.alive = false;
    next.trial.outcome = "a stone comes to rest beside where it was planned";
  }
  if (!next.trial.alive) {
    reason = next.trial.outcome;
    return std::nullopt;
  }
  if (!holds(state, next)) return std::nullopt;
  next.placed = standing(context_, {placement.stone, next.trial.placement.T_W_O}, planned.course);
  return next;
}

std::vector<Alternative> Placing::compared_with(const WallPlacement& planned) const {
  std::vector<Alternative> alternatives = planned.alternatives;
  const Pose T_V_W = T_W_V_->inverse();
  for (Alternative& other : alternatives) other.T_W_O = T_V_W * other.T_W_O;
  return alternatives;
}

}  // namespace stonestack::search
