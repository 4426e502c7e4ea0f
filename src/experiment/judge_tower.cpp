#include "stonestack/experiment/experiment.hpp"

#include <algorithm>
#include <cmath>

#include "experiment/tower_chain.hpp"
#include "physics/shake.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::experiment {
namespace {

constexpr double kClaimedShift = 0.03;  // m from where the program says that a stone of a wall is
constexpr double kClaimedTurn = 0.35;   // rad likewise
constexpr double kShakenShift = 0.010;  // m that a stone of a wall may move by a shake

void pass(RigidWorld& judge, double step, double seconds) {
  const long steps = std::max(1L, std::lround(seconds / step));
  for (long i = 0; i < steps; ++i) judge.step(step);
}

void run_at_rest(RigidWorld& judge, double step, double seconds) {
  constexpr double kCheckPeriod = 0.5;  // s between two checks for an interrupt
  for (double t = 0; t < seconds; t += kCheckPeriod) {
    throw_if_interrupted();
    pass(judge, step, std::min(kCheckPeriod, seconds - t));
  }
}

// Stones of the chain, from the table up, that lie where they lay.
int count_still(const std::vector<Pose>& before, const std::vector<Pose>& after,
                const std::vector<StoneIndex>& chain, const StandOptions& bounds) {
  int count = 0;
  for (const StoneIndex stone : chain) {
    const auto moved = difference(at(after, stone), at(before, stone));
    if (moved.translation > bounds.max_shift || moved.angle > bounds.max_turn) return count;
    ++count;
  }
  return count;
}

/// The stones of a wall that are where it is said, in its order.
std::vector<StoneIndex> stones_there(const TrueWorld& world, const std::vector<Pose>& T_W_O,
                                     const std::vector<PlacedStone>& claimed) {
  std::vector<StoneIndex> there;
  for (const PlacedStone& stone : claimed) {
    const auto& present = world.present();
    if (std::find(present.begin(), present.end(), stone.stone) == present.end()) continue;
    const Eigen::Vector3d& p_O_M = at(world.shapes(), stone.stone)->mass.p_O_M;
    const Pose& T_W_O_true = at(T_W_O, stone.stone);
    if ((T_W_O_true * p_O_M - stone.T_W_O * p_O_M).norm() <= kClaimedShift &&
        difference(T_W_O_true, stone.T_W_O).angle <= kClaimedTurn)
      there.push_back(stone.stone);
  }
  return there;
}

/// Stones of a wall, each by itself, that lie where they lay.
int count_still_each(const std::vector<Pose>& before, const std::vector<Pose>& after,
                     const std::vector<StoneIndex>& stones, double max_shift, double max_turn) {
  return static_cast<int>(std::count_if(stones.begin(), stones.end(), [&](StoneIndex stone) {
    const auto moved = difference(at(after, stone), at(before, stone));
    return moved.translation <= max_shift && moved.angle <= max_turn;
  }));
}

}  // namespace

StandOptions tower_bounds() {
  return {.seconds = 60.0, .max_shift = 0.005, .max_turn = 0.0523599};  // 3 deg
}

TowerVerdict judge_tower(const SimulatedCell& cell, const StandOptions& options, const std::string& engine) {
  const TrueWorld& world = cell.world();
  TowerVerdict verdict;
  auto& stand = verdict.stand;
  const auto before = true_poses(world);
  const Neighbours touching(world, before, options.touch_gap);
  TowerChain chain = find_chain(world, before, touching, cell.site());
  verdict.stones = std::move(chain.stones);
  stand.reason = std::move(chain.unclean);
  stand.clean = stand.reason.empty();
  const auto judge = world.judge_world(options.step, options.iterations, engine_named(engine));
  run_at_rest(*judge, options.step, options.seconds);
  const auto after = judged_poses(world, *judge);
  const Neighbours touching_after(world, after, options.touch_gap);
  const CleanPart clean = still_clean(world, touching, touching_after, verdict.stones);
  if (!clean.unclean.empty()) stand.reason = clean.unclean;
  stand.clean = stand.clean && clean.unclean.empty();
  bool intact = true;
  for (const StoneIndex stone : verdict.stones) {
    stand.T_W_O.push_back(at(after, stone));
    const auto moved = difference(at(after, stone), at(before, stone));
    stand.shift = std::max(stand.shift, moved.translation);
    stand.turn = std::max(stand.turn, moved.angle);
    const bool stays = moved.translation <= options.max_shift && moved.angle <= options.max_turn;
    if (intact && !stays)
      stand.reason = concat("stone ", at(world.shapes(), stone)->name, " moved by ", 1e3 * moved.translation,
                            " mm and ", moved.angle, " rad in ", options.seconds, " s");
    intact = intact && stays && stand.standing < clean.stones;
    if (intact) ++stand.standing;
  }
  stand.stands = intact && !verdict.stones.empty();
  if (verdict.stones.empty() && stand.reason.empty()) stand.reason = "no stone lies at the site";
  return verdict;
}

