#include "stacking/reach.hpp"

#include <algorithm>
#include <utility>

namespace stonestack::stacking {
namespace {

constexpr double kNearer = 0.5;   // share of the usual padding
constexpr double kSlowly = 0.02;  // m/s: guarded, 0.4 mm past what is met

MotionOptions near_table(MotionOptions options) {
  options.approach_padding *= kNearer;
  options.approach_speed = std::min(options.approach_speed, kSlowly);
  return options;
}

}  // namespace

Reach::Reach(Arrangement arrangement, PlanningScene scene, const Catalogue& catalogue,
             const MotionOptions& options)
    : arrangement_(std::move(arrangement)),
      scene_(std::move(scene)),
      catalogue_(catalogue),
      options_(options),
      near_table_(near_table(options)) {}

bool Reach::in_one_go(StoneIndex stone, const Pose& T_W_O, const Stack& below,
                      const std::vector<Pose>& avoid) {
  const GraspFinder& finder = direct(stone);
  GraspCheck check = finder.check(T_W_O, avoid.empty() ? 1 : 0, planned(below));
  const bool serves = std::any_of(check.usable.begin(), check.usable.end(), [&](int k) {
    return !is_near_grasp(avoid, finder.set().grasps[static_cast<std::size_t>(k)].T_O_T);
  });
  if (!serves) refused_[stone] = std::move(check);
  return serves;
}

std::string Reach::refusal(StoneIndex stone) const {
  const auto at = refused_.find(stone);
  return at == refused_.end() ? "" : at->second.text();
}

bool Reach::by_reorienting(StoneIndex stone, const Pose& T_W_O, const Stack& below,
                           const std::vector<Pose>& avoid, const RegraspOptions& regrasp) {
  const auto same = [](const Pose& a, const Pose& b) { return a.matrix() == b.matrix(); };
  auto at = turning_.find(stone);
  if (at == turning_.end() ||
      !std::equal(at->second.avoided.begin(), at->second.avoided.end(), avoid.begin(), avoid.end(), same)) {
    const auto task = lying(stone);
    RegraspFinder made(scene_, *task.stone, task.object, task.T_W_O_pick, avoid, options_for(stone), regrasp);
    at = turning_.insert_or_assign(stone, Turning{avoid, std::move(made)}).first;
  }
  return at->second.finder.serves(T_W_O, planned(below));
}

const GraspFinder& Reach::direct(StoneIndex stone) {
  auto at = direct_.find(stone);
  if (at == direct_.end()) {
    const auto task = lying(stone);
    const auto with = [&](const MotionOptions& options) {
      return GraspFinder(scene_, *task.stone, task.object, task.T_W_O_pick, options);
    };
    GraspFinder usual = with(options_);
    if (!usual.at_pick().can_be_held())
      if (GraspFinder low = with(near_table_); low.at_pick().can_be_held()) {
        low_.insert(stone);
        usual = std::move(low);
      }
    at = direct_.emplace(stone, std::move(usual)).first;
  }
  return at->second;
}

PickAndPlaceTask Reach::lying(StoneIndex stone) const {
  return make_task(catalogue_, arrangement_, stone, Pose::Identity(), Joints::Zero());
}

std::vector<SceneObject> Reach::planned(const Stack& below) const {
  std::vector<SceneObject> objects;
  for (std::size_t k = arrangement_.stack.size(); k < below.stones.size(); ++k) {
    const Stone& lower = catalogue_[below.stones[k].stone];
    objects.push_back({lower.name, lower.pieces, below.stones[k].T_W_O});
  }
  return objects;
}

}  // namespace stonestack::stacking
