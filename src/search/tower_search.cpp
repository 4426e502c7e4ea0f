#include "search/tower_search.hpp"

#include <algorithm>

#include "search/orientations.hpp"
#include "search/parallel.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack {
namespace {

constexpr int kProposalsPerStone = 16;
constexpr double kFlatSide = 0.2;  ///< rise over run: the look-ahead asks only sides that nearly lie flat
constexpr int kTableYaws = 4;      ///< a first stone may be turned freely: variety for the arm
constexpr std::size_t kAskedPerSettled = 3;  ///< reach is asked at most so many times for each wanted
constexpr int kTurns = 4;                    ///< times `settled` proposals are kept for a tower
constexpr double kCrowding = 0.1;            ///< of the friction: TowerTree::choose

/// Takes the best `count` of what was proposed for a tower and not tried yet; no stone gets more than twice
/// its share.
std::vector<Trial> next_turn(TowerNode* node, int count) {
  const int most = std::max(2, 2 * count / std::max(1, static_cast<int>(node->left.size())));
  std::map<int, int> of_stone;
  std::vector<Trial> turn, rest;
  for (Trial& trial : node->spare) {
    const bool taken = static_cast<int>(turn.size()) < count && of_stone[trial.stone] < most;
    if (taken) ++of_stone[trial.stone];
    (taken ? turn : rest).push_back(std::move(trial));
  }
  node->spare = std::move(rest);
  return turn;
}

std::vector<int> used_stones(const Stack& stack) {
  std::vector<int> used;
  for (const PlacedStone& placed : stack.stones) used.push_back(placed.stone);
  return used;
}

}  // namespace

TowerSearch::TowerSearch(const SearchContext& context, int levels)
    : context_(context),
      levels_(std::min(levels, static_cast<int>(context.available.size()))),
      tree_(context.stack, context.available) {}

void TowerSearch::survey() {
  if (look_ahead_) return;
  loose_ = loose_stones(context_);
  look_ahead_.emplace(on_resting_sides(loose_, kFlatSide, *context_.options), *context_.options);
  store_survey(&loose_, *context_.options);
}

void TowerSearch::run(Ways ways) {
  survey();
  const SearchOptions& o = *context_.options;
  if (ways != Ways::kNew && (finish_way_up() || ways == Ways::kFoundBefore)) return;
  const int root[] = {0};
  tree_.set_grown(0);
  grow(root);
  int more = o.firm_rounds;
  for (int k = 0; k < o.rounds && !context_.out_of_time(); ++k) {
    const std::size_t before = static_cast<std::size_t>(tree_.size()) + dropped_.size();
    round(static_cast<std::size_t>(o.beam));
    context_.say(concat("round ", k + 1, ": ", tree_.size() - 1, " towers grown, the highest of ",
                        tree_.node(best_).level, " of ", levels_, " stones"));
    const bool exhausted = static_cast<std::size_t>(tree_.size()) + dropped_.size() == before;
    const bool finished = tree_.node(best_).level == levels_;
    const bool firm = finished && (tree_.node(best_).trial.margin >= o.firm_margin || more == 0);
    if (firm || exhausted) break;
    if (finished) --more;
  }
}

int TowerSearch::climb(int node, const PlacedStone& next, std::string* reason) {
  const auto& left = tree_.node(node).left;
  const auto& reachable = context_.problem->reachable;
  if (std::none_of(left.begin(), left.end(), [&](const auto& s) { return s.stone == next.stone; })) {
    *reason = "a stone of the plan is not there any more";
    return -1;
  }
  if (reachable && !reachable(next.stone, next.T_W_O, tree_.node(node).stack)) {
    *reason = "the arm does not reach the plan any more";
    ++unreachable_;
    return -1;
  }
  Trial trial;
  trial.stone = next.stone;
  trial.T_W_O = next.T_W_O;
  settle_trial(context_, tree_.node(node).stack, &trial);
  *reason = trial.outcome;
  if (!trial.alive) return -1;
  const int higher = tree_.add(node, std::move(trial), 0.0);
  judge(std::span<const int>(&higher, 1));
  *reason = tree_.node(higher).trial.outcome;
  return tree_.node(higher).trial.alive ? higher : -1;
}

