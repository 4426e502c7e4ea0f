#include <algorithm>
#include <memory>

#include "stacking/builder.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::stacking {
namespace {

constexpr double kSamePlace = 0.012;  // m, of the centre of mass: nearer is what was tried before
constexpr double kSameTurn = 0.26;    // rad: the same

}  // namespace

std::shared_ptr<Reach> Builder::reach_in(const Belief& belief) const {
  const auto make = [&] {
    return std::make_shared<Reach>(belief, make_planning_scene(cell_.layout, robot_, catalogue_, belief),
                                   catalogue_, options_.motion);
  };
  if (&belief != &belief_) return make();
  if (!reach_) reach_ = make();
  return reach_;
}

SearchProblem Builder::make_problem(const Belief& belief, Ways ways) const {
  SearchProblem problem;
  problem.shapes = &shapes_;
  problem.stack.stones = belief.stack;
  problem.site = cell_.layout.site;
  const auto reach = reach_in(belief);
  for (const PlacedStone& loose : belief.loose)
    if (fits_hand(loose.stone) && reach->at_pick(loose.stone).can_be_held())
      problem.available.push_back(loose);
  problem.reachable = [this, reach, ways, loose = belief.loose](int stone, const Pose& T_W_O,
                                                                const Stack& below) {
    if (was_given_up(stone, T_W_O) || leans_on_loose(shapes_, loose, {stone, T_W_O}, below.stones))
      return false;
    const std::vector<Pose> avoid = useless_grasps(stone);
    return reach->in_one_go(stone, T_W_O, below, avoid) ||
           (ways == Ways::kTurningToo &&
            reach->by_turning(stone, T_W_O, below, avoid, regrasp_options(stone)));
  };
  return problem;
}

std::vector<Pose> Builder::useless_grasps(int stone) const {
  std::vector<Pose> list;
  for (const auto* grasps : {&failed_grasps_, &no_pick_})
    if (const auto of_stone = grasps->find(stone); of_stone != grasps->end())
      list.insert(list.end(), of_stone->second.begin(), of_stone->second.end());
  return list;
}

void Builder::name_useless_grasps(PickAndPlaceTask* task, int stone) const {
  if (const auto failed = failed_grasps_.find(stone); failed != failed_grasps_.end())
    task->avoid = failed->second;
  if (const auto no_pick = no_pick_.find(stone); no_pick != no_pick_.end()) task->no_pick = no_pick->second;
}

/// One set-down at a time: after each the camera looks, and what lies otherwise than meant is planned anew.
RegraspOptions Builder::regrasp_options(int stone) const {
  RegraspOptions regrasp;
  regrasp.most = 1;
  if (const auto fell = toppled_.find(stone); fell != toppled_.end()) regrasp.n_O_not_up = fell->second;
  return regrasp;
}

bool Builder::fits_hand(int stone) const {
  return unfit_[static_cast<std::size_t>(stone)].empty();
}

std::string Builder::not_held() const {
  const auto reach = reach_in(belief_);
  std::string list;
  for (const PlacedStone& loose : belief_.loose) {
    const std::string& unfit = unfit_[static_cast<std::size_t>(loose.stone)];
    if (!unfit.empty() || !reach->at_pick(loose.stone).can_be_held())
      list += concat(list.empty() ? "" : "; ", name(loose.stone), ": ",
                     unfit.empty() ? reach->at_pick(loose.stone).text() : unfit);
  }
  return list;
}

std::string Builder::unfit_stones() const {
  std::string list;
  for (const PlacedStone& loose : belief_.loose)
    if (!fits_hand(loose.stone))
      list += concat(list.empty() ? "" : ", ", name(loose.stone), " (",
                     unfit_[static_cast<std::size_t>(loose.stone)], ")");
  return list;
}

bool Builder::dare_failed_grasps() {
  if (failed_grasps_.empty()) return false;
  report("no other way is left than grasps that failed before: they are tried again");
  failed_grasps_.clear();
  reach_.reset();
  return true;
}

bool Builder::was_given_up(int stone, const Pose& T_W_O) const {
  const auto same = [&](const PlacedStone& top) {
    return same_place(shapes_, top, {stone, T_W_O}, kSamePlace, kSameTurn);
  };
  return std::any_of(given_up_.begin(), given_up_.end(), same) ||
         std::any_of(refused_.begin(), refused_.end(), same);
}

}  // namespace stonestack::stacking
