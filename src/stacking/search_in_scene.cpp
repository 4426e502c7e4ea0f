#include <algorithm>
#include <cmath>

#include "physics/shape.hpp"
#include "search/search_context.hpp"
#include "search/wall/span_search.hpp"
#include "stacking/choose_in_wall.hpp"
#include "stacking/reach.hpp"
#include "stacking/search_scene.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/motion/planning_scene.hpp"

namespace stonestack::stacking {
namespace {

/// A stack that was measured a little off is built on as it comes to rest, so that placements touch what is
/// reported below them. One that does not stand is left to the search to refuse.
void let_come_to_rest(const SearchOptions& options, SearchProblem& problem) {
  check_problem(problem, options);
  const std::optional<Stack> stack = settled_stack(*problem.shapes, problem.stack, options).stack;
  if (!stack) return;
  double moved = 0.0;
  for (std::size_t i = 0; i < stack->stones.size(); ++i)
    moved = std::max(moved, difference(problem.stack.stones[i].T_W_O, stack->stones[i].T_W_O).translation);
  if (moved > 0.0)
    log_info(concat("the given stack comes to rest up to ", 0.01 * std::round(1e5 * moved),
                    " mm from where it is said to be; searching on that"));
  problem.stack = *stack;
}

/// Stones that gripper and arm cannot carry are left where they lie; fails where that leaves none.
void leave_what_is_too_heavy(const PlanningScene& scene, const Catalogue& catalogue, SearchProblem& problem) {
  std::string heavy;
  std::erase_if(problem.available, [&](const auto& item) {
    const Stone& stone = catalogue[item.stone];
    const std::string who = overload(stone.mass.mass, scene.gripper, scene.robot);
    if (!who.empty())
      heavy += concat(heavy.empty() ? "" : ", ", stone.name, " (", stone.mass.mass, " kg, ", who, ")");
    return !who.empty();
  });
  if (problem.available.empty() && !heavy.empty())
    throw Error("no stone of the scene can be carried: " + heavy, ExitCode::kExecutionFailed);
  if (!heavy.empty()) log_info("left where they lie, too heavy: " + heavy);
}

/// Adds the supports of a task, where they stand, to the catalogue.
void add_supports(const SpanTask& task, const Pose& T_W_V, SceneSearch& found) {
  const TaskSupports supports = make_supports(task);
  for (std::size_t k = 0; k < supports.shapes.size(); ++k) {
    const ContactShape& shape = *supports.shapes[k];
    Stone block;
    block.name = shape.name;
    block.mesh = block.scan = shape.scan;
    block.pieces = {shape.scan};
    block.mass = shape.mass;
    found.supports.push_back(
        {StoneIndex(static_cast<int>(found.catalogue.stones.size())), T_W_V * supports.T_V_O[k]});
    found.catalogue.stones.push_back(std::move(block));
  }
}

/// Asks for poses to which the arm can bring the stones from where they lie, in one go.
void ask_the_arm(const SceneSearchTask& task, const Catalogue& catalogue, SearchProblem& problem) {
  if (task.robot.empty()) return;
  require(!task.scene.empty(), "--robot asks how stones are reached where they lie; give a SCENE");
  const RobotModel robot = read_robot(task.robot);
  const Arrangement arrangement{problem.stack.stones, problem.available};
  CellLayout layout = with_gripper({}, task.gripper);
  if (is_scene_file(task.scene)) {
    const SceneFile file = read_scene_file(task.scene);
    layout.obstacles = file.obstacles;
    layout.paddings = file.paddings;
  }
  const PlanningScene scene = make_planning_scene(layout, robot, catalogue, arrangement);
  leave_what_is_too_heavy(scene, catalogue, problem);
  const auto reach = std::make_shared<Reach>(arrangement, scene, catalogue, task.motion);
  problem.reachable = [reach](StoneIndex stone, const Pose& T_W_O, const Stack& below) {
    return reach->in_one_go(stone, T_W_O, below);
  };
}

void find(const SceneSearchTask& task, const SearchProblem& problem,
          const std::function<void(const std::string&)>& report, SceneSearch& found) {
  if (!task.wall.empty()) {
    const WallTarget target = read_wall_target(task.wall);
    found.wall = plan_wall(problem, problem.reachable ? wall_for_arm(target) : target, task.search, report);
    for (const WallPlacement& next : found.wall->placements) found.placements.push_back(next.placement);
    found.reason = found.wall->reason;
    if (target.task) add_supports(*target.task, found.wall->T_W_V, found);
    return;
  }
  if (task.levels > 1) {
    TowerPlan tower = plan_tower(problem, task.levels, task.search, report);
    found.placements = std::move(tower.placements);
    found.reason = std::move(tower.reason);
    return;
  }
  SearchResult result = find_next_pose(problem, task.search, report);
  found.reason = result.reason;
  if (task.search.trace) found.trace = std::move(result.trace);
  if (result.best.empty()) return;
  found.placements.push_back(result.best.front());
  found.alternatives.assign(result.best.begin() + 1, result.best.end());
}

}  // namespace

SceneSearch search_in_scene(const SceneSearchTask& task,
                            const std::function<void(const std::string&)>& report) {
  SceneSearch found;
  try {
    found.catalogue = read_catalogue(task.catalogue);
    found.start = read_start(task, found.catalogue);
    SearchProblem& problem = found.start.problem;
    let_come_to_rest(task.search, problem);
    ask_the_arm(task, found.catalogue, problem);
    find(task, problem, report, found);
  } catch (const Interrupted&) {
    if (!time_is_over()) throw;
    found.reason = kTimeOver;
  }
  found.start.problem.reachable = {};  // refers to what ends here
  found.repeatable = task.search.budget == 0.0 && !interrupt_noted();
  return found;
}

}  // namespace stonestack::stacking