bool TowerSearch::follow(std::span<const PlacedStone> plan, std::string* reason) {
  int top = 0;
  for (const PlacedStone& next : plan) {
    top = climb(top, next, reason);
    if (top < 0) return false;
  }
  best_ = top;
  *reason = "it falls too often";  // if a closer look should say so
  return top > 0;
}

bool TowerSearch::finish_way_up() {
  std::string reason;
  int top = 0;
  for (const PlacedStone& next : context_.problem->way_up) {
    const int higher = climb(top, next, &reason);
    if (higher < 0) break;
    top = higher;
    tree_.set_grown(top);
    note_best(std::span<const int>(&top, 1));
  }
  const int level = tree_.node(top).level;
  if (top == 0 || level == levels_) return top > 0;
  grow(std::span<const int>(&top, 1));
  round(static_cast<std::size_t>(context_.options->beam), level + 1);
  context_.say(concat("from the way found before: the highest of ", tree_.node(best_).level, " of ", levels_,
                      " stones"));
  return tree_.node(best_).level == levels_;
}

void TowerSearch::round(std::size_t width, int first) {
  const double step = kCrowding * context_.options->friction;
  for (int level = first; level <= levels_; ++level) {
    std::vector<int> ready;
    // What does not bear judgement makes room for the next.
    for (std::size_t tries = 0; tries < 4 && ready.size() < width && !context_.out_of_time(); ++tries) {
      const std::vector<int> chosen = tree_.choose(level, width - ready.size(), step);
      if (chosen.empty()) break;
      judge(chosen);
      for (const int k : chosen)
        if (tree_.node(k).trial.alive) {
          ready.push_back(k);
          tree_.set_grown(k);
        }
    }
    note_best(ready);
    if (level < levels_) grow(ready);
  }
}

void TowerSearch::judge(std::span<const int> nodes) {
  run_tasks(context_.options->threads, nodes.size(), [&](std::size_t k) {
    TowerNode& node = tree_.node(nodes[k]);
    if (node.judged) return;
    judge_trial(context_, tree_.node(node.parent).stack, &node.trial);
    node.judged = true;
  });
  drop_fallen(nodes);
}

void TowerSearch::judge_longer(std::span<const int> nodes) {
  run_tasks(context_.options->threads, nodes.size(), [&](std::size_t k) {
    TowerNode& node = tree_.node(nodes[k]);
    if (node.judged) stonestack::judge_longer(context_, tree_.node(node.parent).stack, &node.trial);
  });
  drop_fallen(nodes);
}

void TowerSearch::drop_fallen(std::span<const int> nodes) {
  for (const int k : nodes)
    if (!tree_.node(k).trial.alive) dropped_.push_back({tree_.node(k).level, tree_.node(k).trial});
}

void TowerSearch::note_best(std::span<const int> nodes) {
  const auto worth = [&](int k) {
    double chance = 1.0;
    for (const int at : tree_.way_to(k)) chance *= tree_.node(at).trial.placement.predicted_success;
    const double reserve = std::min(tree_.node(k).trial.margin / context_.options->friction, 1.0);
    return std::pair(tree_.node(k).level, chance * (0.5 + 0.5 * reserve));
  };
  for (const int k : nodes)
    if (best_ == 0 || worth(k) > worth(best_)) best_ = k;
}

bool TowerSearch::accepts(const Proposal& proposal, const Stack& below, Trial* trial) {
  const auto& reachable = context_.problem->reachable;
  const int yaws = below.stones.empty() && reachable ? kTableYaws : 1;
  for (int yaw = 0; yaw < yaws; ++yaw) {
    BodyPose body = proposal.body;
    body.R_W_O = yaw_rotation(6.283185307179586 * yaw / yaws) * body.R_W_O;
    trial->T_W_O = stone_pose(body);
    if (!reachable || reachable(proposal.stone, trial->T_W_O, below)) return true;
    ++unreachable_;
  }
  return false;
}

