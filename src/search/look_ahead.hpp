#pragma once
#include "search/proposals.hpp"

namespace stonestack::search {

/// Effort of the look-ahead: the quick one separates good tops from bad ones at an eighth of the cost.
enum class LookAheadEffort { kQuick, kFull };

/// An estimate of the look-ahead.
struct LookAheadEstimate {
  double value = 0.0;  ///< [g]
  long evaluated = 0;  ///< landings that were tried for it
};

/// Look-ahead on what the remaining stones could bear on top of a stack, by the gap field alone. Undersides
/// are made once; then a question costs some 0.1 s for five stones. Read-only after construction, for any
/// thread.
class LookAhead {
 public:
  LookAhead(std::span<const LooseStone> stones, const SearchOptions& options);

  /// Mean of the best few estimates (g) over the stones without `used` (index into shapes); 0 if none is
  /// left. Each stone and orientation counts once, at its best yaw and offset.
  [[nodiscard]] LookAheadEstimate estimate(const StackBodies& stack, std::span<const StoneIndex> used,
                                           LookAheadEffort effort) const;

 private:
  struct Side {
    std::size_t stone;
    std::vector<Underside> yaws;
  };
  std::vector<LooseStone> stones_;
  std::vector<Side> sides_;
  SearchOptions options_;
};

}  // namespace stonestack::search
