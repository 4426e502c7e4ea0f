#include "search/tower_search.hpp"

#include <algorithm>

#include "search/constants.hpp"
#include "search/parallel.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::search {
namespace {

constexpr double kFlatSide = 0.2;  ///< rise over run: the look-ahead tests only sides that are nearly level
constexpr int kCloser = 4;         ///< times the perturbations, where the first of them disagree
constexpr double kCrowding = 0.1;  ///< of the friction: TowerTree::choose
constexpr double kMarginPerTurn = 1.0;   ///< g/rad: a load that acts sideways by that share of its weight
constexpr double kWeightOfMargin = 3.0;  ///< beside the look-ahead, where towers are to be firm

}  // namespace

TowerSearch::TowerSearch(const SearchContext& context, int levels)
    : context_(context),
      levels_(std::min(levels, static_cast<int>(context.available.size()))),
      tree_(context.stack, context.available, levels_, context.firm()) {}

void TowerSearch::survey() {
  if (look_ahead_) return;
  loose_ = loose_stones(context_);
  look_ahead_.emplace(on_resting_sides(loose_, kFlatSide, *context_.options), *context_.options);
  loose_ = with_survey(std::move(loose_), *context_.options);
}

void TowerSearch::run(Routes routes) {
  survey();
  const SearchOptions& o = *context_.options;
  if (routes != Routes::kNew && (finish_known_route() || routes == Routes::kFoundBefore)) return;
  const int root[] = {0};
  tree_.set_grown(0);
  grow(root);
  int more = context_.firm() ? kShakeRounds : kFirmRounds;
  const int rounds = o.rounds + (context_.firm() ? kShakeRounds : 0);
  for (int k = 0; k < rounds && !context_.out_of_time(); ++k) {
    const std::size_t before = static_cast<std::size_t>(tree_.size()) + dropped_.size();
    round(static_cast<std::size_t>(o.beam));
    context_.log(concat("round ", k + 1, ": ", tree_.size() - 1, " towers grown, the highest of ",
                        tree_.node(best_).level, " of ", levels_, " stones"));
    bool exhausted = static_cast<std::size_t>(tree_.size()) + dropped_.size() == before;
    if (exhausted && !tree_.node(0).spare.empty()) {  // nothing that was begun leads on
      tree_.set_grown(0);
      grow(root);
      exhausted = false;
    }
    const bool finished = tree_.node(best_).level == levels_;
    const bool firm =
        context_.firm() ? tree_.firmness(best_) >= kFirmShare : tree_.node(best_).trial.margin >= kFirmMargin;
    if ((finished && (firm || more == 0)) || exhausted) break;
    if (finished) --more;
  }
}

TowerSearch::Climbed TowerSearch::climb(int node, const PlacedStone& next) {
  const auto& left = tree_.node(node).left;
  const auto& reachable = context_.problem->reachable;
  if (std::none_of(left.begin(), left.end(), [&](const auto& s) { return s.stone == next.stone; })) {
    return {-1, "a stone of the plan is not there any more"};
  }
  if (reachable && !reachable(next.stone, next.T_W_O, tree_.node(node).stack)) {
    ++unreachable_;
    return {-1, "the arm does not reach the plan any more"};
  }
  Trial trial;
  trial.stone = next.stone;
  trial.T_W_O = next.T_W_O;
  trial = settled_trial(context_, tree_.node(node).stack, std::move(trial));
  if (!trial.alive) return {-1, trial.outcome};
  const int higher = tree_.add(node, std::move(trial), 0.0);
  judge(std::span<const int>(&higher, 1));
  const Trial& judged = tree_.node(higher).trial;
  return {judged.alive ? higher : -1, judged.outcome};
}

TowerSearch::Followed TowerSearch::follow(std::span<const PlacedStone> plan) {
  int top = 0;
  Climbed higher{0, ""};
  for (auto next = plan.begin(); next != plan.end() && higher.node >= 0; ++next) {
    higher = climb(top, *next);
    if (higher.node >= 0) top = higher.node;
  }
  if (top == 0 || higher.node < 0) return {false, higher.reason};
  predict(tree_.path_to(top));
  best_ = top;
  for (const int k : tree_.path_to(top))
    if (!tree_.node(k).trial.alive) return {false, tree_.node(k).trial.outcome};
  return {true, "it falls too often"};
}

bool TowerSearch::finish_known_route() {
  int top = 0;
  for (const PlacedStone& next : context_.problem->known_route) {
    const int higher = climb(top, next).node;
    if (higher < 0) break;
    top = higher;
    tree_.set_grown(top);
  }
  const int level = tree_.node(top).level;
  if (top > 0 && level < levels_) {
    grow(std::span<const int>(&top, 1));
    round(static_cast<std::size_t>(context_.options->beam), level + 1);
  }
  find_best();
  if (best_ == 0 || level == levels_) return best_ > 0;
  context_.log(
      concat("from the known route: the highest of ", tree_.node(best_).level, " of ", levels_, " stones"));
  return tree_.node(best_).level == levels_;
}

void TowerSearch::round(std::size_t width, int first) {
  const double step = kCrowding * context_.options->friction;
  for (int level = first; level <= levels_; ++level) {
    std::vector<int> ready;
    // A placement that fails its judgement is replaced by the next.
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
    if (level < levels_) grow(ready);
  }
  find_best();
}

void TowerSearch::judge(std::span<const int> nodes) {
  run_tasks(context_.options->threads, nodes.size(), [&](std::size_t k) {
    TowerNode& node = tree_.node(nodes[k]);
    if (node.judged) return;
    node.trial = judged_trial(context_, tree_.node(node.parent).stack, node.trial);
    node.judged = true;
  });
  drop_fallen(nodes);
  std::vector<int> firsts;
  for (const int k : nodes)
    if (tree_.node(k).parent == 0) firsts.push_back(k);
  predict(firsts);
}

