#include <algorithm>

#include "search/search_on_stack.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/search/find_next_pose.hpp"

namespace stonestack {
namespace {

/// A tower as planned so far.
struct PartialTower {
  SearchProblem problem;
  std::vector<Placement> placements;
  double chance = 1.0;  ///< product of the predicted successes, as far as they are known
  double worth = 1.0;   ///< chance, and the reserve and prospects of the last placement
  std::string reason;
};

double term(const Placement& placement, const char* name) {
  const auto at = placement.terms.find(name);
  return at == placement.terms.end() ? 0.0 : at->second;
}

PartialTower extended(const PartialTower& tower, const Placement& placement, const SearchOptions& options) {
  PartialTower higher = tower;
  higher.problem.stack.stones.push_back({placement.stone, placement.T_W_O});
  std::erase_if(higher.problem.available, [&](const PlacedStone& s) { return s.stone == placement.stone; });
  higher.placements.push_back(placement);
  higher.chance *= options.verify ? placement.predicted_success : 1.0;
  const double prospects =
      higher.problem.available.empty() ? options.friction : term(placement, "look_ahead");
  const double reserve = std::min(term(placement, "margin"), options.friction);
  higher.worth = higher.chance * (1.0 + (reserve + prospects) / options.friction);
  return higher;
}

/// The best `keep`, at most half of them (rounded up) on one ground stone and one pose of it, so that one
/// beginning does not crowd out the rest.
std::vector<PartialTower> diverse(std::vector<PartialTower> towers, std::size_t keep) {
  std::stable_sort(towers.begin(), towers.end(),
                   [](const PartialTower& p, const PartialTower& q) { return p.worth > q.worth; });
  const auto same_start = [](const PartialTower& p, const PartialTower& q) {
    const Placement &a = p.placements.front(), &b = q.placements.front();
    return a.stone == b.stone && difference(a.T_W_O, b.T_W_O).angle < 0.2;
  };
  std::vector<PartialTower> kept;
  for (PartialTower& tower : towers) {
    if (kept.size() == keep) break;
    const auto alike = std::count_if(kept.begin(), kept.end(),
                                     [&](const PartialTower& other) { return same_start(tower, other); });
    const bool first_level = tower.placements.size() == 1;
    if (static_cast<std::size_t>(alike) >= (first_level ? 1 : (keep + 1) / 2)) continue;
    kept.push_back(std::move(tower));
  }
  return kept;
}

}  // namespace

std::vector<Placement> plan_tower(SearchProblem problem, int levels, const SearchOptions& options,
                                  std::string* reason) {
  require(levels >= 0, "levels must not be negative, got ", levels);
  const Stopwatch watch;
  SearchOptions of_level = options;
  std::vector<PartialTower> beam(1);
  beam[0].problem = std::move(problem);
  std::vector<Placement> best;
  std::string why;
  for (int level = 0; level < levels; ++level) {
    std::vector<PartialTower> next;
    const bool greedy = options.method == "paper" || options.beam == 1;
    for (const PartialTower& tower : beam) {
      of_level.alternatives = greedy ? 1 : options.beam;
      if (options.budget > 0.0) of_level.budget = std::max(1e-3, options.budget - watch.seconds());
      // What is planned here was judged on the way; only the given stack needs the check.
      const SearchResult found =
          level == 0 ? find_next_pose(tower.problem, of_level) : search_on_stack(tower.problem, of_level, {});
      if (found.best.empty() && why.empty()) why = found.reason;
      for (const Placement& placement : found.best) next.push_back(extended(tower, placement, options));
      if (interrupt_noted()) break;
    }
    if (next.empty()) break;
    beam = diverse(std::move(next), greedy ? 1 : static_cast<std::size_t>(options.beam));
    best = beam.front().placements;
    why.clear();
  }
  if (reason != nullptr) *reason = why;
  return best;
}

}  // namespace stonestack
