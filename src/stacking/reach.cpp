#include "stacking/reach.hpp"

#include <algorithm>
#include <utility>

namespace stonestack {

Reach::Reach(Belief belief, PlanningScene scene, const Catalogue& catalogue, const MotionOptions& options)
    : belief_(std::move(belief)), scene_(std::move(scene)), catalogue_(catalogue), options_(options) {}

bool Reach::in_one_go(int stone, const Pose& T_W_O, const Stack& below, const std::vector<Pose>& avoid) {
  const GraspFinder& finder = direct(stone);
  const GraspCheck check = finder.check(T_W_O, avoid.empty() ? 1 : 0, planned(below));
  return std::any_of(check.usable.begin(), check.usable.end(), [&](int k) {
    return !is_near_grasp(avoid, finder.set().grasps[static_cast<std::size_t>(k)].T_O_T);
  });
}

bool Reach::by_turning(int stone, const Pose& T_W_O, const Stack& below, const std::vector<Pose>& avoid,
                       const RegraspOptions& regrasp) {
  auto at = turning_.find(stone);
  if (at == turning_.end()) {
    const auto task = lying(stone);
    RegraspFinder made(scene_, *task.stone, task.object, task.T_W_O_pick, avoid, options_, regrasp);
    at = turning_.emplace(stone, std::move(made)).first;
  }
  return at->second.serves(T_W_O, planned(below));
}

const GraspFinder& Reach::direct(int stone) {
  auto at = direct_.find(stone);
  if (at == direct_.end()) {
    const auto task = lying(stone);
    at = direct_.emplace(stone, GraspFinder(scene_, *task.stone, task.object, task.T_W_O_pick, options_))
             .first;
  }
  return at->second;
}

PickAndPlaceTask Reach::lying(int stone) const {
  return make_task(catalogue_, belief_, stone, Pose::Identity(), Joints::Zero());
}

std::vector<SceneObject> Reach::planned(const Stack& below) const {
  std::vector<SceneObject> objects;
  for (std::size_t k = belief_.stack.size(); k < below.stones.size(); ++k) {
    const Stone& lower = catalogue_.stones[static_cast<std::size_t>(below.stones[k].stone)];
    objects.push_back({lower.name, lower.pieces, below.stones[k].T_W_O});
  }
  return objects;
}

}  // namespace stonestack
