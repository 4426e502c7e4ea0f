#include "search/paper_search.hpp"

#include <algorithm>

#include "search/descent.hpp"
#include "search/parallel.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::search {
namespace {

/// One local solution of one stone, and the poses that led to it.
struct LocalSolution {
  std::size_t available = 0;
  StoneIndex stone = kNoStone;
  ContactSearch found;
  long evaluated = 0;                ///< all that were tried
  std::vector<ContactSearch> tried;  ///< for the trace: orientations that failed, steps of the descent
};

LocalSolution solved(const SearchContext& context, const Target& target, std::uint64_t task,
                     LocalSolution local) {
  const SearchOptions& o = *context.options;
  Random random = Random::stream(static_cast<std::uint64_t>(o.seed), task);
  const Eigen::Matrix3d R_detected = context.available[local.available].T_W_O.linear();
  for (int restart = 0; restart < o.restarts && !context.out_of_time(); ++restart) {
    throw_if_interrupted();
    const Eigen::Matrix3d R = initial_orientation(R_detected, o.theta_init, random);
    const Pose T_W_O = placed_along_normal(context, target, local.stone, R, Eigen::Vector3d::Zero());
    ContactSearch contact = search_contact(context, target, local.stone, T_W_O);
    ++local.evaluated;
    if (contact.valid) {
      if (o.trace) {
        local.tried.push_back(contact);
        local.tried.back().outcome = "first contact, descends from here";
      }
      Descent descent = descend(context, target, local.stone, std::move(contact));
      local.found = std::move(descent.best);
      local.evaluated += static_cast<long>(descent.tried.size());
      if (o.trace) local.tried.insert(local.tried.end(), descent.tried.begin(), descent.tried.end());
      return local;
    }
    if (o.trace) local.tried.push_back(std::move(contact));
  }
  return local;
}

CandidateTrace trace_of(StoneIndex stone, const ContactSearch& contact) {
  return {stone,
          contact.path_W_O,
          contact.pose.support,
          contact.cost.total,
          contact.cost.terms,
          contact.outcome.empty() ? "local solution" : contact.outcome};
}

Placement placement_of(StoneIndex stone, const ContactSearch& contact) {
  Placement placement;
  placement.stone = stone;
  placement.T_W_O = contact.T_W_O;
  placement.cost = contact.cost.total;
  placement.terms = contact.cost.terms;
  placement.support = contact.pose.support;
  return placement;
}

/// True where the turn from the detected orientation keeps within the tilt limit.
bool within_tilt(const SearchContext& context, const LocalSolution& local) {
  const Eigen::Vector3d up_now = context.available[local.available].T_W_O.linear().row(2).transpose();
  const Eigen::Vector3d up_then = local.found.T_W_O.linear().row(2).transpose();
  return std::acos(std::clamp(up_now.dot(up_then), -1.0, 1.0)) <= context.options->max_tilt;
}

/// Local solutions within the tilt limit, by cost.
std::vector<const LocalSolution*> by_cost(const SearchContext& context,
                                          const std::vector<LocalSolution>& all) {
  std::vector<const LocalSolution*> list;
  for (const LocalSolution& local : all)
    if (local.found.valid && within_tilt(context, local)) list.push_back(&local);
  std::stable_sort(list.begin(), list.end(), [](const LocalSolution* p, const LocalSolution* q) {
    return p->found.cost.total < q->found.cost.total;
  });
  return list;
}

}  // namespace

SearchResult paper_search(const SearchContext& context) {
  const SearchOptions& o = *context.options;
  SearchResult result;
  try {
    const Target target = target_of(context);
    std::vector<LocalSolution> all;
    for (std::size_t k = 0; k < context.available.size(); ++k)
      for (int x = 0; x < o.local_solutions; ++x) {
        LocalSolution local;
        local.available = k;
        local.stone = context.available[k].stone;
        all.push_back(std::move(local));
      }
    run_tasks(o.threads, all.size(),
              [&](std::size_t k) { all[k] = solved(context, target, k, std::move(all[k])); });
    for (const LocalSolution& local : all) {
      result.candidates += local.evaluated;
      if (!o.trace) continue;
      for (const ContactSearch& tried : local.tried) result.trace.push_back(trace_of(local.stone, tried));
      if (local.found.valid) result.trace.push_back(trace_of(local.stone, local.found));
    }
    std::vector<const LocalSolution*> ranked = by_cost(context, all);
    if (context.problem->reachable)
      std::erase_if(ranked, [&](const LocalSolution* local) {
        const bool refused = !context.problem->reachable(local->stone, local->found.T_W_O, context.stack);
        result.unreachable += refused ? 1 : 0;
        return refused;
      });
    context.log(concat(ranked.size(), " local solutions from ", result.candidates, " contact searches"));
    if (ranked.empty()) {
      result.reason = "no initial orientation led to three contacts around the centre of mass";
      return result;
    }
    std::vector<Trial> trials;
    for (const LocalSolution* local : ranked) {
      result.best.push_back(placement_of(local->stone, local->found));
      Trial trial;
      trial.stone = local->stone;
      trial.T_W_O = local->found.T_W_O;
      trials.push_back(std::move(trial));
    }
    result.best.resize(std::min(result.best.size(), static_cast<std::size_t>(o.alternatives)));
    if (!o.verify) return result;
    Verified verified = verify(context, std::move(trials));
    result.best = std::move(verified.best);
    result.reason = std::move(verified.reason);
    result.trace.insert(result.trace.end(), verified.trace.begin(), verified.trace.end());
    if (verified.interrupted) throw Interrupted();
    std::stable_sort(result.best.begin(), result.best.end(),
                     [](const Placement& p, const Placement& q) { return p.cost < q.cost; });
  } catch (const Interrupted&) {
    if (result.best.empty()) result.reason = why_interrupted();
  }
  return result;
}

}  // namespace stonestack::search
