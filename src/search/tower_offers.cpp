#include <algorithm>

#include "search/orientations.hpp"
#include "search/parallel.hpp"
#include "search/tower_search.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::search {
namespace {

constexpr int kProposalsPerStone = 16;
constexpr int kOfferTableYaws = 4;    ///< a first stone may be turned freely: variety for the arm
constexpr int kAskedPerSettled = 12;  ///< reach is asked at most so many times for each wanted

}  // namespace

std::optional<Pose> TowerSearch::reachable_pose(const Proposal& proposal, const Stack& below) {
  const auto& reachable = context_.problem->reachable;
  const int yaws = below.stones.empty() && reachable ? kOfferTableYaws : 1;
  for (int yaw = 0; yaw < yaws; ++yaw) {
    BodyPose body = proposal.body;
    body.R_W_O = yaw_rotation(6.283185307179586 * yaw / yaws) * body.R_W_O;
    const Pose T_W_O = stone_pose(body);
    if (!reachable || reachable(proposal.stone, T_W_O, below)) return T_W_O;
    ++unreachable_;
  }
  return std::nullopt;
}

std::vector<Proposal> TowerSearch::proposals(int k) {
  survey();
  const SearchOptions& o = *context_.options;
  const TowerNode& node = tree_.node(k);
  const StackBodies below{bodies_of(context_, node.stack), rests_of(context_.shapes(), node.stack),
                          context_.problem->held};
  std::vector<LooseStone> stones;
  for (const LooseStone& stone : loose_)
    if (std::any_of(node.left.begin(), node.left.end(),
                    [&](const auto& s) { return s.stone == stone.stone; }))
      stones.push_back(stone);
  auto [list, evaluated] = propose(below, stones, context_.problem->site, kProposalsPerStone, o);
  candidates_ += evaluated;
  const std::vector<StoneIndex> used = stones_of(node.stack);
  std::vector<long> counts(list.size(), 0);
  run_tasks(o.threads, list.size(), [&, &all = list](std::size_t p) {
    Proposal& proposal = all[p];
    StackBodies higher = below;
    higher.bodies.push_back(proposal.body);
    std::vector<StoneIndex> gone = used;
    gone.push_back(proposal.stone);
    if (stones.size() > 1) {
      const LookAheadEstimate ahead = look_ahead_->estimate(higher, gone, LookAheadEffort::kQuick);
      proposal.look_ahead = ahead.value;
      counts[p] = ahead.evaluated;
    }
    // On the table every estimate equals the friction: the margin ranks the stones.
    const double base = below.bodies.empty()
                            ? std::min(0.3, proposal.landing.margin / proposal.landing.lever) / 3.0
                            : proposal.robust;
    proposal.score = std::min(base, o.friction) + proposal.look_ahead;
  });
  for (const long count : counts) candidates_ += count;
  std::stable_sort(list.begin(), list.end(),
                   [](const Proposal& p, const Proposal& q) { return p.score > q.score; });
  return list;
}

/// Of what was proposed for a tower the best that the arm reaches and that were not tried yet; no stone gets
/// more than twice its share.
TowerSearch::Turn TowerSearch::next_turn(const TowerNode& node, int count) {
  const int max = std::max(2, 2 * count / std::max(1, static_cast<int>(node.left.size())));
  std::map<StoneIndex, int> of_stone;
  Turn turn;
  int asked = 0;
  for (const Proposal& proposal : node.spare) {
    throw_if_interrupted();
    if (static_cast<int>(turn.trials.size()) == count || asked == kAskedPerSettled * count ||
        of_stone[proposal.stone] == max) {
      turn.spare.push_back(proposal);
      continue;
    }
    ++asked;
    const std::optional<Pose> T_W_O = reachable_pose(proposal, node.stack);
    if (!T_W_O) continue;
    ++of_stone[proposal.stone];
    Trial trial;
    trial.stone = proposal.stone;
    trial.T_W_O = *T_W_O;
    trial.estimate = proposal.robust;
    trial.look_ahead = proposal.look_ahead;
    turn.trials.push_back(std::move(trial));
  }
  return turn;
}

std::vector<Trial> TowerSearch::offers(int k) {
  TowerNode node = tree_.node(k);
  node.spare = proposals(k);
  std::vector<Trial> reached;
  while (!node.spare.empty()) {
    Turn turn = next_turn(node, static_cast<int>(node.spare.size()));
    node.spare = std::move(turn.spare);
    for (Trial& trial : turn.trials) reached.push_back(std::move(trial));
  }
  return reached;
}

}  // namespace stonestack::search
