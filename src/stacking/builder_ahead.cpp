#include <algorithm>
#include <utility>

#include "stacking/builder.hpp"
#include "stacking/steady.hpp"
#include "stonestack/core/clock.hpp"

namespace stonestack::stacking {
namespace {

// The next look may show a stone this much beside where the last one did, and it lies as it was thought to.
constexpr double kSameShift = 0.015;  // m
constexpr double kSameTurn = 0.10;    // rad
constexpr double kSameLevel = 0.002;  // m, a stone of the tower: most that two looks at it differ by
constexpr double kSameTilt = 0.035;   // rad

bool alike(const std::vector<PlacedStone>& a, const std::vector<PlacedStone>& b, const ShapeList& shapes,
           double shift, double turn) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [&](const PlacedStone& p, const PlacedStone& q) {
    return same_place(shapes, p, q, shift, turn);
  });
}

}  // namespace

void Builder::search_on_tower(const Look& of_site) {
  const Stopwatch watch;
  Belief seen = belief_;
  const Belief tower{belief_.stack, {}};
  const auto sightings = find_in_looks({of_site}, models_, {}, {}, tower, options_.detection);
  seen.stack = believe(shapes_, cell_.layout, belief_.stack, sightings).stack;
  if (!options_.measure_placed) believe_the_plan(seen.stack, belief_.stack);
  seen.stack = steadied(shapes_, Stack{seen.stack}, options_.most_friction).stones;
  result_.seconds.detection += watch.seconds();
  // Where the new stone went astray or one leans on the tower, something else comes first.
  if (seen.stack.size() != belief_.stack.size() || stray_at_stack(shapes_, seen)) return;
  const PoseDifference off = difference(seen.stack.back().T_W_O, belief_.stack.back().T_W_O);
  if (off.translation <= options_.placed_shift && off.angle <= options_.placed_turn) search_ahead(seen);
}

void Builder::search_ahead(const Belief& belief) {
  if (belief.loose.empty() || height_is_reached(belief)) return;
  const Stopwatch watch;
  struct Restored {  // whatever the search ends with
    Builder& builder;
    Belief belief = builder.belief_;
    std::size_t level = builder.last_level_;
    Ways ways = builder.last_ways_;
    ~Restored() {
      builder.belief_ = std::move(belief);
      builder.last_level_ = level;
      builder.last_ways_ = ways;
      builder.forget_reach();
    }
  } restored{*this};
  belief_ = belief;
  forget_reach();
  const std::vector<int> held = held_stones();
  if (!held.empty()) {
    SearchResult found = search_by_friction();
    if (!found.best.empty()) ahead_ = Ahead{belief, held, std::move(found), last_level_, last_ways_};
  }
  result_.seconds.search += watch.seconds();
}

std::vector<int> Builder::held_stones() const {
  std::vector<int> stones;
  for (const PlacedStone& stone : make_problem(belief_, Ways::kInOneGo).available)
    stones.push_back(stone.stone);
  return stones;
}

void Builder::keep_ahead() {
  if (!ahead_) return;
  if (!alike(ahead_->belief.stack, belief_.stack, shapes_, kSameLevel, kSameTilt) ||
      !alike(ahead_->belief.loose, belief_.loose, shapes_, kSameShift, kSameTurn)) {
    ahead_.reset();
    return;
  }
  belief_.stack = ahead_->belief.stack;
  forget_reach();
  if (held_stones() != ahead_->held)
    ahead_.reset();  // a millimetre decided whether the hand gets hold of one
}

SearchResult Builder::search() {
  if (!ahead_) return search_by_friction();
  last_level_ = ahead_->level;
  last_ways_ = ahead_->ways;
  return std::move(std::exchange(ahead_, std::nullopt)->found);
}

}  // namespace stonestack::stacking
