#include "search/default_search.hpp"

#include <algorithm>
#include <tuple>

#include "search/constants.hpp"
#include "search/orientations.hpp"
#include "search/tower_search.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::search {
namespace {

constexpr int kTableYaws = 8;  ///< turns of a first stone that are offered to the arm

/// The proposals alone, neither settled nor judged.
std::vector<Placement> proposed(TowerSearch& search) {
  std::vector<Placement> list;
  for (const Trial& trial : search.offers(0)) {
    Placement placement;
    placement.stone = trial.stone;
    placement.T_W_O = trial.T_W_O;
    placement.terms = {{"a_est", trial.estimate}, {"look_ahead", trial.look_ahead}};
    list.push_back(std::move(placement));
  }
  return list;
}

/// First placements, those that lead highest and likeliest first.
std::vector<int> ranked_firsts(const TowerTree& tree, double friction) {
  std::vector<std::pair<std::pair<int, double>, int>> list;
  for (const int k : tree.children(0))
    if (tree.node(k).trial.alive) list.push_back({{tree.reach(k), tree.chance(k, friction)}, k});
  std::stable_sort(list.begin(), list.end(), [](const auto& p, const auto& q) { return p.first > q.first; });
  std::vector<int> order;
  for (const auto& entry : list) order.push_back(entry.second);
  return order;
}

/// Other children of a node's parent, without those in `chosen`: the likeliest to lead to the top first, then
/// those that were dropped, then what did not come to rest.
std::vector<Alternative> compared_with(const TowerSearch& search, int parent, const std::vector<int>& chosen,
                                       double friction) {
  const TowerTree& tree = search.tree();
  struct Ranked {
    std::tuple<bool, bool, int, double> rank;
    int node = 0;
  };
  std::vector<Ranked> others;
  for (const int k : tree.children(parent)) {
    if (std::find(chosen.begin(), chosen.end(), k) != chosen.end()) continue;
    const TowerNode& node = tree.node(k);
    const bool alive = node.trial.alive;
    others.push_back(
        {{alive, node.predicted, tree.reach(k), alive ? tree.chance(k, friction) : node.trial.score}, k});
  }
  std::stable_sort(others.begin(), others.end(),
                   [](const Ranked& p, const Ranked& q) { return p.rank > q.rank; });
  others.resize(std::min(others.size(), kMaxAlternatives));
  std::vector<Alternative> list;
  for (const Ranked& other : others) {
    Alternative& one = list.emplace_back(alternative_of(tree.node(other.node).trial));
    one.expected_height = tree.expected_height(other.node);
  }
  for (const TowerSearch::Dropped& dropped : search.dropped())
    if (dropped.below == parent && list.size() < kMaxAlternatives)
      list.push_back(alternative_of(dropped.trial));
  return list;
}

/// Not all first placements were judged and predicted while the towers grew: the best `wanted` are now.
void know_firsts(const SearchContext& context, TowerSearch& search, std::size_t wanted) {
  const TowerTree& tree = search.tree();
  while (!context.out_of_time() && !interrupt_noted()) {
    std::vector<int> firsts = ranked_firsts(tree, context.options->friction);
    firsts.resize(std::min(firsts.size(), wanted));
    if (std::all_of(firsts.begin(), firsts.end(), [&](int k) { return tree.node(k).predicted; })) return;
    search.judge(firsts);
  }
}

/// Predicts the best first placement and the route above it with more draws, until it stays the best. Where
/// one is dropped the best `wanted` of the others are judged.
void know_best(const SearchContext& context, TowerSearch& search, std::size_t wanted) {
  const TowerTree& tree = search.tree();
  for (int last_best = -1; !context.out_of_time() && !interrupt_noted();) {
    know_firsts(context, search, wanted);
    const std::vector<int> firsts = ranked_firsts(tree, context.options->friction);
    if (firsts.empty() || !tree.node(firsts.front()).predicted) return;
    const int best = firsts.front();
    const std::vector<int> path = tree.best_path_from(best);
    if (!search.predict_path(path.empty() ? best : path.back()) && best == last_best) return;
    last_best = best;
    search.predict(std::span<const int>(&last_best, 1), true);
  }
}

/// First placements.
struct Collected {
  std::vector<Placement> best;      ///< with what is planned on them, best first
  std::vector<Alternative> others;  ///< known beside them
};

Collected collected(const SearchContext& context, TowerSearch& search) {
  const auto wanted = static_cast<std::size_t>(context.options->alternatives);
  const double friction = context.options->friction;
  know_best(context, search, wanted);
  const TowerTree& tree = search.tree();
  Collected found;
  std::vector<int> taken;
  for (const int k : ranked_firsts(tree, friction)) {
    const TowerNode& node = tree.node(k);
    if (!node.predicted || found.best.size() == wanted) continue;
    Placement placement = node.trial.placement;
    placement.terms["plan_chance"] = tree.chance(k, friction);
    placement.expected_height = tree.expected_height(k);
    for (const int above : tree.best_path_from(k)) {
      const TowerNode& next = tree.node(above);
      placement.then.push_back({next.trial.stone, next.trial.placement.T_W_O});
      placement.then_compared.push_back(compared_with(search, next.parent, {above}, friction));
    }
    placement.terms["plan_levels"] = static_cast<double>(1 + placement.then.size());
    found.best.push_back(std::move(placement));
    taken.push_back(k);
  }
  found.others = compared_with(search, 0, taken, friction);
  return found;
}

/// Can the arm build the whole plan, one stone after the other?
bool all_reachable(const SearchContext& context, const Placement& plan) {
  Stack below = context.stack;
  if (!context.problem->reachable(plan.stone, plan.T_W_O, below)) return false;
  below.stones.push_back({plan.stone, plan.T_W_O});
  return std::all_of(plan.then.begin(), plan.then.end(), [&](const PlacedStone& next) {
    const bool free = context.problem->reachable(next.stone, next.T_W_O, below);
    below.stones.push_back(next);
    return free;
  });
}

/// A placement on the table, and what is planned on it, turned about the vertical through the site.
Placement turned(const SearchContext& context, const Placement& first, int yaw) {
  Placement other = first;
  const Eigen::Vector3d p_W(context.problem->site.x(), context.problem->site.y(), 0.0);
  other.T_W_O = Eigen::Translation3d(p_W) * Pose(yaw_rotation(6.283185307179586 * yaw / kTableYaws)) *
                Eigen::Translation3d(-p_W) * first.T_W_O;
  other.support = {};
  for (PlacedStone& above : other.then) above.T_W_O = other.T_W_O * first.T_W_O.inverse() * above.T_W_O;
  for (auto& compared : other.then_compared)
    for (Alternative& above : compared) above.T_W_O = other.T_W_O * first.T_W_O.inverse() * above.T_W_O;
  return other;
}

std::vector<CandidateTrace> trace_of(const TowerSearch& search) {
  std::vector<CandidateTrace> list;
  const auto add = [&](const Trial& trial, int level, const std::string& outcome) {
    CandidateTrace entry;
    entry.stone = trial.stone;
    entry.path_W_O = {trial.T_W_O, trial.placement.T_W_O};
    entry.support = trial.placement.support;
    entry.cost = trial.placement.cost;
    entry.terms = trial.placement.terms;
    entry.terms["level"] = level;
    entry.outcome = outcome;
    list.push_back(std::move(entry));
  };
  const TowerTree& tree = search.tree();
  for (int k = 1; k < tree.size(); ++k)
    if (tree.node(k).trial.alive) add(tree.node(k).trial, tree.node(k).level, "kept");
  for (const auto& dropped : search.dropped()) add(dropped.trial, dropped.level, dropped.trial.outcome);
  return list;
}

}  // namespace