TowerVerdict judge_wall(const SimulatedCell& cell, const std::vector<PlacedStone>& claimed,
                        const StandOptions& options, const std::string& engine) {
  const TrueWorld& world = cell.world();
  TowerVerdict verdict;
  auto& stand = verdict.stand;
  const auto before = true_poses(world);
  verdict.stones = stones_there(world, before, claimed);
  const auto judge = world.judge_world(options.step, options.iterations, engine_named(engine));
  run_at_rest(*judge, options.step, options.seconds);
  const auto after = judged_poses(world, *judge);
  stand.standing = count_still_each(before, after, verdict.stones, options.max_shift, options.max_turn);
  for (const StoneIndex stone : verdict.stones) {
    stand.T_W_O.push_back(at(after, stone));
    const auto moved = difference(at(after, stone), at(before, stone));
    stand.turn = std::max(stand.turn, moved.angle);
    if (moved.translation <= stand.shift) continue;
    stand.shift = moved.translation;
    if (moved.translation > options.max_shift)
      stand.reason = concat("stone ", at(world.shapes(), stone)->name, " moved by ", 1e3 * moved.translation,
                            " mm in ", options.seconds, " s");
  }
  if (verdict.stones.size() < claimed.size())
    stand.reason = concat(claimed.size() - verdict.stones.size(), " of ", claimed.size(),
                          " stones are not where the program says");
  stand.clean = true;
  stand.stands = !claimed.empty() && stand.standing == static_cast<int>(claimed.size());
  return verdict;
}

Survival try_tower(const SimulatedCell& cell, const SurvivalOptions& options, const StandOptions& bounds,
                   const std::vector<PlacedStone>& wall) {
  const TrueWorld& world = cell.world();
  const auto before = true_poses(world);
  const std::vector<StoneIndex> chain =
      wall.empty()
          ? find_chain(world, before, Neighbours(world, before, bounds.touch_gap), cell.site()).stones
          : stones_there(world, before, wall);
  const auto still = [&](const std::vector<Pose>& after) {
    return wall.empty() ? count_still(before, after, chain, bounds)
                        : count_still_each(before, after, chain, bounds.max_shift, bounds.max_turn);
  };
  Survival survival;
  const auto judge = world.judge_world(bounds.step, bounds.iterations);
  double t = 0.0;
  for (const double seconds : options.seconds) {
    run_at_rest(*judge, bounds.step, seconds - t);
    t = seconds;
    survival.standing.push_back(still(judged_poses(world, *judge)));
  }
  survival.shaken = static_cast<int>(chain.size());
  for (const Eigen::Index axis : {0, 1}) {
    const auto shaken = world.judge_world(bounds.step, bounds.iterations);
    shake_world(*shaken, options.shake, Eigen::Vector3d::Unit(axis), bounds.step);
    const auto after = judged_poses(world, *shaken);
    if (!wall.empty()) {
      survival.shaken =
          std::min(survival.shaken, count_still_each(before, after, chain, kShakenShift, kClaimedTurn));
      continue;
    }
    const std::vector<StoneIndex> left =
        find_chain(world, after, Neighbours(world, after, bounds.touch_gap), cell.site()).stones;
    const auto same =
        std::mismatch(chain.begin(), chain.end(), left.begin(), left.end()).first - chain.begin();
    survival.shaken = std::min(survival.shaken, static_cast<int>(same));
  }
  return survival;
}

}  // namespace stonestack::experiment
