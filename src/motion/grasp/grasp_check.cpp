#include "motion/grasp_check.hpp"

#include <algorithm>
#include <optional>

#include "motion/grasp/grasp_end.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::motion {
namespace {

/// How the faults of one end are called in the list of all.
GraspFault fault_at_pick(EndFault fault) {
  return static_cast<GraspFault>(static_cast<int>(fault));
}
GraspFault fault_at_place(EndFault fault) {
  constexpr int kBetween =
      static_cast<int>(GraspFault::kTableAtPlace) - static_cast<int>(GraspFault::kTableAtPick);
  return fault == EndFault::kTooWeak ? GraspFault::kTooWeak
                                     : static_cast<GraspFault>(static_cast<int>(fault) + kBetween);
}

}  // namespace

struct GraspFinder::Parts : PickSide {
  using PickSide::PickSide;
  GraspCheck pick;  ///< of the pick side alone
};

GraspFinder::GraspFinder(const PlanningScene& scene, const Stone& stone, int object, const Pose& T_W_O_pick,
                         const MotionOptions& options) {
  require(is_valid(T_W_O_pick), "the pose of ", stone.name,
          " is not a pose: ", geometry::to_text(T_W_O_pick));
  require(object >= -1 && object < static_cast<int>(scene.objects.size()), "stone ", stone.name,
          " is object ", object, " of ", scene.objects.size());
  parts_ = std::make_unique<Parts>(scene, stone, object, T_W_O_pick, options);
  GraspCheck& pick = parts_->pick;
  pick.total = static_cast<int>(parts_->set->grasps.size());
  for (int i = 0; i < pick.total; ++i) {
    throw_if_interrupted();
    const Grasp& grasp = parts_->set->grasps[static_cast<std::size_t>(i)];
    if (const auto fault = parts_->end.fault(grasp, T_W_O_pick))
      ++pick.refused[static_cast<std::size_t>(fault_at_pick(*fault))];
    else
      pick.usable.push_back(i);
  }
}
GraspFinder::~GraspFinder() = default;
GraspFinder::GraspFinder(GraspFinder&&) noexcept = default;
GraspFinder& GraspFinder::operator=(GraspFinder&&) noexcept = default;

GraspCheck GraspFinder::check(const Pose& T_W_O_place, int enough,
                              std::span<const SceneObject> meanwhile) const {
  require(is_valid(T_W_O_place), "the target of ", parts_->stone.name,
          " is not a pose: ", geometry::to_text(T_W_O_place));
  GraspCheck result = parts_->pick;
  result.usable.clear();
  std::optional<GraspEnd> later;
  if (!meanwhile.empty()) later.emplace(parts_->end.among(meanwhile));
  for (const int i : parts_->pick.usable) {
    throw_if_interrupted();
    const Grasp& grasp = parts_->set->grasps[static_cast<std::size_t>(i)];
    auto fault = parts_->end.fault(grasp, T_W_O_place);
    if (!fault && later) fault = later->fault(grasp, T_W_O_place);
    if (fault)
      ++result.refused[static_cast<std::size_t>(fault_at_place(*fault))];
    else
      result.usable.push_back(i);
    if (enough > 0 && static_cast<int>(result.usable.size()) >= enough) break;
  }
  return result;
}

bool GraspFinder::serves(const Pose& T_W_O_place) const {
  return !check(T_W_O_place, 1).usable.empty();
}

bool GraspFinder::arm_is_free(int grasp, const Joints& q) const {
  return parts_->end.arm_is_free(parts_->set->grasps[static_cast<std::size_t>(grasp)], q);
}

const GraspCheck& GraspFinder::at_pick() const {
  return parts_->pick;
}

const GraspSet& GraspFinder::set() const {
  return *parts_->set;
}

const char* to_text(GraspFault fault) {
  static const std::array<const char*, kGraspFaults> what{"could not hold the weight",
                                                          "hit the table at pick",
                                                          "hit another object at pick",
                                                          "are out of reach at pick",
                                                          "bring the arm into something at pick",
                                                          "hit the table at the target",
                                                          "hit another object at the target",
                                                          "are out of reach at the target",
                                                          "bring the arm into something at the target"};
  return what[static_cast<std::size_t>(fault)];
}

bool GraspCheck::can_be_held() const {
  return total > refused[static_cast<std::size_t>(GraspFault::kTooWeak)] +
                     refused[static_cast<std::size_t>(GraspFault::kTableAtPick)];
}

std::string GraspCheck::text() const {
  if (total == 0) return "the fingers find no grasp on it, however it lies";
  std::string parts;
  for (std::size_t i = 0; i < kGraspFaults; ++i)
    if (refused[i] > 0)
      parts += concat(parts.empty() ? " " : ", ", refused[i], " ", to_text(static_cast<GraspFault>(i)));
  return concat("of ", total, " grasps", parts.empty() ? " none was refused" : parts);
}

bool can_grasp(const PlanningScene& scene, const PickAndPlaceTask& task, const MotionOptions& options) {
  require(task.stone != nullptr, "a task needs a stone");
  return GraspFinder(scene, *task.stone, task.object, task.T_W_O_pick, options).serves(task.T_W_O_place);
}

GraspCheck check_grasps(const PlanningScene& scene, const PickAndPlaceTask& task,
                        const MotionOptions& options) {
  require(task.stone != nullptr, "a task needs a stone");
  return GraspFinder(scene, *task.stone, task.object, task.T_W_O_pick, options).check(task.T_W_O_place);
}

bool gripper_can_grasp(const PlanningScene& scene, const PickAndPlaceTask& task,
                       const MotionOptions& options) {
  require(task.stone != nullptr, "a task needs a stone");
  const auto set = cached_grasps(*task.stone, scene.gripper);
  const GraspEnd end(scene, *task.stone, task.object, options);
  return std::any_of(set->grasps.begin(), set->grasps.end(), [&](const Grasp& grasp) {
    return !end.gripper_fault(grasp, task.T_W_O_pick) && !end.gripper_fault(grasp, task.T_W_O_place);
  });
}

}  // namespace stonestack::motion
