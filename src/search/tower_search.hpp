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

  /// Which ways are looked for: on from the problem's way up, from the bottom, or, where the first does not
  /// lead to the top, both.
  enum class Routes { kFoundBefore, kNew, kAll };
  void run(Routes routes = Routes::kAll);
  /// True if all of a plan is reachable, comes to rest in balance and stands its judgement; else `reason` is
  /// told why not.
  [[nodiscard]] bool follow(std::span<const PlacedStone> plan, std::string* reason);
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
  /// times as many those that do not always stand, for eight tell a chance from a half by luck (bench
  /// calibration: what they believe to stand in a quarter of the cases stands in half of them).
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
  /// Proposals for the next stone on a node's tower, best first, not asked of the arm.
  [[nodiscard]] std::vector<Proposal> proposals(int node);
  [[nodiscard]] std::vector<Trial> next_turn(TowerNode* node, int count);
  [[nodiscard]] bool accepts(const Proposal& proposal, const Stack& below, Trial* trial);
  /// Settles and judges a placement on a node's tower; the new node, or -1 with the reason.
  [[nodiscard]] int climb(int node, const PlacedStone& next, std::string* reason);
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
