#include "stacking/steady.hpp"

#include <algorithm>
#include <optional>

#include "stonestack/core/random.hpp"
#include "stonestack/physics/settle.hpp"

namespace stonestack {
namespace {

constexpr double kSigma = 0.001;     // m
constexpr double kSigmaTurn = 0.01;  // rad
constexpr double kStandSeconds = 2.0;
constexpr double kStill = 1e-7;  // m in 0.1 s, as in the verdicts of the search
constexpr int kTries = 24;

bool stands(const ShapeList& shapes, const Stack& stack, double friction) {
  StandOptions stand;
  stand.friction = friction;
  stand.seconds = kStandSeconds;
  stand.still = kStill;
  stand.fall = 0.0;
  const StandVerdict verdict = judge_stack(shapes, stack, stand);
  return verdict.stands && verdict.clean;
}

/// The stack built anew from poses near the given ones; empty if a stone ends too far from where it was seen.
/// `random`: empty to begin at the given poses themselves.
std::optional<Stack> let_down(const ShapeList& shapes, const Stack& seen, double friction, Random* random,
                              double* off) {
  SettleOptions settling;
  settling.world.friction = friction;
  Stack built;
  *off = 0.0;
  for (const PlacedStone& stone : seen.stones) {
    const Pose T_W_O = random != nullptr ? displaced_as_measured(stone.T_W_O, *random) : stone.T_W_O;
    const Pose lifted = Eigen::Translation3d(0, 0, kSettleFrom) * T_W_O;
    const SettleResult at_rest = settle(shapes, built, stone.stone, lifted, settling);
    *off = std::max(*off, off_measured(at_rest.T_W_O, stone.T_W_O));
    if (!at_rest.rests || *off > kBelievable) return std::nullopt;
    built.stones.push_back({stone.stone, at_rest.T_W_O});
  }
  return built;
}

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
  if (seen.stones.empty() || stands(shapes, seen, friction)) return seen;
  Random random = Random::stream(static_cast<std::uint64_t>(seen.stones.back().stone), "steadied");
  Stack best = seen;
  double nearest = kBelievable;
  for (int k = 0; k < kTries && nearest > kConsistent / 2; ++k) {
    double off = 0.0;
    auto built = let_down(shapes, seen, friction, k > 0 ? &random : nullptr, &off);
    if (!built || off >= nearest || !stands(shapes, *built, friction)) continue;
    nearest = off;
    best = std::move(*built);
  }
  return best;
}

}  // namespace stonestack
