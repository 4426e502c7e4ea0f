#include "experiment/tower_chain.hpp"

#include <algorithm>

#include "stonestack/core/error.hpp"

namespace stonestack::experiment {
namespace {

constexpr double kSiteRadius = 0.12;  // m: further off, a stone on the table is no base of a tower

Eigen::Vector3d centre_of_mass(const TrueWorld& world, const std::vector<Pose>& T_W_O, StoneIndex stone) {
  return at(T_W_O, stone) * at(world.shapes(), stone)->mass.p_O_M;
}

StoneIndex find_base(const TrueWorld& world, const std::vector<Pose>& T_W_O, const Neighbours& neighbours,
                     const Eigen::Vector2d& site) {
  StoneIndex base = kNoStone;
  double nearest = kSiteRadius;
  for (const StoneIndex i : neighbours.of(kTableNode)) {
    if (world.is_foreign(i)) continue;
    const double distance = (centre_of_mass(world, T_W_O, i).head<2>() - site).norm();
    if (distance < nearest) {
      nearest = distance;
      base = i;
    }
  }
  return base;
}

template <class PoseOf>
std::vector<Pose> poses_of(const TrueWorld& world, const PoseOf& pose) {
  std::vector<Pose> T_W_O(world.shapes().size(), Pose::Identity());
  for (std::size_t body = 0; body < world.present().size(); ++body)
    at(T_W_O, world.present()[body]) = pose(static_cast<int>(body));
  return T_W_O;
}

}  // namespace

Neighbours::Neighbours(const TrueWorld& world, const std::vector<Pose>& T_W_O, double touch_gap) {
  for (const StoneIndex i : world.present()) {
    const auto& shape = *at(world.shapes(), i);
    for (const auto& sample : shape.samples) {
      const Eigen::Vector3d p_W = at(T_W_O, i) * sample.point;
      if (p_W.z() - world.table().height(p_W) < touch_gap) pairs_.insert({kTableNode, i});
      for (const StoneIndex j : world.present()) {
        if (j == i) continue;
        const auto& other = *at(world.shapes(), j);
        if ((p_W - at(T_W_O, j) * other.mass.p_O_M).norm() > other.radius + touch_gap) continue;
        if (other.distance.distance(at(T_W_O, j).inverse() * p_W) < touch_gap)
          pairs_.insert({std::min(i, j), std::max(i, j)});
      }
    }
  }
}

std::vector<StoneIndex> Neighbours::of(StoneIndex stone) const {
  std::vector<StoneIndex> found;
  for (const auto& [a, b] : pairs_)
    if (a == stone || b == stone) found.push_back(a == stone ? b : a);
  return found;
}

std::vector<Pose> true_poses(const TrueWorld& world) {
  return poses_of(world,
                  [&](int body) { return world.pose(world.present()[static_cast<std::size_t>(body)]); });
}

std::vector<Pose> judged_poses(const TrueWorld& world, const RigidWorld& judge) {
  return poses_of(world, [&](int body) { return judge.pose(body); });
}

TowerChain find_chain(const TrueWorld& world, const std::vector<Pose>& T_W_O, const Neighbours& neighbours,
                      const Eigen::Vector2d& site) {
  TowerChain chain;
  for (StoneIndex top = find_base(world, T_W_O, neighbours, site), below = kTableNode; top != kNoStone;) {
    std::vector<StoneIndex> above;
    for (const StoneIndex other : neighbours.of(top)) {
      if (other == below) continue;
      if (other != kTableNode &&
          centre_of_mass(world, T_W_O, other).z() > centre_of_mass(world, T_W_O, top).z()) {
        above.push_back(other);
      } else {
        chain.unclean = concat("stone ", at(world.shapes(), top)->name, " touches ",
                               other == kTableNode ? "the table" : "stone " + at(world.shapes(), other)->name,
                               " beside the stone below it");
        return chain;
      }
    }
    chain.stones.push_back(top);
    if (above.size() > 1)
      chain.unclean = concat(above.size(), " stones lie on stone ", at(world.shapes(), top)->name);
    if (above.size() != 1) return chain;
    below = top;
    top = above.front();
  }
  return chain;
}

CleanPart still_clean(const TrueWorld& world, const Neighbours& before, const Neighbours& after,
                      const std::vector<StoneIndex>& chain) {
  for (std::size_t level = 0; level < chain.size(); ++level) {
    const auto known = before.of(chain[level]);
    for (const StoneIndex other : after.of(chain[level])) {
      if (std::find(known.begin(), known.end(), other) != known.end()) continue;
      return {static_cast<int>(level),
              concat("stone ", at(world.shapes(), chain[level])->name, " has come to touch ",
                     other == kTableNode ? "the table" : "stone " + at(world.shapes(), other)->name)};
    }
  }
  return {static_cast<int>(chain.size()), ""};
}

}  // namespace stonestack::experiment
