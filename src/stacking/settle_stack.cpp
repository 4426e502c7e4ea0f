#include "stacking/settle_stack.hpp"

#include <algorithm>

#include "physics/settle.hpp"
#include "search/search_context.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::stacking {
namespace {

constexpr double kSigma = 0.001;          // m, along each axis, that the camera may err by; design choice
constexpr double kSigmaTurn = 0.01;       // rad
constexpr int kStoneTries = 12;           // the measured pose, then displaced ones
constexpr int kStackTries = 24;           // the same
constexpr double kLetDownFrom = 0.002;    // m above a measured pose
constexpr double kLetDownFriction = 0.5;  // it was seen to rest: little friction would make it slide

/// A measured pose moved by what the camera may err; the hand-eye error is common to the stack and left out.
Pose displaced(const Pose& T_W_O, Random& random) {
  Pose moved = T_W_O;
  for (Eigen::Index i = 0; i < 3; ++i) moved.translation()[i] += random.normal(0.0, kSigma);
  const double turn = random.normal(0.0, kSigmaTurn);
  moved.linear() = Eigen::AngleAxisd(turn, random.unit_vector()).toRotationMatrix() * moved.linear();
  return moved;
}

/// The measured pose, let down on the stack below. The stone was seen to rest, so when it slides off from the
/// measured pose, poses as near as the camera may err are tried; the resting pose nearest to the measurement
/// is taken, if it is near at all.
Pose lowered(const ShapeList& shapes, const Stack& below, const PlacedStone& measured, bool tower) {
  SettleOptions options;
  options.world.friction = kLetDownFriction;
  options.any_support = !tower;
  Random random = Random::stream(static_cast<std::uint64_t>(measured.stone.value()), "seated");
  Pose tried = measured.T_W_O, best = measured.T_W_O;
  double nearest = kMaxMeasured;
  for (int k = 0; k < kStoneTries && nearest > kConsistent; ++k) {
    const Pose lifted = Eigen::Translation3d(0, 0, kLetDownFrom) * tried;
    const SettleResult settled = settle(shapes, below, measured.stone, lifted, options);
    const double off = off_measured(settled.T_W_O, measured.T_W_O);
    if (settled.rests && off < nearest) {
      nearest = off;
      best = settled.T_W_O;
    }
    tried = displaced(measured.T_W_O, random);
  }
  return best;
}

/// The stack near the given one that stands.
Stack nearest_that_stands(const ShapeList& shapes, const Stack& given, double friction, bool tower) {
  Random random = Random::stream(
      given.stones.empty() ? 0 : static_cast<std::uint64_t>(given.stones.back().stone.value()), "steadied");
  SearchOptions options;
  options.friction = friction;
  Stack best = given, tried = given;
  double nearest = kMaxMeasured;
  for (int k = 0; k < kStackTries && nearest > kConsistent / 2; ++k) {
    const std::optional<Stack> standing = settled_stack(shapes, tried, options, tower).stack;
    double off = 0.0;
    for (std::size_t i = 0; standing && i < given.stones.size(); ++i)
      off = std::max(off, off_measured(standing->stones[i].T_W_O, given.stones[i].T_W_O));
    if (standing && off < nearest) {
      nearest = off;
      best = *standing;
    }
    for (std::size_t i = 0; i < given.stones.size(); ++i)
      tried.stones[i].T_W_O = displaced(given.stones[i].T_W_O, random);
  }
  return best;
}

}  // namespace

bool stands_at_some_friction(const std::vector<RestingStack>& resting) {
  return std::any_of(resting.begin(), resting.end(),
                     [](const RestingStack& at) { return at.stack.has_value(); });
}

double off_measured(const Pose& T_W_O, const Pose& T_W_O_measured) {
  const PoseDifference error = difference(T_W_O, T_W_O_measured);
  return std::max(error.translation, kConsistent / kConsistentTurn * error.angle);
}

std::vector<StoneEstimate> settle_stack(const ShapeList& shapes, const std::vector<MeasuredStone>& stack,
                                        double friction, bool tower) {
  Stack standing;
  std::vector<StoneEstimate> estimates;
  for (const auto& [estimate, moved] : stack) {
    estimates.push_back(estimate);
    const StoneIndex stone = estimate.stone;
    standing.stones.push_back({stone, moved ? lowered(shapes, standing, {stone, estimate.T_W_O_seen}, tower)
                                            : estimate.T_W_O_at_rest});
  }
  standing = nearest_that_stands(shapes, standing, friction, tower);
  for (std::size_t i = 0; i < estimates.size(); ++i) estimates[i].T_W_O_at_rest = standing.stones[i].T_W_O;
  return estimates;
}

std::vector<RestingStack> resting_stacks(const ShapeList& shapes, const Stack& stack,
                                         const SearchOptions& options, const std::vector<double>& frictions,
                                         bool tower) {
  std::vector<RestingStack> resting;
  for (const double friction : frictions) {
    SearchOptions judged = options;
    judged.friction = friction;
    StandingStack at_rest = settled_stack(shapes, stack, judged, tower);
    resting.push_back({friction, std::move(at_rest.stack), std::move(at_rest.reason)});
  }
  return resting;
}

}  // namespace stonestack::stacking
