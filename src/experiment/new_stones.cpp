#include "experiment/new_stones.hpp"

#include <algorithm>
#include <numeric>

#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/motion/planning_scene.hpp"
#include "stonestack/stacking/observe.hpp"
#include "stonestack/stone/model_stone.hpp"

namespace stonestack::experiment {
namespace {

bool is_fit(const Stone& stone, const GripperModel& gripper, const RobotModel& robot) {
  return unfit_for_gripper(stone, gripper, robot).empty();
}

void sort_by_name(std::vector<Stone>& stones) {
  std::sort(stones.begin(), stones.end(), [](const Stone& a, const Stone& b) { return a.name < b.name; });
}

}  // namespace

NewStones::NewStones(int count, const std::string& folder, int seed, const RobotModel& robot,
                     const std::string& gripper)
    : count_(count), seed_(seed), robot_(robot), gripper_(gripper_of(with_gripper({}, gripper))) {
  require(count > 0, "a run needs at least one stone, got --new-stones ", count);
  if (folder.empty()) return;
  pool_ = read_catalogue(folder);
  std::erase_if(pool_.stones, [&](const Stone& stone) { return !is_fit(stone, gripper_, robot); });
  require(pool_.stones.size() >= static_cast<std::size_t>(count), "--new-stones ", count, ": ", folder,
          " has ", pool_.stones.size(), " stones that gripper and arm can carry");
}

Catalogue NewStones::of_run(int k, int run_seed) const {
  return pool_.stones.empty() ? generated(run_seed) : drawn(k);
}

Catalogue NewStones::drawn(int k) const {
  const auto count = static_cast<std::size_t>(count_), index = static_cast<std::size_t>(k - 1);
  const std::size_t sets = pool_.stones.size() / count;
  std::vector<std::size_t> order(pool_.stones.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  Random::stream(static_cast<std::uint64_t>(seed_), concat("new stones, round ", index / sets))
      .shuffle(order.begin(), order.end());
  Catalogue set{pool_.path, {}};
  for (std::size_t i = 0; i < count; ++i) set.stones.push_back(pool_.stones[order[index % sets * count + i]]);
  sort_by_name(set.stones);
  return set;
}

Catalogue NewStones::generated(int run_seed) const {
  Catalogue set{"generated", {}};
  for (int number = 1; set.stones.size() < static_cast<std::size_t>(count_); ++number) {
    Stone stone = model_limestone(static_cast<std::uint64_t>(run_seed), number).stone;
    stone.name = concat("limestone_", run_seed, "_", number);
    if (is_fit(stone, gripper_, robot_)) set.stones.push_back(std::move(stone));
  }
  sort_by_name(set.stones);
  return set;
}

}  // namespace stonestack::experiment
