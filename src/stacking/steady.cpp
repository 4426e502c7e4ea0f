#include "stacking/steady.hpp"

#include <algorithm>

#include "search/search_context.hpp"

namespace stonestack::stacking {
namespace {

constexpr double kSigma = 0.001;     // m
constexpr double kSigmaTurn = 0.01;  // rad
constexpr int kTries = 24;

}  // namespace

Pose displaced_as_measured(const Pose& T_W_O, Random& random) {
  Pose moved = T_W_O;
  for (Eigen::Index i = 0; i < 3; ++i) moved.translation()[i] += random.normal(0.0, kSigma);
  const double turn = random.normal(0.0, kSigmaTurn);
  moved.linear() = Eigen::AngleAxisd(turn, random.unit_vector()).toRotationMatrix() * moved.linear();
  return moved;
}

double off_measured(const Pose& T_W_O, const Pose& T_W_O_measured) {
  const PoseDifference error = difference(T_W_O, T_W_O_measured);
  return std::max(error.translation, kConsistent / kConsistentTurn * error.angle);
}

Stack steadied(const ShapeList& shapes, const Stack& seen, double friction) {
  Random random = Random::stream(
      seen.stones.empty() ? 0 : static_cast<std::uint64_t>(seen.stones.back().stone), "steadied");
  SearchOptions options;
  options.friction = friction;
  Stack best = seen, tried = seen;
  double nearest = kBelievable;
  for (int k = 0; k < kTries && nearest > kConsistent / 2; ++k) {
    std::string reason;
    const auto standing = standing_stack(shapes, tried, options, &reason);
    double off = 0.0;
    for (std::size_t i = 0; standing && i < seen.stones.size(); ++i)
      off = std::max(off, off_measured(standing->stones[i].T_W_O, seen.stones[i].T_W_O));
    if (standing && off < nearest) {
      nearest = off;
      best = *standing;
    }
    for (std::size_t i = 0; i < seen.stones.size(); ++i)
      tried.stones[i].T_W_O = displaced_as_measured(seen.stones[i].T_W_O, random);
  }
  return best;
}

}  // namespace stonestack::stacking
