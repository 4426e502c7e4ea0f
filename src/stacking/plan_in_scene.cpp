#include <algorithm>

#include "stonestack/core/error.hpp"
#include "stonestack/motion/pick_and_place.hpp"
#include "stonestack/stacking/observe.hpp"
#include "stonestack/stacking/scene_tasks.hpp"

namespace stonestack::stacking {
namespace {

/// The layout with what the scene adds to it: a scene may ask for more clearance than the cell, not for less.
CellLayout layout_in(const SceneFile& file, CellLayout layout) {
  const std::vector<PairPadding> of_cell = layout.paddings;
  layout.obstacles.insert(layout.obstacles.end(), file.obstacles.begin(), file.obstacles.end());
  for (PairPadding pair : file.paddings) {
    for (const PairPadding& padding : of_cell)
      if (padding.b == pair.b) pair.m = std::max(pair.m, padding.m);
    layout.paddings.push_back(pair);
  }
  return layout;
}

std::vector<PlacedStone> placed(const std::vector<NamedPose>& stones, const Catalogue& catalogue) {
  std::vector<PlacedStone> list;
  for (const auto& item : stones) list.push_back({catalogue.index(item.stone), item.T_W_O});
  return list;
}

}  // namespace

ScenePlan plan_in_scene(const ScenePlanTask& task, const Catalogue& catalogue) {
  require(!task.targets.empty(), "a plan needs a target");
  const SceneFile file = read_scene_file(task.scene);
  const Arrangement arrangement{placed(file.stack, catalogue), placed(file.stones, catalogue)};
  ScenePlan planned;
  planned.scene = make_planning_scene(layout_in(file, task.layout), task.robot, catalogue, arrangement);
  std::string refusals;
  for (const NamedPose& target : task.targets) {
    throw_if_interrupted();
    planned.task =
        make_task(catalogue, arrangement, catalogue.index(target.stone), target.T_W_O, task.q_start);
    planned.plan = {};
    planned.plan.status = PickAndPlacePlan::Status::kNoReach;
    planned.plan.reason = scene_problem(planned.scene, planned.task);
    if (planned.plan.reason.empty()) {
      planned.plan = plan_pick_and_place(planned.scene, planned.task, task.options);
      if (planned.plan.status == PickAndPlacePlan::Status::kPlanned) return planned;
    }
    const std::string refusal = concat(target.stone, ": ", planned.plan.reason);
    if (refusals.find(refusal) == std::string::npos) refusals += (refusals.empty() ? "" : "; ") + refusal;
  }
  planned.plan.reason = refusals;
  return planned;
}

}  // namespace stonestack::stacking