std::vector<Trial> TowerSearch::offers(int k) {
  survey();
  const SearchOptions& o = *context_.options;
  const TowerNode& node = tree_.node(k);
  const std::vector<BodyPose> bodies = bodies_of(context_, node.stack);
  std::vector<LooseStone> stones;
  for (const LooseStone& stone : loose_)
    if (std::any_of(node.left.begin(), node.left.end(),
                    [&](const auto& s) { return s.stone == stone.stone; }))
      stones.push_back(stone);
  std::vector<Proposal> proposals =
      propose(bodies, stones, context_.problem->site, kProposalsPerStone, o, &candidates_);
  const std::vector<int> used = used_stones(node.stack);
  std::vector<long> counts(proposals.size(), 0);
  run_tasks(o.threads, proposals.size(), [&](std::size_t p) {
    Proposal& proposal = proposals[p];
    std::vector<BodyPose> higher = bodies;
    higher.push_back(proposal.body);
    std::vector<int> gone = used;
    gone.push_back(proposal.stone);
    if (stones.size() > 1)
      proposal.look_ahead = look_ahead_->estimate(higher, gone, LookAheadEffort::kQuick, &counts[p]);
    // On the table every estimate is the friction: the margin tells the stones apart.
    const double base = bodies.empty() ? std::min(0.3, proposal.landing.margin / proposal.landing.lever) / 3.0
                                       : proposal.robust;
    proposal.score = std::min(base, o.friction) + proposal.look_ahead;
  });
  for (const long count : counts) candidates_ += count;
  std::stable_sort(proposals.begin(), proposals.end(),
                   [](const Proposal& p, const Proposal& q) { return p.score > q.score; });
  return reachable_trials(proposals, node.stack);
}

/// In turns of `settled`, of which no stone gets more than twice its share.
std::vector<Trial> TowerSearch::reachable_trials(const std::vector<Proposal>& proposals, const Stack& below) {
  const auto wanted = static_cast<std::size_t>(kTurns * context_.options->settled);
  std::vector<Trial> trials;
  std::size_t asked = 0;
  for (const Proposal& proposal : proposals) {
    if (trials.size() == wanted || asked == kAskedPerSettled * wanted) break;
    throw_if_interrupted();
    ++asked;
    Trial trial;
    if (!accepts(proposal, below, &trial)) continue;
    trial.stone = proposal.stone;
    trial.estimate = proposal.robust;
    trial.look_ahead = proposal.look_ahead;
    trials.push_back(std::move(trial));
  }
  return trials;
}

void TowerSearch::grow(std::span<const int> nodes) {
  const SearchOptions& o = *context_.options;
  std::vector<Offer> made;
  for (const int k : nodes) {
    if (context_.out_of_time()) break;
    TowerNode& node = tree_.node(k);
    if (node.grown == 1) node.spare = offers(k);
    for (Trial& trial : next_turn(&node, o.settled)) made.push_back({k, std::move(trial)});
  }
  std::vector<long> counts(made.size(), 0);
  run_tasks(o.threads, made.size(), [&](std::size_t k) {
    Trial& trial = made[k].trial;
    const TowerNode& below = tree_.node(made[k].node);
    settle_trial(context_, below.stack, &trial);
    if (!trial.alive || below.left.size() < 2) return;
    std::vector<BodyPose> bodies = bodies_of(context_, below.stack);
    bodies.push_back(
        body_pose(context_.geometry[static_cast<std::size_t>(trial.stone)], trial.placement.T_W_O));
    std::vector<int> used = used_stones(below.stack);
    used.push_back(trial.stone);
    trial.look_ahead = look_ahead_->estimate(bodies, used, LookAheadEffort::kFull, &counts[k]);
    trial.placement.terms["look_ahead"] = trial.look_ahead;
  });
  for (std::size_t k = 0; k < made.size(); ++k) {
    candidates_ += counts[k];
    Trial& trial = made[k].trial;
    if (trial.alive)  // beyond the friction it is no longer the reserve that decides
      tree_.add(made[k].node, trial, std::min(trial.margin, o.friction) + trial.look_ahead);
    else
      dropped_.push_back({tree_.node(made[k].node).level + 1, std::move(trial)});
  }
}

std::string TowerSearch::reason() const {
  const int level = tree_.node(best_).level + 1;  // where it ended
  std::map<std::string, int> count;
  int all = 0;
  for (const Dropped& dropped : dropped_) {
    if (dropped.level != level) continue;
    ++count[dropped.trial.outcome];
    ++all;
  }
  const auto most = std::max_element(count.begin(), count.end(),
                                     [](const auto& p, const auto& q) { return p.second < q.second; });
  if (most != count.end())
    return concat("none of ", all, " poses was good enough; most often (", most->second, "): ", most->first);
  if (unreachable_ > 0) return concat("the arm reaches none of ", unreachable_, " proposed poses");
  return "no side of any stone fits the top of the stack with its centre of mass over the contacts";
}

}  // namespace stonestack
