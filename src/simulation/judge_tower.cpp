#include "simulation/judge_tower.hpp"

#include <algorithm>
#include <limits>
#include <set>

#include "stonestack/core/error.hpp"

namespace stonestack {
namespace {

constexpr double kSiteRadius = 0.12;  // m: further off, a stone on the table is no base of a tower

std::size_t at(int i) {
  return static_cast<std::size_t>(i);
}

// Who touches whom, by catalogue index; the table is a neighbour like any other.
class Neighbours {
 public:
  Neighbours(const TrueWorld& world, const std::vector<Pose>& T_W_O, double touch_gap) {
    for (const int i : world.present()) {
      const auto& shape = *world.shapes()[at(i)];
      for (const auto& sample : shape.samples) {
        const Eigen::Vector3d p_W = T_W_O[at(i)] * sample.point;
        if (p_W.z() < touch_gap) pairs_.insert({kTable, i});
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
  [[nodiscard]] std::vector<int> of(int body) const {
    std::vector<int> found;
    for (const auto& [a, b] : pairs_)
      if (a == body || b == body) found.push_back(a == body ? b : a);
    return found;
  }

 private:
  std::set<std::pair<int, int>> pairs_;
};

int find_base(const TrueWorld& world, const Neighbours& neighbours, const Eigen::Vector2d& site) {
  int base = -1;
  double nearest = kSiteRadius;
  for (const int i : neighbours.of(kTable)) {
    const double distance = (world.centre_of_mass(i).head<2>() - site).norm();
    if (distance < nearest) {
      nearest = distance;
      base = i;
    }
  }
  return base;
}

// From the table up, as long as one stone, and only one, rests on the last and touches nothing below but it.
std::vector<int> find_chain(const TrueWorld& world, const Neighbours& neighbours, const Eigen::Vector2d& site,
                            std::string* unclean) {
  std::vector<int> chain;
  for (int top = find_base(world, neighbours, site), below = kTable; top >= 0;) {
    std::vector<int> above;
    for (const int other : neighbours.of(top)) {
      if (other == below) continue;
      if (other != kTable && world.centre_of_mass(other).z() > world.centre_of_mass(top).z()) {
        above.push_back(other);
      } else {
        *unclean = concat("stone ", world.shapes()[at(top)]->name, " touches ",
                          other == kTable ? "the table" : "stone " + world.shapes()[at(other)]->name,
                          " beside the stone below it");
        return chain;
      }
    }
    chain.push_back(top);
    if (above.size() > 1)
      *unclean = concat(above.size(), " stones lie on stone ", world.shapes()[at(top)]->name);
    if (above.size() != 1) return chain;
    below = top;
    top = above.front();
  }
  return chain;
}

// The chain after the wait: what has come to lean on a neighbour by then is no clean tower either. How many
// stones of `chain`, from the table up, touch nothing that they did not touch before.
int still_clean(const TrueWorld& world, const Neighbours& before, const Neighbours& after,
                const std::vector<int>& chain, std::string* unclean) {
  for (std::size_t level = 0; level < chain.size(); ++level) {
    const auto known = before.of(chain[level]);
    for (const int other : after.of(chain[level])) {
      if (std::find(known.begin(), known.end(), other) != known.end()) continue;
      *unclean = concat("stone ", world.shapes()[at(chain[level])]->name, " has come to touch ",
                        other == kTable ? "the table" : "stone " + world.shapes()[at(other)]->name);
      return static_cast<int>(level);
    }
  }
  return static_cast<int>(chain.size());
}

// Poses by stone index, identity for absent stones.
template <class PoseOf>
std::vector<Pose> poses_of(const TrueWorld& world, const PoseOf& pose) {
  std::vector<Pose> T_W_O(world.shapes().size(), Pose::Identity());
  for (std::size_t body = 0; body < world.present().size(); ++body)
    T_W_O[at(world.present()[body])] = pose(static_cast<int>(body));
  return T_W_O;
}

}  // namespace

TowerVerdict judge_true_tower(const TrueWorld& world, const Eigen::Vector2d& site,
                              const StandOptions& options) {
  TowerVerdict verdict;
  auto& stand = verdict.stand;
  const auto before = poses_of(world, [&](int body) { return world.pose(world.present()[at(body)]); });
  const Neighbours touching(world, before, options.touch_gap);
  verdict.stones = find_chain(world, touching, site, &stand.reason);
  stand.clean = stand.reason.empty();
  World judge = world.judge_world(options.step, options.iterations);
  constexpr double kLook = 0.5;
  for (double t = 0; t < options.seconds; t += kLook) {
    throw_if_interrupted();
    judge.run(std::min(kLook, options.seconds - t));
  }
  const auto after = poses_of(world, [&](int body) { return judge.pose(body); });
  const Neighbours touching_after(world, after, options.touch_gap);
  const int clean = still_clean(world, touching, touching_after, verdict.stones, &stand.reason);
  stand.clean = stand.clean && clean == static_cast<int>(verdict.stones.size());
  bool intact = true;
  for (const int stone : verdict.stones) {
    stand.T_W_O.push_back(after[at(stone)]);
    const auto moved = difference(after[at(stone)], before[at(stone)]);
    stand.shift = std::max(stand.shift, moved.translation);
    stand.turn = std::max(stand.turn, moved.angle);
    const bool stays = moved.translation <= options.largest_shift && moved.angle <= options.largest_turn;
    if (intact && !stays)
      stand.reason = concat("stone ", world.shapes()[at(stone)]->name, " moved by ", 1e3 * moved.translation,
                            " mm and ", moved.angle, " rad in ", options.seconds, " s");
    intact = intact && stays && stand.standing < clean;
    if (intact) ++stand.standing;
  }
  stand.stands = intact && !verdict.stones.empty();
  if (verdict.stones.empty() && stand.reason.empty()) stand.reason = "no stone lies at the site";
  return verdict;
}

}  // namespace stonestack
