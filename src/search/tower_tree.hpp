#pragma once
#include "search/trial.hpp"

namespace stonestack::search {

/// A tower under construction: one more stone than its parent's, settled and in balance.
struct TowerNode {
  int parent = -1;  ///< -1: the root, which is the given stack
  int level = 0;    ///< stones put on the given stack
  Trial trial;      ///< of the last stone
  Stack stack;      ///< with that stone
  std::vector<PlacedStone> left;
  double promise = 0.0;    ///< reserve and prospects [g]
  bool judged = false;     ///< by simulation of the whole stack
  bool predicted = false;  ///< tried in displaced worlds
  int grown = 0;           ///< times that it got children
  int grown_children = 0;
  std::map<int, bool> stands_in;  ///< Candidate::below_stands of what is put on it
  std::vector<Proposal> spare;    ///< proposals for the next stone that were not tried yet
};

/// Towers grown stone by stone. Keeps every node, so that a search may come back to what it left aside.
class TowerTree {
 public:
  /// @param levels stones of a finished tower
  /// @param firm finished towers are to outlast a shake
  TowerTree(const Stack& stack, std::vector<PlacedStone> available, int levels, bool firm);

  [[nodiscard]] TowerNode& node(int k) { return nodes_[static_cast<std::size_t>(k)]; }
  [[nodiscard]] const TowerNode& node(int k) const { return nodes_[static_cast<std::size_t>(k)]; }
  [[nodiscard]] int size() const { return static_cast<int>(nodes_.size()); }
  /// Adds the child that `trial` (settled, alive) makes of a node.
  int add(int parent, Trial trial, double promise);
  /// Notes that a node is about to get children.
  void set_grown(int k);

  /// Up to `count` nodes of a level, alive and with something left to try, most promise first. A node loses
  /// promise for every sister that was grown or is chosen before it, for every time it was grown itself, and
  /// a little for every tower with the same two end stones, so that one beginning does not crowd out the
  /// rest. `step` is that loss, g.
  [[nodiscard]] std::vector<int> choose(int level, std::size_t count, double step) const;
  /// Children of a node, in the order of their making.
  [[nodiscard]] std::vector<int> children(int k) const;
  /// All nodes above a node, parents first.
  [[nodiscard]] std::vector<int> subtree(int k) const;
  /// Predicted success of a node's last stone, or what is usual where it was not tried in displaced worlds.
  [[nodiscard]] double success(int k) const;
  /// Factor for the reserve of a node's tower, 0.5 to 1 by its margin against the friction; of a finished
  /// tower that is to be firm 0.1 to 1 by how often it outlasts a shake.
  [[nodiscard]] double reserve(int k, double friction) const;
  /// True for a tower of all levels.
  [[nodiscard]] bool finished(int k) const { return node(k).level >= levels_; }
  /// Share of the displaced worlds in which a tower outlasts a shake; estimated from its margin where it was
  /// not shaken.
  [[nodiscard]] double firmness(int k) const;
  /// From the first stone put to this node's.
  [[nodiscard]] std::vector<int> path_to(int k) const;
  /// Chance that a node's tower can be finished at `levels`, estimated from the tree: its own success times
  /// the chance that one of its children can. `friction` is what a reserve is measured against.
  [[nodiscard]] double chance(int k, double friction) const;
  /// The most stones that are expected to stand on the given stack by one route through a node: each counts
  /// as likely as all below it and itself are to succeed. What was not judged counts nothing.
  [[nodiscard]] double expected_height(int k) const;
  /// The nodes above k on that route, from the lowest.
  [[nodiscard]] std::vector<int> best_path_from(int k) const;
  /// Levels that the highest tower through a node reaches, judged or not.
  [[nodiscard]] int reach(int k) const;

 private:
  std::vector<TowerNode> nodes_;
  int levels_;
  bool firm_;
};

}  // namespace stonestack::search
