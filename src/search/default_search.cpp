#include "search/default_search.hpp"

#include <algorithm>

#include "search/orientations.hpp"
#include "search/parallel.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack {
namespace {

constexpr int kProposalsPerStone = 6;     ///< measured
constexpr std::size_t kLookedAhead = 14;  ///< proposals that get the full look-ahead
constexpr int kTableYaws = 4;             ///< a first stone may be turned freely: variety for the arm
constexpr int kAskedPerSettled = 6;       ///< reach is asked at most so many times `settled`

/// Fills look-ahead and score, quick for all and in full for the best, and sorts.
void look_ahead_all(const SearchContext& context, const LookAhead& look_ahead,
                    std::vector<Proposal>* proposals, long* evaluated) {
  const std::vector<BodyPose> stack = bodies_of(context, context.stack);
  std::vector<long> counts(proposals->size(), 0);
  const auto score = [&](std::size_t count, LookAheadEffort effort) {
    run_tasks(context.options->threads, count, [&](std::size_t k) {
      Proposal& p = (*proposals)[k];
      std::vector<BodyPose> higher = stack;
      higher.push_back(p.body);
      const int used[] = {p.stone};
      p.look_ahead = look_ahead.estimate(higher, used, effort, &counts[k]);
      // On the table every estimate is the friction: the margin tells the stones apart.
      const double base = stack.empty() ? std::min(0.3, p.landing.margin / p.landing.lever) / 3.0 : p.robust;
      p.score = std::min(base, context.options->friction) + p.look_ahead;
    });
    std::stable_sort(proposals->begin(), proposals->begin() + static_cast<std::ptrdiff_t>(count),
                     [](const Proposal& p, const Proposal& q) { return p.score > q.score; });
  };
  score(proposals->size(), LookAheadEffort::kQuick);
  score(std::min(kLookedAhead, proposals->size()), LookAheadEffort::kFull);
  for (const long count : counts) *evaluated += count;
}

/// The proposals that the arm can bring about, best first, `settled` at most.
std::vector<Trial> reachable_trials(const SearchContext& context, const std::vector<Proposal>& proposals,
                                    SearchResult* result) {
  const auto wanted = static_cast<std::size_t>(context.options->settled);
  const int yaws = context.stack.stones.empty() ? kTableYaws : 1;
  std::vector<Trial> trials;
  std::size_t asked = 0;
  for (const Proposal& p : proposals) {
    bool first = true;
    for (int yaw = 0; yaw < yaws; ++yaw) {
      if (trials.size() == wanted || context.out_of_time() || asked > kAskedPerSettled * wanted)
        return trials;
      throw_if_interrupted();
      BodyPose body = p.body;
      body.R_W_O = yaw_rotation(6.283185307179586 * yaw / yaws) * body.R_W_O;
      Trial trial;
      trial.stone = p.stone;
      trial.T_W_O = stone_pose(body);
      trial.estimate = p.robust;
      trial.look_ahead = p.look_ahead;
      // Without an arm to ask, turning a stone on the table changes nothing.
      if (!context.problem->reachable && !first) break;
      ++asked;
      if (context.problem->reachable && !context.problem->reachable(trial.stone, trial.T_W_O)) {
        ++result->unreachable;
        continue;
      }
      first = false;
      trials.push_back(std::move(trial));
    }
  }
  return trials;
}

}  // namespace

void default_search(const SearchContext& context, const LookAhead& look_ahead, SearchResult* result) {
  const SearchOptions& o = *context.options;
  const std::vector<BodyPose> stack = bodies_of(context, context.stack);
  const std::vector<LooseStone> loose = loose_stones(context);
  std::vector<Proposal> proposals =
      propose(stack, loose, context.problem->site, kProposalsPerStone, o, &result->candidates);
  context.say(concat(proposals.size(), " proposals from ", result->candidates, " landings"));
  if (proposals.empty()) {
    result->reason =
        "no side of any stone fits the top of the stack with its centre of mass over the contacts";
    return;
  }
  look_ahead_all(context, look_ahead, &proposals, &result->candidates);
  std::vector<Trial> trials = reachable_trials(context, proposals, result);
  if (trials.empty()) {
    result->reason = concat("the arm reaches none of ", result->unreachable, " proposed poses");
    return;
  }
  if (!o.verify) {
    for (const Trial& trial : trials) {
      Placement placement;
      placement.stone = trial.stone;
      placement.T_W_O = trial.T_W_O;
      placement.terms = {{"a_est", trial.estimate}, {"look_ahead", trial.look_ahead}};
      result->best.push_back(std::move(placement));
    }
    return;
  }
  verify(context, std::move(trials), result);
}

}  // namespace stonestack
