#include <algorithm>
#include <cmath>

#include "stacking/builder.hpp"
#include "stacking/field_places.hpp"
#include "stacking/take_off_depth.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/motion/regrasp.hpp"
#include "stonestack/stacking/execute.hpp"

namespace stonestack::stacking {
namespace {

constexpr int kMostCleared = 4;   // tries to take stones away from the foot of the tower
constexpr double kStillUp = 0.9;  // cosine (26 deg) between the ups of a stone as laid down and as seen

/// Up and away from what a stone leans on, by as much.
Eigen::Vector3d out_of_the_lean(const Eigen::Vector3d& p_W_leaning, const Eigen::Vector3d& p_W_other) {
  Eigen::Vector3d away = p_W_leaning - p_W_other;
  away.z() = 0.0;
  if (away.norm() < 1e-6) return Eigen::Vector3d::UnitZ();
  return (away.normalized() + Eigen::Vector3d::UnitZ()).normalized();
}

}  // namespace

std::optional<Belief> Builder::without_top(std::size_t count) const {
  Belief belief = belief_;
  for (std::size_t k = 0; k < count; ++k) {
    const PlacedStone top = belief.stack.back();
    const auto places = free_places(shapes_, cell_.layout, belief, top);
    if (places.empty()) return std::nullopt;
    belief.stack.pop_back();
    belief.loose.push_back({top.stone, places.front()});
  }
  return belief;
}

bool Builder::take_off() {
  throw_if_interrupted();
  if (!belief_.stack.empty()) given_up_.push_back(belief_.stack.back());
  const std::size_t allowed = static_cast<std::size_t>(std::max(0, options_.most_taken_off - taken_off_));
  const Stopwatch watch;
  const double all = static_cast<double>(belief_.stack.size() + belief_.loose.size());
  std::vector<double> expected;
  while (expected.size() < std::min(allowed, belief_.stack.size())) {
    auto at_best = expected;
    at_best.push_back(all);
    if (take_off_depth(at_best) <= expected.size()) break;  // one deeper cannot pay
    const auto lower = without_top(expected.size() + 1);
    expected.push_back(lower ? expected_another_way(*lower) : 0.0);
  }
  const std::size_t count = take_off_depth(expected);
  result_.seconds.search += watch.seconds();
  if (count == 0) return false;
  report(concat("nothing fits on ", name(belief_.stack.back().stone), ": another way promises ",
                std::round(10 * expected[count - 1]) / 10, " stones in all, so ", count,
                count == 1 ? " stone is taken off" : " stones are taken off"));
  bool any = false;
  for (std::size_t k = 0; k < count && !belief_.stack.empty(); ++k) {
    if (!set_down_top()) return any;
    any = true;
    ++taken_off_;
  }
  return any;
}

bool Builder::set_down_top(const std::optional<Eigen::Vector3d>& n_W_lift) {
  const PlacedStone top = belief_.stack.back();
  const auto places = free_places(shapes_, cell_.layout, belief_, top);
  std::string refusal = "the field has no room";
  const auto lifted = [&](const std::optional<Eigen::Vector3d>& n_W) {
    return std::any_of(places.begin(), places.end(),
                       [&](const Pose& T_W_O_down) { return set_down(top, T_W_O_down, n_W, &refusal); });
  };
  const bool done = lifted(std::nullopt) || (n_W_lift && lifted(n_W_lift));
  if (!done) report("no motion takes " + name(top.stone) + " off: " + refusal);
  return done;
}

bool Builder::clear_the_foot() {
  const auto stray = stray_at_stack(shapes_, belief_);
  if (!stray || cleared_ >= kMostCleared) return false;
  ++cleared_;
  throw_if_interrupted();
  report(concat(name(stray->stone.stone), " leans on the tower: it is taken back into the field"));
  Belief others = belief_;
  std::erase_if(others.loose, [&](const PlacedStone& s) { return s.stone == stray->stone.stone; });
  const PlanningScene scene = make_planning_scene(cell_.layout, robot_, catalogue_, belief_);
  std::string refusals;
  const auto places = free_places(shapes_, cell_.layout, others, stray->stone);
  // As it lies straight up, or first away from what it leans on.
  for (std::size_t k = 0; k < 2 * places.size(); ++k) {
    const Pose& T_W_O_down = places[k % places.size()];
    auto task = make_task(catalogue_, belief_, stray->stone.stone, T_W_O_down, cell_.arm.state().q);
    task.support = -1;
    name_useless_grasps(&task, stray->stone.stone);
    if (k >= places.size()) {
      task.n_W_lift = out_of_the_lean(com_of(stray->stone), com_of(belief_.stack[stray->level]));
      task.no_pick.clear();  // known of the way straight up only
    }
    const Stopwatch watch;
    const PickAndPlacePlan plan = plan_pick_and_place(scene, task, options_.motion);
    result_.seconds.planning += watch.seconds();
    refusals = plan.reason;
    if (plan.status != PickAndPlacePlan::Status::kPlanned) continue;
    lay_down(plan, scene, stray->stone.stone, T_W_O_down, PlacementRecord::Outcome::kTakenOff);
    return true;
  }
  report("it stays: " + (refusals.empty() ? "the field has no room" : refusals));
  return take_off_down_to(*stray);
}

bool Builder::take_off_down_to(const Stray& stray) {
  const std::size_t count = belief_.stack.size() - stray.level;
  if (taken_off_ + static_cast<int>(count) > options_.most_taken_off) return false;
  if (count == 1 && height_is_reached(belief_)) return false;  // all of it counts
  bool any = false;
  while (belief_.stack.size() > stray.level) {
    const PlacedStone top = belief_.stack.back();
    report(concat(name(top.stone), " is taken off so that ", name(stray.stone.stone), " comes free"));
    std::optional<Eigen::Vector3d> n_W_lift;
    if (belief_.stack.size() == stray.level + 1) n_W_lift = out_of_the_lean(com_of(top), com_of(stray.stone));
    if (!set_down_top(n_W_lift)) break;
    any = true;
    if (++taken_off_ >= options_.most_taken_off) break;  // a hand that misses takes its share, too
  }
  return any;
}

double Builder::expected_another_way(const Belief& lower) const {
  const Ways ways = may_turn_over() ? Ways::kTurningToo : Ways::kInOneGo;
  SearchProblem problem = make_problem(lower, ways);
  if (problem.available.empty()) return 0.0;
  const auto levels = static_cast<int>(problem.available.size());
  const std::size_t count = friction_.frictions().size();
  double most = 0.0;
  bool higher = false;
  for (std::size_t level = first_level(); level < count && most < options_.sure_success * levels; ++level) {
    std::string reason;
    const auto tower = plan_tower(problem, levels, search_at(level, ways), &reason);
    problem.way_up.clear();
    for (const Placement& placement : tower) problem.way_up.push_back({placement.stone, placement.T_W_O});
    if (lower.stack.size() + tower.size() <= belief_.stack.size()) continue;
    higher = true;
    most = std::max(most, weighed(expected_by_friction(problem, problem.way_up, possible())));
    if (tower.size() == problem.available.size()) problem.way_up.clear();  // whole, but doubtful
  }
  return higher ? static_cast<double>(lower.stack.size()) + most : 0.0;
}

/// False when no motion was found; a motion that went wrong is seen by the next look.
bool Builder::set_down(const PlacedStone& top, const Pose& T_W_O_down,
                       const std::optional<Eigen::Vector3d>& n_W_lift, std::string* refusal) {
  const PlanningScene scene = make_planning_scene(cell_.layout, robot_, catalogue_, belief_);
  const Stone& stone = catalogue_.stones[static_cast<std::size_t>(top.stone)];
  PickAndPlaceTask task;
  task.stone = &stone;
  task.object = static_cast<int>(belief_.stack.size()) - 1;
  task.T_W_O_pick = top.T_W_O;
  task.T_W_O_place = T_W_O_down;
  task.q_start = cell_.arm.state().q;
  name_useless_grasps(&task, top.stone);
  if (n_W_lift) {
    task.n_W_lift = *n_W_lift;
    task.no_pick.clear();  // known of the way straight up only
  }
  const Stopwatch watch;
  const PickAndPlacePlan plan = plan_pick_and_place(scene, task, options_.motion);
  result_.seconds.planning += watch.seconds();
  *refusal = plan.reason;
  if (plan.status != PickAndPlacePlan::Status::kPlanned) return false;
  lay_down(plan, scene, top.stone, T_W_O_down, PlacementRecord::Outcome::kTakenOff);
  return true;
}

void Builder::lay_down(const PickAndPlacePlan& plan, const PlanningScene& scene, int stone,
                       const Pose& T_W_O_down, PlacementRecord::Outcome outcome) {
  Placement down;
  down.stone = stone;
  down.T_W_O = T_W_O_down;
  record(outcome == PlacementRecord::Outcome::kTakenOff ? "take_off" : "turn_over",
         placement_json(catalogue_, down));
  const double start = cell_.clock.now();
  const ExecutionResult done = execute(plan, catalogue_.stones[static_cast<std::size_t>(stone)], scene, cell_,
                                       options_.motion, hooks_.journal);
  result_.seconds.motion += cell_.clock.now() - start;
  if (done.status == ExecutionResult::Status::kStopped)
    throw DeviceError("arm", concat("stopped while laying down ", name(stone), ": ", done.reason),
                      "look at the cell; the stone may be in the hand");
  const bool picked = done.status == ExecutionResult::Status::kReleased;
  if (!picked) failed_grasps_[stone].push_back(plan.T_O_T);
  const bool dropped = done.status == ExecutionResult::Status::kLost;
  // What the hand missed is still expected where it was, on the stack maybe.
  if (picked || dropped) {
    const auto same = [&](const PlacedStone& s) { return s.stone == stone; };
    std::erase_if(belief_.stack, same);
    std::erase_if(belief_.loose, same);  // or the hand, which is there now, would seem to be in it
  }
  if (picked) belief_.loose.push_back({stone, T_W_O_down});
  if (outcome == PlacementRecord::Outcome::kTakenOff) last_ = {};  // its plan led nowhere
  look_around(false);
  using Outcome = PlacementRecord::Outcome;
  PlacementRecord entry{name(stone), down, std::nullopt,
                        picked    ? outcome
                        : dropped ? Outcome::kDropped
                                  : Outcome::kNotPicked,
                        done.reason};
  for (const auto& loose : belief_.loose)
    if (loose.stone == stone) entry.T_W_O_measured = loose.T_W_O;
  result_.placements.push_back(entry);
  aimed_off_.push_back(Eigen::Vector3d::Zero());
  update_height();
}

void Builder::note_toppled(const PlacedStone& meant) {
  const auto up = [](const Pose& T_W_O) -> Eigen::Vector3d { return T_W_O.linear().row(2).transpose(); };
  const PlacementRecord& entry = result_.placements.back();
  if (entry.outcome != PlacementRecord::Outcome::kTurnedOver || !entry.T_W_O_measured) return;
  const Eigen::Vector3d n_O_up = up(meant.T_W_O);
  if (n_O_up.dot(up(*entry.T_W_O_measured)) > kStillUp) return;
  report(concat(name(meant.stone), " did not stay as it was laid down"));
  toppled_[meant.stone].push_back(n_O_up);
}

bool Builder::turn_over(const std::vector<Placement>& found) {
  std::string refusals;
  for (const auto& placement : found) {
    throw_if_interrupted();
    const PlanningScene scene = make_planning_scene(cell_.layout, robot_, catalogue_, belief_);
    auto task = make_task(catalogue_, belief_, placement.stone, placement.T_W_O, cell_.arm.state().q);
    name_useless_grasps(&task, placement.stone);
    const Stopwatch watch;
    RegraspPlan plan = plan_regrasp(scene, task, reach_in(belief_)->options_for(placement.stone),
                                    regrasp_options(placement.stone));
    result_.seconds.planning += watch.seconds();
    if (!plan.planned) {
      refusals += concat(refusals.empty() ? "" : "; ", plan.reason);
      continue;
    }
    report(concat("no grasp brings ", name(placement.stone), " there in one go: laying it down another way"));
    if (reach_in(belief_)->is_low(placement.stone)) feel_to_grasp(plan.plans.front(), placement.stone);
    ++turned_over_;
    last_ = placement;  // to be gone on with when it lies there
    last_below_ = belief_.stack.size();
    const Pose& T_W_O_down = plan.T_W_O_between.front();
    lay_down(plan.plans.front(), scene, placement.stone, T_W_O_down, PlacementRecord::Outcome::kTurnedOver);
    note_toppled({placement.stone, T_W_O_down});
    return true;
  }
  if (!found.empty()) report("no stone can be turned over for it: " + refusals);
  return false;
}

}  // namespace stonestack::stacking
