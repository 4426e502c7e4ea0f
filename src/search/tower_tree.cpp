#include "search/tower_tree.hpp"

#include <algorithm>
#include <cmath>

#include "search/constants.hpp"

namespace stonestack::search {
namespace {

/// A plan is not the tower: a placement errs, and what was to come next may not fit any more.
constexpr double kPlanHolds = 0.5;

/// Steps that a tower loses each time it is grown: what was tried of it was the best.
constexpr double kAgain = 3.0;

/// Success of what was not tried in displaced worlds. Nearer to 1, and more routes would be tried before the
/// best is known (docs/measurements.md, Search).
constexpr double kUntried = 0.9;

/// Reserve [g and stones] beyond which more is not worth a stone that may fall.
constexpr double kReserve = 0.1;

/// Worth of a tower that always outlasts a shake [stones].
constexpr double kWorthOfFirm = 0.9;

/// Lowest new stone and top stone: they identify a tower.
struct Ends {
  int first = 0;  ///< node
  StoneIndex top = kNoStone;
  bool operator==(const Ends& o) const { return first == o.first && top == o.top; }
};

}  // namespace

TowerTree::TowerTree(const Stack& stack, std::vector<PlacedStone> available, int levels, bool firm)
    : levels_(levels), firm_(firm) {
  TowerNode root;
  root.stack = stack;
  root.left = std::move(available);
  root.judged = true;
  nodes_.push_back(std::move(root));
}

int TowerTree::add(int parent, Trial trial, double promise) {
  TowerNode child;
  child.parent = parent;
  child.level = node(parent).level + 1;
  child.stack = node(parent).stack;
  child.stack.stones.push_back({trial.stone, trial.placement.T_W_O});
  for (const PlacedStone& stone : node(parent).left)
    if (stone.stone != trial.stone) child.left.push_back(stone);
  child.trial = std::move(trial);
  child.promise = promise;
  nodes_.push_back(std::move(child));
  return size() - 1;
}

void TowerTree::set_grown(int k) {
  if (++node(k).grown == 1 && node(k).parent >= 0) ++node(node(k).parent).grown_children;
}

std::vector<int> TowerTree::choose(int level, std::size_t count, double step) const {
  const auto ends = [&](int k) { return Ends{path_to(k).front(), node(k).trial.stone}; };
  std::vector<int> open, chosen;
  std::vector<Ends> grown;
  for (int k = 1; k < size(); ++k) {
    if (node(k).level != level || !node(k).trial.alive) continue;
    if (node(k).grown > 0) grown.push_back(ends(k));
    if (node(k).grown == 0 || !node(k).spare.empty()) open.push_back(k);
  }
  const auto value = [&](int k) {
    const int parent = node(k).parent;
    auto sisters = static_cast<double>(node(parent).grown_children);
    for (const int other : chosen) sisters += node(other).parent == parent ? 1.0 : 0.0;
    const auto alike = static_cast<double>(std::count(grown.begin(), grown.end(), ends(k)));
    return node(k).promise - step * (parent == 0 ? 0.0 : sisters) - 0.5 * step * alike -
           kAgain * step * node(k).grown;
  };
  while (chosen.size() < count && !open.empty()) {
    auto best = open.begin();
    double max = value(*best);
    for (auto at = open.begin() + 1; at != open.end(); ++at)
      if (const double v = value(*at); v > max) {
        max = v;
        best = at;
      }
    chosen.push_back(*best);
    grown.push_back(ends(*best));
    open.erase(best);
  }
  return chosen;
}

std::vector<int> TowerTree::children(int k) const {
  std::vector<int> list;
  for (int c = k + 1; c < size(); ++c)
    if (node(c).parent == k) list.push_back(c);
  return list;
}

std::vector<int> TowerTree::subtree(int k) const {
  std::vector<int> above;
  std::vector<bool> in(nodes_.size(), false);
  in[static_cast<std::size_t>(k)] = true;
  for (int c = k + 1; c < size(); ++c) {  // children come after their parents
    if (!in[static_cast<std::size_t>(node(c).parent)]) continue;
    in[static_cast<std::size_t>(c)] = true;
    above.push_back(c);
  }
  return above;
}

double TowerTree::success(int k) const {
  return node(k).predicted ? node(k).trial.placement.predicted_success : kUntried;
}

std::vector<int> TowerTree::path_to(int k) const {
  std::vector<int> path;
  for (; k > 0; k = node(k).parent) path.push_back(k);
  std::reverse(path.begin(), path.end());
  return path;
}

double TowerTree::firmness(int k) const {
  const Trial& trial = node(k).trial;
  if (node(k).predicted && finished(k))
    return trial.tried > 0 ? static_cast<double>(trial.shaken) / trial.tried : 0.0;
  return std::clamp(trial.margin / kShakeMargin, 0.0, 1.0);
}

double TowerTree::reserve(int k, double friction) const {
  if (firm_ && finished(k)) return 0.1 + 0.9 * firmness(k);
  return 0.5 + 0.5 * std::clamp(node(k).trial.margin / friction, 0.0, 1.0);
}

double TowerTree::chance(int k, double friction) const {
  const TowerNode& at = node(k);
  if (!at.trial.alive) return 0.0;
  const double own = k > 0 ? reserve(k, friction) * success(k) : 1.0;
  if (finished(k)) return own;
  if (at.grown == 0) {
    const double prospects = std::clamp((at.trial.look_ahead / friction + 0.5) / 1.5, 0.02, 1.0);
    return own * std::pow(0.5 * prospects, levels_ - at.level);
  }
  double none = 1.0;
  for (const int c : children(k)) none *= 1.0 - kPlanHolds * chance(c, friction);
  return own * (1.0 - none);
}

double TowerTree::expected_height(int k) const {
  const TowerNode& at = node(k);
  if (!at.trial.alive || !at.judged) return 0.0;
  double max = 0.0;
  for (const int c : children(k)) max = std::max(max, expected_height(c));
  return k == 0 ? max : success(k) * (1.0 + max);
}

std::vector<int> TowerTree::best_path_from(int k) const {
  std::vector<int> best;
  double max = 0.0;
  for (const int c : children(k)) {
    if (expected_height(c) <= 0.0) continue;
    std::vector<int> path = best_path_from(c);
    path.insert(path.begin(), c);
    // Among routes of the same height the reserve of the finished tower decides.
    const int top = path.back();
    const double reserve =
        firm_ && finished(top) ? kWorthOfFirm * firmness(top) : std::min(node(top).trial.margin, kReserve);
    const double value = expected_height(c) + reserve;
    if (value > max) {
      max = value;
      best = std::move(path);
    }
  }
  return best;
}

int TowerTree::reach(int k) const {
  int max = node(k).trial.alive ? node(k).level : 0;
  for (const int c : children(k))
    if (node(c).trial.alive) max = std::max(max, reach(c));
  return max;
}

}  // namespace stonestack::search
