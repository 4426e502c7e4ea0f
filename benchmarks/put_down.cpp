#include "put_down.hpp"

#include <algorithm>
#include <cmath>

#include "physics/settle.hpp"
#include "physics/shape.hpp"

namespace stonestack::bench {
namespace {

constexpr double kDrop = 0.001, kRaise = 0.0005;  // m
constexpr double kFar = 0.03;                     // m
constexpr int kMaxRaises = 40;
constexpr int kMaxDraws = 50;  // of centres of mass, until the stack below stands with them

Pose displaced(const Pose& T_W_O, const Eigen::Vector3d& p_O_M, const PlacementNoise& noise, Random& random) {
  Eigen::Vector3d shift, turn;
  for (int axis = 0; axis < 3; ++axis) {
    shift[axis] = random.normal(0.0, noise.shift);
    turn[axis] = random.normal(0.0, noise.turn);
  }
  Pose moved = T_W_O;
  if (turn.norm() > 1e-12) {
    const Eigen::Vector3d p_W_M = T_W_O * p_O_M;
    moved = Eigen::Translation3d(p_W_M) * Eigen::AngleAxisd(turn.norm(), turn.normalized()) *
            Eigen::Translation3d(-p_W_M) * T_W_O;
  }
  moved.pretranslate(shift);
  return moved;
}

bool top_penetrates(const ShapeList& shapes, const Stack& stack) {
  const std::vector<Contact> contacts = geometric_contacts(shapes, stack, 0.0);
  const int top = static_cast<int>(stack.stones.size()) - 1;
  return std::any_of(contacts.begin(), contacts.end(),
                     [&](const Contact& c) { return c.above == top && c.gap < 0.0; });
}

Eigen::Vector3d com_error(const PlacementNoise& noise, Random& random) {
  if (noise.com == 0.0) return Eigen::Vector3d::Zero();
  return {random.normal(0.0, noise.com), random.normal(0.0, noise.com), random.normal(0.0, noise.com)};
}

StandOptions stand_options(const PlacementNoise& noise) {
  StandOptions stand;
  stand.friction = noise.friction;
  stand.seconds = noise.stands;
  return stand;
}

/// Errors of the centres of mass below with which the stack stands, as it does.
std::vector<Eigen::Vector3d> com_errors(const ShapeList& shapes, const Stack& below,
                                        const PlacementNoise& noise, Random& random) {
  StandOptions stand = stand_options(noise);
  for (int k = 0; k < kMaxDraws; ++k) {
    stand.com_error_O.clear();
    for (std::size_t i = 0; i < below.stones.size(); ++i)
      stand.com_error_O.push_back(com_error(noise, random));
    if (noise.com == 0.0 || below.stones.empty() || judge_stack(shapes, below, stand).stands) break;
  }
  return stand.com_error_O;
}

/// The stack with the stone where it is let go: beside its target, just above where it would touch.
Stack let_go(const ShapeList& shapes, const Stack& below, const Placement& target,
             const PlacementNoise& noise, Random& random) {
  Stack higher = below;
  const Eigen::Vector3d& p_O_M = at(shapes, target.stone)->mass.p_O_M;
  higher.stones.push_back({target.stone, displaced(target.T_W_O, p_O_M, noise, random)});
  PlacedStone& top = higher.stones.back();
  top.T_W_O.pretranslate(Eigen::Vector3d(0, 0, kDrop));
  for (int k = 0; k < kMaxRaises && top_penetrates(shapes, higher); ++k)
    top.T_W_O.pretranslate(Eigen::Vector3d(0, 0, kRaise));
  return higher;
}

bool went_far(const Pose& T_W_before, const Pose& T_W_after) {
  return (T_W_after.translation() - T_W_before.translation()).norm() > kFar;
}

}  // namespace

std::optional<Stack> put_down(const ShapeList& shapes, const Stack& below, const Placement& target,
                              const PlacementNoise& noise, Random& random) {
  Stack higher = let_go(shapes, below, target, noise, random);
  PlacedStone& top = higher.stones.back();
  SettleOptions settling;
  settling.world.friction = noise.friction;
  StandOptions stand = stand_options(noise);
  stand.com_error_O = com_errors(shapes, below, noise, random);
  stand.com_error_O.push_back(com_error(noise, random));
  settling.com_error_O = stand.com_error_O.back();
  const SettleResult at_rest = settle(shapes, below, target.stone, top.T_W_O, settling);
  if (!at_rest.rests) return std::nullopt;
  top.T_W_O = at_rest.T_W_O;
  const StandVerdict verdict = judge_stack(shapes, higher, stand);
  if (!verdict.stands || !verdict.clean) return std::nullopt;
  for (std::size_t k = 0; k < higher.stones.size(); ++k) higher.stones[k].T_W_O = verdict.T_W_O[k];
  return higher;
}

std::optional<Stack> set_down_in_wall(const ShapeList& shapes, const Stack& below, const Placement& target,
                                      const PlacementNoise& noise, Random& random) {
  Stack higher = let_go(shapes, below, target, noise, random);
  StandOptions stand = stand_options(noise);
  stand.max_shift = kFar;
  stand.max_turn = M_PI;
  stand.fall = 0.0;
  const StandVerdict verdict = judge_stack(shapes, higher, stand);
  for (std::size_t k = 0; k < below.stones.size(); ++k)
    if (went_far(below.stones[k].T_W_O, verdict.T_W_O[k])) return std::nullopt;
  for (std::size_t k = 0; k < higher.stones.size(); ++k) higher.stones[k].T_W_O = verdict.T_W_O[k];
  if (went_far(target.T_W_O, higher.stones.back().T_W_O)) higher.stones.pop_back();
  return higher;
}

}  // namespace stonestack::bench
