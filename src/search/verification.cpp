#include "search/verification.hpp"

#include <algorithm>

#include "search/parallel.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::search {
namespace {

constexpr std::size_t kWave = 4;  ///< trials judged at a time; fixed, so that threads do not matter

CandidateTrace trace_of(const Trial& trial, const std::string& outcome) {
  CandidateTrace trace;
  trace.stone = trial.stone;
  trace.path_W_O = {trial.T_W_O, trial.placement.T_W_O};
  trace.support = trial.placement.support;
  trace.cost = trial.placement.cost;
  trace.terms = trial.placement.terms;
  trace.outcome = outcome;
  return trace;
}

/// The commonest reason, for the user.
std::string summary(const std::vector<Trial>& trials) {
  std::map<std::string, int> count;
  for (const Trial& trial : trials)
    if (!trial.alive) ++count[trial.outcome];
  const auto max = std::max_element(count.begin(), count.end(),
                                    [](const auto& p, const auto& q) { return p.second < q.second; });
  if (max == count.end()) return "no pose was tried";
  return concat("none of ", trials.size(), " poses was good enough; most often (", max->second,
                "): ", max->first);
}

}  // namespace

Verified verify(const SearchContext& context, std::vector<Trial> trials) {
  Verified verified;
  try {
    const SearchOptions& o = *context.options;
    run_tasks(o.threads, trials.size(), [&](std::size_t k) {
      if (!context.out_of_time())
        trials[k] = settled_trial(context, context.stack, std::move(trials[k]));
      else
        trials[k].alive = false, trials[k].outcome = "the time was over";
    });
    std::vector<std::size_t> order;
    for (std::size_t k = 0; k < trials.size(); ++k)
      if (trials[k].alive) order.push_back(k);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t p, std::size_t q) { return trials[p].score > trials[q].score; });
    context.log(concat(order.size(), " of ", trials.size(), " proposals come to rest in balance"));
    std::vector<std::size_t> good;
    const auto collect = [&] {
      std::stable_sort(good.begin(), good.end(), [&](std::size_t p, std::size_t q) {
        return worth(context, trials[p]) > worth(context, trials[q]);
      });
      verified.best.clear();
      for (const std::size_t k : good) verified.best.push_back(trials[k].placement);
    };
    std::size_t next = 0;
    while (next < order.size() && good.size() < static_cast<std::size_t>(o.alternatives) &&
           !context.out_of_time()) {
      const std::size_t count = std::min(kWave, order.size() - next);
      run_tasks(o.threads, count, [&](std::size_t k) {
        Trial& trial = trials[order[next + k]];
        trial = judged_trial(context, context.stack, std::move(trial));
      });
      std::vector<std::size_t> standing;
      std::vector<Candidate> candidates;
      for (std::size_t k = next; k < next + count; ++k)
        if (trials[order[k]].alive) {
          standing.push_back(order[k]);
          candidates.push_back({&context.stack, &trials[order[k]]});
        }
      std::vector<Trial> predicted = predicted_trials(context, candidates, o.perturbations);
      for (std::size_t k = 0; k < standing.size(); ++k) trials[standing[k]] = std::move(predicted[k]);
      for (std::size_t k = next; k < next + count; ++k)
        if (trials[order[k]].alive) good.push_back(order[k]);
      next += count;
      collect();
      context.log(concat(good.size(), " good of ", next, " judged"));
    }
    if (verified.best.size() > static_cast<std::size_t>(o.alternatives))
      verified.best.resize(static_cast<std::size_t>(o.alternatives));
    if (o.trace)
      for (const Trial& trial : trials)
        verified.trace.push_back(trace_of(trial, trial.alive ? "kept" : trial.outcome));
    if (verified.best.empty()) verified.reason = summary(trials);
  } catch (const Interrupted&) {
    verified.interrupted = true;
  }
  return verified;
}

}  // namespace stonestack::search
