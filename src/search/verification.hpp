#pragma once
#include "search/trial.hpp"

namespace stonestack::search {

/// Trials that were verified.
struct Verified {
  std::vector<Placement> best;        ///< the good ones, most worth first
  std::vector<CandidateTrace> trace;  ///< with SearchOptions::trace, in order
  std::string reason;                 ///< when `best` is empty: why
  bool interrupted = false;           ///< before the end: `best` holds what was good by then, no trace
};
/// Settles the trials (all at once), then judges the best one after another in waves until
/// `alternatives` are good or all are judged.
[[nodiscard]] Verified verify(const SearchContext& context, std::vector<Trial> trials);

}  // namespace stonestack::search
