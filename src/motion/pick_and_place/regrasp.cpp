#include "motion/regrasp.hpp"

#include <algorithm>
#include <memory>
#include <numeric>

#include "motion/grasp/grasp_end.hpp"
#include "motion/pick_and_place/rest_graph.hpp"
#include "motion/pick_and_place/set_down.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::motion {
namespace {

constexpr std::size_t kSure = 6;     ///< grasps that lead on from a place are sought first
constexpr std::size_t kEnough = 24;  ///< grasps that serve one link: more do not make it surer
constexpr std::size_t kMaxTests =
    40'000;  ///< of grasps at places, over all chains, either time: about a second

PlanningScene with_stone_at(PlanningScene scene, const PickAndPlaceTask& task, const Pose& T_W_O) {
  if (task.object >= 0) scene.objects[static_cast<std::size_t>(task.object)].T_W_object = T_W_O;
  return scene;
}

/// Searches places where the stone can be set down so that grasps lead on, then plans.
class RegraspSearch {
 public:
  RegraspSearch(const PlanningScene& scene, const PickAndPlaceTask& task, const MotionOptions& options,
                const RegraspOptions& regrasp)
      : scene_(scene),
        task_(task),
        options_(options),
        regrasp_(regrasp),
        pick_(scene, *task.stone, task.object, task.T_W_O_pick, options),
        places_(scene, task, regrasp) {}

  RegraspPlan plan();

 private:
  [[nodiscard]] bool over() const {
    return attempts_ >= regrasp_.attempts || tests_ >= max_tests_ || plan_.planned;
  }
  void place_next(const std::vector<int>& chain, const std::vector<int>& arriving);
  void make_plans();
  [[nodiscard]] std::string why(std::size_t from, std::size_t to, std::size_t chains) const;

  const PlanningScene& scene_;
  const PickAndPlaceTask& task_;
  const MotionOptions& options_;
  const RegraspOptions& regrasp_;
  PickSide pick_;
  SetDownPlaces places_;
  RestGraph graph_;
  std::vector<int> to_;          ///< grasps that serve at the target
  std::vector<Pose> between_;    ///< the places of a chain so far
  std::vector<double> tilts_;    ///< of the resting poses at these places
  std::size_t min_leaving_ = 1;  ///< grasps that lead on from a place
  std::size_t max_tests_ = 0;
  std::size_t tests_ = 0;  ///< of grasps
  int attempts_ = 0;
  RegraspPlan plan_;
};

RegraspPlan RegraspSearch::plan() {
  std::vector<int> all(pick_.set->grasps.size());
  std::iota(all.begin(), all.end(), 0);
  std::vector<int> allowed = all;
  std::erase_if(allowed, [&](int i) {
    const Pose& T_O_T = pick_.set->grasps[static_cast<std::size_t>(i)].T_O_T;
    return is_near_grasp(task_.avoid, T_O_T) || is_near_grasp(task_.no_pick, T_O_T);
  });
  const auto from = pick_.end.serving(pick_.set->grasps, allowed, task_.T_W_O_pick);
  to_ = pick_.end.serving(pick_.set->grasps, all, task_.T_W_O_place);
  graph_ = make_rest_graph(scene_, *task_.stone, pick_.set->grasps, options_, regrasp_);
  const auto chains = rest_chains(graph_, from, to_, regrasp_.max_set_downs);
  // What is set down lies a little otherwise than planned, so that one grasp alone may not lead on.
  for (const std::size_t min : {kSure, std::size_t{1}}) {
    min_leaving_ = min;
    max_tests_ += kMaxTests;
    for (const auto& chain : chains) {
      if (over()) break;
      place_next(chain, from);
    }
  }
  if (!plan_.planned) plan_.reason = why(from.size(), to_.size(), chains.size());
  return std::move(plan_);
}

/// Finds where the next resting pose of the chain can stand. `arriving`: grasps that serve where the stone is
/// before.
void RegraspSearch::place_next(const std::vector<int>& chain, const std::vector<int>& arriving) {
  const std::size_t k = between_.size();
  if (k == chain.size()) return make_plans();
  const auto& here = graph_.grasps[static_cast<std::size_t>(chain[k])];
  const auto& next = k + 1 < chain.size() ? graph_.grasps[static_cast<std::size_t>(chain[k + 1])] : to_;
  const auto in = common(arriving, here), out = common(here, next);
  const RestPose& rest = graph_.rests[static_cast<std::size_t>(chain[k])];
  for (const Pose& T_W_O : places_.poses(rest.R_W_O)) {
    throw_if_interrupted();
    if (over()) return;
    tests_ += in.size();
    if (pick_.end.serving(pick_.set->grasps, in, T_W_O, 1).empty()) continue;
    tests_ += out.size();
    const auto leaving = pick_.end.serving(pick_.set->grasps, out, T_W_O, kEnough);
    if (leaving.size() < min_leaving_) continue;
    between_.push_back(T_W_O);
    tilts_.push_back(rest.tilt);
    place_next(chain, leaving);
    between_.pop_back();
    tilts_.pop_back();
  }
}

/// Makes all plans over the places found; `reason` names the one that failed.
void RegraspSearch::make_plans() {
  ++attempts_;
  RegraspPlan plan;
  plan.T_W_O_between = between_;
  plan.tilts = tilts_;
  PickAndPlaceTask leg = task_;
  for (std::size_t k = 0; k <= between_.size(); ++k) {
    const bool last = k == between_.size();
    leg.T_W_O_place = last ? task_.T_W_O_place : between_[k];
    leg.support = last ? task_.support : kTableObject;
    plan.plans.push_back(plan_pick_and_place(with_stone_at(scene_, task_, leg.T_W_O_pick), leg, options_));
    if (plan.plans.back().status != PickAndPlacePlan::Status::kPlanned) {
      plan_.reason = concat(last ? "then: " : "setting it down: ", plan.plans.back().reason);
      return;
    }
    leg.T_W_O_pick = leg.T_W_O_place;
    leg.no_pick.clear();
    leg.q_start = plan.plans.back().steps.back().trajectory.q.back();
  }
  plan.planned = true;
  plan_ = std::move(plan);
}

std::string RegraspSearch::why(std::size_t from, std::size_t to, std::size_t chains) const {
  return concat(task_.stone->name, ": ", from, " grasps serve where it lies, ", to,
                " at the target; over its ", graph_.rests.size(), " resting poses ", chains,
                " chains join them; ", attempts_,
                " of them could be stood on the table with grasps for every part",
                plan_.reason.empty() ? "" : "; ", plan_.reason);
}

}  // namespace

