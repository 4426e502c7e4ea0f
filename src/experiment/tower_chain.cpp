#include "experiment/tower_chain.hpp"

#include <algorithm>

#include "stonestack/core/error.hpp"

namespace stonestack::experiment {
namespace {

constexpr double kSiteRadius = 0.12;  // m: further off, a stone on the table is no base of a tower

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

Eigen::Vector3d centre_of_mass(const TrueWorld& world, const std::vector<Pose>& T_W_O, int stone) {
  return T_W_O[at(stone)] * world.shapes()[at(stone)]->mass.p_O_M;
}

int find_base(const TrueWorld& world, const std::vector<Pose>& T_W_O, const Neighbours& neighbours,
              const Eigen::Vector2d& site) {
  int base = -1;
  double nearest = kSiteRadius;
  for (const int i : neighbours.of(kTable)) {
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
    T_W_O[at(world.present()[body])] = pose(static_cast<int>(body));
  return T_W_O;
}

}  // namespace

Neighbours::Neighbours(const TrueWorld& world, const std::vector<Pose>& T_W_O, double touch_gap) {
  for (const int i : world.present()) {
    const auto& shape = *world.shapes()[at(i)];
    for (const auto& sample : shape.samples) {
      const Eigen::Vector3d p_W = T_W_O[at(i)] * sample.point;
      if (p_W.z() - world.table().height(p_W) < touch_gap) pairs_.insert({kTable, i});
      for (const int j : world.present()) {
        if (j == i) continue;
        const auto& other = *world.shapes()[at(j)];
        if ((p_W - T_W_O[at(j)] * other.mass.p_O_M).norm() > other.radius + touch_gap) continue;
        if (other.distance.distance(T_W_O[at(j)].inverse() * p_W) < touch_gap)
          pairs_.insert({std::min(i, j), std::max(i, j)});
      }
    }
  }
}

std::vector<int> Neighbours::of(int body) const {
  std::vector<int> found;
  for (const auto& [a, b] : pairs_)
    if (a == body || b == body) found.push_back(a == body ? b : a);
  return found;
}

std::vector<Pose> true_poses(const TrueWorld& world) {
  return poses_of(world, [&](int body) { return world.pose(world.present()[at(body)]); });
}

std::vector<Pose> judged_poses(const TrueWorld& world, const World& judge) {
  return poses_of(world, [&](int body) { return judge.pose(body); });
}

TowerChain find_chain(const TrueWorld& world, const std::vector<Pose>& T_W_O, const Neighbours& neighbours,
                      const Eigen::Vector2d& site) {
  TowerChain chain;
  for (int top = find_base(world, T_W_O, neighbours, site), below = kTable; top >= 0;) {
    std::vector<int> above;
    for (const int other : neighbours.of(top)) {
      if (other == below) continue;
      if (other != kTable &&
          centre_of_mass(world, T_W_O, other).z() > centre_of_mass(world, T_W_O, top).z()) {
        above.push_back(other);
      } else {
        chain.unclean = concat("stone ", world.shapes()[at(top)]->name, " touches ",
                               other == kTable ? "the table" : "stone " + world.shapes()[at(other)]->name,
                               " beside the stone below it");
        return chain;
      }
    }
    chain.stones.push_back(top);
    if (above.size() > 1)
      chain.unclean = concat(above.size(), " stones lie on stone ", world.shapes()[at(top)]->name);
    if (above.size() != 1) return chain;
    below = top;
    top = above.front();
  }
  return chain;
}

CleanPart still_clean(const TrueWorld& world, const Neighbours& before, const Neighbours& after,
                      const std::vector<int>& chain) {
  for (std::size_t level = 0; level < chain.size(); ++level) {
    const auto known = before.of(chain[level]);
    for (const int other : after.of(chain[level])) {
      if (std::find(known.begin(), known.end(), other) != known.end()) continue;
      return {static_cast<int>(level),
              concat("stone ", world.shapes()[at(chain[level])]->name, " has come to touch ",
                     other == kTable ? "the table" : "stone " + world.shapes()[at(other)]->name)};
    }
  }
  return {static_cast<int>(chain.size()), ""};
}

}  // namespace stonestack::experiment