void TowerSearch::predict(std::span<const int> nodes, bool closely) {
  const SearchOptions& o = *context_.options;
  std::vector<int> tried;
  std::vector<Candidate> candidates;
  for (const int k : nodes) {
    TowerNode& node = tree_.node(k);
    const bool sure = node.predicted && node.trial.placement.predicted_success >= 1.0;
    if (!node.judged || !node.trial.alive || (closely ? sure : node.predicted)) continue;
    tried.push_back(k);
    TowerNode& below = tree_.node(node.parent);
    candidates.push_back({&below.stack, &node.trial, context_.firm() && tree_.finished(k), &below.stands_in});
  }
  std::vector<Trial> trials =
      predicted_trials(context_, candidates, (closely ? kCloser : 1) * o.perturbations);
  for (std::size_t i = 0; i < tried.size(); ++i) {
    TowerNode& node = tree_.node(tried[i]);
    node.trial = std::move(trials[i]);
    node.predicted = true;
  }
  drop_fallen(tried);
}

bool TowerSearch::predict_path(int node) {
  std::vector<int> unknown;
  for (const int k : tree_.path_to(node))
    if (!tree_.node(k).predicted) unknown.push_back(k);
  predict(unknown);
  return !unknown.empty();
}

void TowerSearch::drop_fallen(std::span<const int> nodes) {
  for (const int k : nodes) {
    if (tree_.node(k).trial.alive) continue;
    dropped_.push_back({tree_.node(k).level, tree_.node(k).trial, -1});
    for (const int above : tree_.subtree(k)) {
      TowerNode& node = tree_.node(above);
      node.trial.alive = false;
      node.trial.outcome = "stands on a stone that was dropped";
      dropped_.push_back({node.level, node.trial, -1});
    }
  }
}

int TowerSearch::highest() const {
  const auto worth = [&](int k) {
    double chance = 1.0;
    for (const int at : tree_.path_to(k)) chance *= tree_.success(at);
    return std::pair(tree_.node(k).level, chance * tree_.reserve(k, context_.options->friction));
  };
  int best = 0;
  for (int k = 1; k < tree_.size(); ++k)
    if (tree_.node(k).judged && tree_.node(k).trial.alive && (best == 0 || worth(k) > worth(best))) best = k;
  return best;
}

/// Predicts in displaced worlds what may be taken for better than it is: of finished towers routes are
/// predicted until the best is known, of others the best alone.
void TowerSearch::find_best() {
  do {
    best_ = highest();
  } while (predict_path(best_) && (tree_.node(best_).level == levels_ || !tree_.node(best_).trial.alive));
}

double TowerSearch::promise(const Trial& trial) const {
  // A stone that turns by an angle leaves about so much less of the margin.
  const double margin =
      std::min(trial.margin, context_.options->friction) - kMarginPerTurn * trial.turn_sigma;
  return (context_.firm() ? kWeightOfMargin * margin : margin) + trial.look_ahead;
}

void TowerSearch::grow(std::span<const int> nodes) {
  const SearchOptions& o = *context_.options;
  std::vector<Offer> made;
  for (const int k : nodes) {
    if (context_.out_of_time()) break;
    TowerNode& node = tree_.node(k);
    if (node.grown == 1) node.spare = proposals(k);
    Turn turn = next_turn(node, o.settled);
    node.spare = std::move(turn.spare);
    for (Trial& trial : turn.trials) made.push_back({k, std::move(trial)});
  }
  std::vector<long> counts(made.size(), 0);
  run_tasks(o.threads, made.size(), [&](std::size_t k) {
    Trial& trial = made[k].trial;
    const TowerNode& below = tree_.node(made[k].node);
    trial = settled_trial(context_, below.stack, std::move(trial));
    if (!trial.alive || below.left.size() < 2) return;
    Stack higher = below.stack;
    higher.stones.push_back({trial.stone, trial.placement.T_W_O});
    const StackBodies bodies{bodies_of(context_, higher), rests_of(context_.shapes(), higher),
                             context_.problem->held};
    std::vector<StoneIndex> used = stones_of(below.stack);
    used.push_back(trial.stone);
    const LookAheadEstimate ahead = look_ahead_->estimate(bodies, used, LookAheadEffort::kFull);
    trial.look_ahead = ahead.value;
    counts[k] = ahead.evaluated;
    trial.placement.terms["look_ahead"] = trial.look_ahead;
  });
  for (std::size_t k = 0; k < made.size(); ++k) {
    candidates_ += counts[k];
    Trial& trial = made[k].trial;
    if (trial.alive)  // beyond the friction it is no longer the reserve that decides
      tree_.add(made[k].node, trial, promise(trial));
    else
      dropped_.push_back({tree_.node(made[k].node).level + 1, std::move(trial), made[k].node});
  }
}

std::string TowerSearch::reason() const {
  const int level = tree_.node(highest()).level + 1;  // where it ended
  std::map<std::string, int> count;
  int all = 0;
  for (const Dropped& dropped : dropped_) {
    if (dropped.level != level) continue;
    ++count[dropped.trial.outcome];
    ++all;
  }
  const auto max = std::max_element(count.begin(), count.end(),
                                    [](const auto& p, const auto& q) { return p.second < q.second; });
  if (max != count.end())
    return concat("none of ", all, " poses was good enough; most often (", max->second, "): ", max->first);
  if (unreachable_ > 0) return concat("the arm reaches none of ", unreachable_, " proposed poses");
  return "no side of any stone fits the top of the stack with its centre of mass over the contacts";
}

}  // namespace stonestack::search