FieldList fields(RegraspOptions& o) {
  return {field("rest_margin", o.rest_margin, {0, 0.1}, "m",
                "design choice: a stone set down a little askew stays"),
          field("rest_tilt", o.rest_tilt, {0, 1.5}, "rad", "measured: bench rest"),
          field("min_margin", o.min_margin, {0, 0.1}, "m",
                "design choice: a stone that falls over lies in another pose, and is looked at again"),
          field("min_tilt", o.min_tilt, {0, 1.5}, "rad", "measured: bench rest"),
          field("flat", o.flat, {0, 0.02}, "m", "design choice"),
          field("turns", o.turns, {1, 64}, "", "design choice"),
          field("around", o.around, {0, 2}, "m", "design choice"),
          field("spacing", o.spacing, {0.005, 1}, "m", "design choice"),
          field("apart", o.apart, {0, 0.2}, "m", "design choice"),
          field("max_set_downs", o.max_set_downs, {1, 4}, "", "measured: bench grasp"),
          field("attempts", o.attempts, {1, 1000}, "", "design choice")};
}

RegraspPlan plan_regrasp(const PlanningScene& scene, const PickAndPlaceTask& task,
                         const MotionOptions& options, const RegraspOptions& regrasp) {
  require(task.stone != nullptr, "a task needs a stone");
  require(is_valid(task.T_W_O_pick) && is_valid(task.T_W_O_place), "the poses of ", task.stone->name,
          " are not poses: ", geometry::to_text(task.T_W_O_pick), " and ",
          geometry::to_text(task.T_W_O_place));
  RegraspPlan firm = RegraspSearch(scene, task, options, regrasp).plan();
  if (firm.planned || (regrasp.min_margin >= regrasp.rest_margin && regrasp.min_tilt >= regrasp.rest_tilt))
    return firm;
  return RegraspSearch(scene, task, options, with_shaky_rests(regrasp)).plan();
}

}  // namespace stonestack::motion