SearchResult follow_plan(const SearchContext& context, std::span<const PlacedStone> plan) {
  SearchResult result;
  try {
    const auto levels = static_cast<int>(plan.size());
    TowerSearch search(context, levels);
    const TowerSearch::Followed followed = search.follow(plan);
    result.reason = followed.reason;
    result.unreachable = search.unreachable();
    if (followed.whole) {
      result.best = collected(context, search).best;
      // The closer prediction may have dropped a later stone.
      if (!result.best.empty() && result.best.front().then.size() + 1 < plan.size()) result.best.clear();
      if (!result.best.empty()) result.reason.clear();
    }
  } catch (const Interrupted&) {
    result.reason = "interrupted before the plan was judged";
  }
  return result;
}

double expected_of_plan(const SearchContext& context, std::span<const PlacedStone> plan) {
  TowerSearch search(context, static_cast<int>(plan.size()));
  static_cast<void>(search.follow(plan));
  search.predict_path(search.tree().size() - 1);  // of a plan that ends early, too
  return search.tree().expected_height(0);
}

SearchResult default_search(const SearchContext& context) {
  const SearchOptions& o = *context.options;
  const SearchProblem& problem = *context.problem;
  const int levels = std::min(o.horizon, static_cast<int>(context.available.size()));
  SearchResult result;
  try {
    TowerSearch search(context, levels);
    if (!o.verify) {
      result.best = proposed(search);
    } else {
      const auto look_for = [&](TowerSearch::Routes routes) {
        try {
          search.run(routes);
        } catch (const Interrupted&) {
          context.log("interrupted; keeping what was found");
        }
        const int found_levels = search.tree().node(search.best()).level;
        if (problem.known_route_only && found_levels <= static_cast<int>(problem.known_route.size()))
          return Collected{};
        return collected(context, search);
      };
      Collected found =
          look_for(problem.known_route_only ? TowerSearch::Routes::kFoundBefore : TowerSearch::Routes::kAll);
      // All that was found failed the closer prediction: what was left aside may hold.
      if (found.best.empty() && search.best() > 0 && !problem.known_route_only && !context.out_of_time() &&
          !interrupt_noted())
        found = look_for(TowerSearch::Routes::kNew);
      result.best = std::move(found.best);
      result.others = std::move(found.others);
      // On the table a stone may be turned about the vertical, which changes nothing but what the arm meets.
      const bool may_turn = context.stack.stones.empty() && problem.reachable != nullptr;
      const std::vector<Placement> plain = may_turn ? result.best : std::vector<Placement>();
      for (int yaw = 1; yaw < kTableYaws; ++yaw)
        for (const Placement& first : plain) {
          if (result.best.size() >= static_cast<std::size_t>(o.alternatives)) break;
          Placement other = turned(context, first, yaw);
          if (all_reachable(context, other)) result.best.push_back(std::move(other));
        }
    }
    result.candidates = search.candidates();
    result.unreachable = search.unreachable();
    if (result.best.empty()) result.reason = search.reason();
    if (o.trace) result.trace = trace_of(search);
  } catch (const Interrupted&) {
    if (result.best.empty()) result.reason = why_interrupted();
  }
  return result;
}

}  // namespace stonestack::search
