#pragma once
#include <optional>

#include "search/look_ahead.hpp"
#include "search/tower_tree.hpp"

namespace stonestack::search {

/// Anytime beam search: a beam search, level by level, that is repeated in rounds over one kept tree. In
/// every round and on every level the `beam` most promising towers (TowerTree::choose: static margin plus
/// look-ahead, less what crowds) get their next stones (gap field proposals, look-ahead, settling,
/// equilibrium, judgement); towers that the beam left out stay in the tree and compete in the next round. The
/// first round that finishes a firm tower of all `levels` ends the search; so do the rounds, the budget and
/// Ctrl-C. Eq. (2) plays no part in the order.
class TowerSearch {
 public:
  TowerSearch(const SearchContext& context, int levels);

  /// Routes that are searched: onwards from the problem's known route, from the bottom, or, where the first
  /// does not lead to the top, both.
  enum class Routes { kFoundBefore, kNew, kAll };
  void run(Routes routes = Routes::kAll);
  /// Whether a plan holds.
  struct Followed {
    bool whole = false;  ///< all of it is reachable, comes to rest in balance and stands its judgement
    std::string reason;  ///< why not; of a whole plan what to report if a closer look should drop it
  };
  /// Puts the stones of a plan one upon the other and judges them.
  [[nodiscard]] Followed follow(std::span<const PlacedStone> plan);
  [[nodiscard]] const TowerTree& tree() const { return tree_; }
  /// The node whose tower is highest and, of those, most likely to stand, after the last whole round; 0 for
  /// none. It and all below it are predicted.
  [[nodiscard]] int best() const { return best_; }
  /// Greatest height by what is known now, predicted or not.
  [[nodiscard]] int highest() const;
  /// Judges nodes (all at once) that are not judged yet; some die. First placements are predicted, too: they
  /// are what a search that is cut short returns.
  void judge(std::span<const int> nodes);
  /// Tries those that were judged, but not predicted yet, in displaced worlds; some die. `closely`: in four
  /// times as many draws for those that do not always stand, as eight draws cannot separate a quarter from a
  /// half (bench calibration: towers estimated to stand in a quarter of the cases stood in half of them).
  void predict(std::span<const int> nodes, bool closely = false);
  /// Predicts a node and all below it; false if that was done before.
  bool predict_path(int node);

  [[nodiscard]] long candidates() const { return candidates_; }
  [[nodiscard]] int unreachable() const { return unreachable_; }
  /// Why no stone could be put on the given stack, or what ended the tower.
  [[nodiscard]] std::string reason() const;
  /// Trials that died, for the trace.
  struct Dropped {
    int level = 0;
    Trial trial;
    int below = -1;  ///< node that it did not come to rest on; -1: it is a node itself
  };
  [[nodiscard]] const std::vector<Dropped>& dropped() const { return dropped_; }
  /// Proposals for the next stone on a node's tower, best first, not settled: what the arm reaches.
  [[nodiscard]] std::vector<Trial> offers(int node);

 private:
  struct Offer {
    int node;
    Trial trial;
  };
  /// Surveys what the loose stones offer: made once, when something is searched at all.
  void survey();
  void grow(std::span<const int> nodes);
  /// Reserve and prospects of a trial [g], by which towers are chosen to be grown.
  [[nodiscard]] double promise(const Trial& trial) const;
  /// Proposals for the next stone on a node's tower, best first, not asked of the arm.
  [[nodiscard]] std::vector<Proposal> proposals(int node);
  /// Trials that a tower gets next.
  struct Turn {
    std::vector<Trial> trials;
    std::vector<Proposal> spare;  ///< proposals that are left for later turns
  };
  [[nodiscard]] Turn next_turn(const TowerNode& node, int count);
  /// Pose in which the arm can put a proposed stone on the stack; empty if there is none.
  [[nodiscard]] std::optional<Pose> reachable_pose(const Proposal& proposal, const Stack& below);
  struct Climbed {
    int node = -1;       ///< the new node; -1: none
    std::string reason;  ///< why there is none
  };
  /// Settles and judges a placement on a node's tower.
  [[nodiscard]] Climbed climb(int node, const PlacedStone& next);
  /// The problem's way up as far as it holds, and on from its top. True if that finished a tower.
  [[nodiscard]] bool finish_known_route();
  /// Judges and grows the best towers of each level from `first` on.
  void round(std::size_t width, int first = 1);
  /// Sets best(): predicts what leads until nothing that is not tried may be better.
  void find_best();
  /// Remembers those that died and what stands on them, for the trace and the reason.
  void drop_fallen(std::span<const int> nodes);

  const SearchContext& context_;
  int levels_;
  std::vector<LooseStone> loose_;
  std::optional<LookAhead> look_ahead_;
  TowerTree tree_;
  int best_ = 0;
  long candidates_ = 0;
  int unreachable_ = 0;
  std::vector<Dropped> dropped_;
};

}  // namespace stonestack::search
