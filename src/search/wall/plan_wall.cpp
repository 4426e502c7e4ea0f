#include "stonestack/search/plan_wall.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "physics/shape.hpp"
#include "search/orientations.hpp"
#include "search/wall/placing.hpp"
#include "search/wall/plan_task.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::search {
namespace {

constexpr std::size_t kSettledInSlot = 12;  // proposals of a slot that are let down in simulation
constexpr std::size_t kTriedInSlot = 4;     // of these, that are judged before the search goes back
constexpr int kPasses = 16;                 // from the table up, at most
constexpr int kPassesOfLength = 3;          // of these, where a length is given
constexpr int kPassesWithArm = 4;   // likewise where the arm is asked: it makes most of the difference
constexpr int kJudgedPerStone = 3;  // judgements of a pass, for each stone that is asked for
constexpr double kUrgency = 0.5;    // worth that a stone gains with each pass that left it over
constexpr double kVariation = 0.3;  // of the worth of stones, one sigma, from the second pass on
constexpr double kBaseStep = 0.02;  // m that a slot moves on where no stone fits

/// x of the middle of a wall whose stones have the usual length, where the first begins at 0.
double usual_middle(const WallTarget& target, const std::vector<WallStone>& stones) {
  if (target.courses.empty()) return 0.5 * target.length;
  double length = 0.0;
  for (const WallStone& stone : stones)
    length += (stone.sides.front().extents.max - stone.sides.front().extents.min).x() /
              static_cast<double>(stones.size());
  const int count = target.courses.front();
  return 0.5 * (count * length + (count - 1) * target.joint_gap);
}

class WallSearch {
 public:
  WallSearch(const SearchContext& context, const WallTarget& target, const std::optional<WallBegun>& begun)
      : context_(context),
        target_(target),
        stones_(wall_stones(context, 2 * raster_half(context, context.options->grid) + 1)),
        start_(begun ? standing_state(context, *begun) : WallState()) {
    asked_ = stones_asked(target);
    budget_ = kJudgedPerStone * (asked_ > 0 ? asked_ : static_cast<int>(context.available.size()));
    if (begun)
      T_W_V_ = begun->T_W_V;
    else if (context.problem->reachable && !stones_.empty())
      T_W_V_ = frame_of(target, context.problem->site, usual_middle(target, stones_));
    if (begun) {
      rest_ = begun->rest;
      rest_only_ = begun->rest_only;
    }
  }

  void run() {
    const bool arm = context_.problem->reachable != nullptr;
    const int passes = asked_ == 0 ? kPassesOfLength : (arm ? kPassesWithArm : kPasses);
    try {
      placing_.may_rock = arm;
      bool done = go_on_as_planned() || rest_only_;
      for (int pass = 0; pass < passes && !done && !context_.out_of_time(); ++pass) {
        variation_ = pass == 0 ? 0.0 : kVariation;
        placing_.may_rock = arm && pass + 1 == passes;
        random_ = Random::stream(static_cast<std::uint64_t>(context_.options->seed), concat("wall ", pass));
        placing_.judged = 0;
        longest_ = {};
        if (asked_ == 0)
          grow(start_);
        else
          done = complete(start_);
        for (const WallStone& stone : stones_)
          if (!longest_.holds(stone.stone)) urgency_[stone.stone] += kUrgency;
      }
      if (context_.out_of_time()) placing_.reason = kTimeOver;
    } catch (const Interrupted&) {
      placing_.reason = why_interrupted();
    }
  }
  /// All that was asked for stands: the stones, or stones in each course.
  [[nodiscard]] bool is_whole() const {
    if (asked_ > 0) return best_.stones.size() >= static_cast<std::size_t>(asked_);
    return !best_.stones.empty() && best_.stones.back().course + 1 >= target_.levels;
  }
  [[nodiscard]] const WallState& best() const { return best_; }
  /// Frame of the wall in W, where it was fixed before the search.
  [[nodiscard]] const std::optional<Pose>& frame() const { return T_W_V_; }
  [[nodiscard]] int asked() const { return asked_; }
  [[nodiscard]] long candidates() const { return candidates_; }
  [[nodiscard]] int unreachable() const { return placing_.unreachable; }
  [[nodiscard]] const std::string& reason() const { return placing_.reason; }

 private:
  /// Puts the stones of an earlier plan where it meant them to go, as far as they hold.
  /// @return true if the wall is whole then
  bool go_on_as_planned() {
    WallState state = start_;
    keep(state);
    for (const WallPlacement& planned : rest_) {
      if (context_.out_of_time()) return false;
      auto next = placing_.as_planned(state, planned, state.stones.size() == start_.stones.size());
      if (!next) return false;
      if (const auto slot = slot_after(state); slot && slot->course == planned.course)
        next->trial.placement.terms.merge(terms_in_slot(
            *slot, next->placed,
            worth_in_slot(*slot, next->placed, next->trial.margin, context_.options->friction)));
      state = placing_.loaded(state, *next, placing_.compared_with(planned));
      keep(state);
    }
    return !rest_.empty() && !slot_after(state);
  }

  /// Stones for a slot.
  struct InSlot {
    std::vector<Settled> list;         ///< come to rest in balance, best first
    std::vector<Alternative> refused;  ///< do not, or cannot be brought there
  };
  InSlot settled(const WallState& state, const WallSlot& slot) {
    WallProposals proposals = wall_proposals(context_, state, slot, stones_);
    candidates_ += proposals.evaluated;
    const Stack below = state.stack();
    const bool fits = !proposals.list.empty();
    const std::vector<WallProposal> kept =
        placing_.reachable(std::move(proposals.list), below, kSettledInSlot);
    if (kept.empty())
      placing_.reason =
          fits ? "the arm brings none of the stones that fit to its place" : "no stone that is left fits";
    std::vector<Settled> list = placing_.settled(below, kept, slot.course);
    for (Settled& one : list)
      one.worth = worth_in_slot(slot, one.placed, one.trial.margin, context_.options->friction);
    for (Settled& one : list) {
      auto& terms = one.trial.placement.terms;
      terms.merge(terms_in_slot(slot, one.placed, one.worth));
      const double urgency = urgency_[one.placed.stone] + random_.normal(0.0, variation_);
      terms["urgency"] = urgency;
      one.worth += urgency;
    }
    std::stable_sort(list.begin(), list.end(),
                     [](const Settled& p, const Settled& q) { return p.worth > q.worth; });
    return {std::move(list), placing_.refused};
  }

  /// Worth of a wall: its stones where their number is given, else the length of its courses.
  [[nodiscard]] double worth_of(const WallState& state) const {
    if (asked_ > 0) return static_cast<double>(state.stones.size());
    double sum = 0.0;
    for (const WallStonePlaced& placed : state.stones) sum += (placed.reach.max - placed.reach.min).x();
    return sum;
  }

  void keep(const WallState& state) {
    if (state.stones.size() > longest_.stones.size()) longest_ = state;
    if (worth_of(state) <= worth_of(best_)) return;
    best_ = state;
    context_.log(concat(best_.stones.size(), " stones stand, course ", best_.stones.back().course + 1));
  }

  [[nodiscard]] bool out_of_tries() const { return context_.out_of_time() || placing_.judged >= budget_; }

  [[nodiscard]] std::optional<WallSlot> slot_after(const WallState& state) const {
    return next_slot(target_, state, [&] { return common_thickness(stones_, state); });
  }

  /// Depth-first, until the wall is complete.
  bool complete(const WallState& state) {
    keep(state);
    const std::optional<WallSlot> slot = slot_after(state);
    if (!slot) return true;
    auto [list, refused] = settled(state, *slot);
    std::size_t tried = 0;
    for (std::size_t k = 0; k < list.size(); ++k) {
      if (out_of_tries() || tried == kTriedInSlot) return false;
      if (!placing_.holds(state, list[k])) continue;
      ++tried;
      if (complete(placing_.loaded(state, list[k], compared_in(list, k, refused)))) return true;
      list[k].trial.outcome = "the wall was not finished on it";
    }
    return false;
  }

  /// Stone after stone, as far as the length goes; a place where nothing fits is left open.
  void grow(WallState state) {
    std::optional<WallSlot> slot = slot_after(state);
    while (slot && !out_of_tries()) {
      auto [list, refused] = settled(state, *slot);
      const auto next =
          std::find_if(list.begin(), list.end(), [&](Settled& one) { return placing_.holds(state, one); });
      if (next != list.end()) {
        state = placing_.loaded(state, *next,
                                compared_in(list, static_cast<std::size_t>(next - list.begin()), refused));
        keep(state);
        slot = slot_after(state);
        continue;
      }
      slot->from += kBaseStep;
      const std::vector<int> base = state.course(0);
      if (base.empty()) return;
      if (slot->from <= end_of(state, base)) continue;
      if (state.course(slot->course).empty()) return;
      state.closed = slot->course + 1;
      slot = slot_after(state);
    }
  }
  /// x where the lowest course ends.
  [[nodiscard]] static double end_of(const WallState& state, const std::vector<int>& base) {
    return state.stones[static_cast<std::size_t>(base.back())].reach.max.x();
  }

  const SearchContext& context_;
  const WallTarget& target_;
  std::vector<WallStone> stones_;
  WallState start_;            // what stands before the search
  std::optional<Pose> T_W_V_;  // see frame()
  Placing placing_{context_, T_W_V_};
  std::vector<WallPlacement> rest_;  // of an earlier plan, in W
  bool rest_only_ = false;
  WallState best_, longest_;              // of all passes, of this pass
  std::map<StoneIndex, double> urgency_;  // a stone that is hard to place is placed early
  int asked_ = 0, budget_ = 0;
  double variation_ = 0.0;
  Random random_ = Random::stream(0, "wall");
  long candidates_ = 0;
};

void check_task(const SpanTask& task) {
  require(!task.spans.empty(), "a task needs at least one span");
  for (const Span& span : task.spans)
    require(std::isfinite(span.from) && std::isfinite(span.to) && span.from < span.to && span.clear >= 0.0 &&
                std::isfinite(span.clear),
            "a span goes from ", span.from, " to ", span.to, " m, ", span.clear, " m above the table");
  for (const TargetSupport& support : task.supports) {
    require(std::isfinite(support.from) && std::isfinite(support.to) && support.from < support.to &&
                support.height > 0.0 && support.depth > 0.0 && std::isfinite(support.height) &&
                std::isfinite(support.depth),
            "a support goes from ", support.from, " to ", support.to, " m, ", support.height, " m high and ",
            support.depth, " m deep");
    for (const Span& span : task.spans)
      require(support.to <= span.from || support.from >= span.to, "the support from ", support.from, " to ",
              support.to, " m stands in the span from ", span.from, " to ", span.to, " m");
  }
  require(!task.carry || std::isfinite(*task.carry), "the place of the stone that is carried must be finite");
}

void check_target(const WallTarget& target, std::size_t stones) {
  require((!target.centre_W || target.centre_W->allFinite()) && std::isfinite(target.yaw),
          "the wall's place must be finite");
  if (target.task) return check_task(*target.task);
  if (target.courses.empty()) {
    require(target.length > 0.0 && std::isfinite(target.length) && target.levels > 0,
            "a wall needs stones a course (4+3+2+1), or a length and a number of courses");
    return;
  }
  for (std::size_t k = 0; k < target.courses.size(); ++k) {
    const int count = target.courses[k];
    require(count > 0, "a course needs at least one stone, got ", count);
    if (k == 0) continue;
    require(count <= target.courses[k - 1], "course ", k + 1, " has more stones (", count,
            ") than the one below (", target.courses[k - 1], ")");
  }
  const int asked = stones_asked(target);
  require(static_cast<std::size_t>(asked) <= stones, "the wall asks for ", asked, " stones, and ", stones,
          " are there");
}

void check_begun(const SearchProblem& problem, const std::optional<WallBegun>& begun) {
  const std::size_t stones = problem.stack.stones.size();
  require(begun || stones == 0, "a wall is planned on the empty table, and ", stones, " stones stand");
  if (!begun) return;
  require(begun->courses.size() == stones, stones, " stones of the wall stand, and the course of ",
          begun->courses.size(), " is given");
  require(is_valid(begun->T_W_V), "the wall's frame is no pose");
  for (const int course : begun->courses) require(course >= 0, "a stone is in course ", course);
  for (const WallPlacement& planned : begun->rest)
    require(planned.course >= 0 && is_valid(planned.placement.T_W_O) &&
                static_cast<std::size_t>(planned.placement.stone.value()) < problem.shapes->size(),
            "the rest of the plan names no stone or no pose");
}

}  // namespace

WallPlan plan_wall(const SearchProblem& problem, const WallTarget& target, const SearchOptions& options,
                   const std::function<void(const std::string&)>& report,
                   const std::optional<WallBegun>& begun) {
  check_problem(problem, options);
  require(options.objective == "height", "search objective ", options.objective,
          " is for towers; a wall is planned for height");
  check_begun(problem, begun);
  check_target(target, problem.available.size() + problem.stack.stones.size());
  if (target.task) return plan_task(problem, target, options, report, begun);
  SearchContext context = wall_context(problem, options, report);
  WallSearch search(context, target, begun);
  search.run();
  const WallState& best = search.best();
  WallPlan plan;
  plan.unreachable = search.unreachable();
  plan.candidates = search.candidates();
  plan.metrics = wall_metrics(context, best);
  plan.metrics.asked = search.asked();
  double left = 0.0, right = 0.0;
  for (const int k : best.course(0)) {
    left = std::min(left, best.stones[static_cast<std::size_t>(k)].reach.min.x());
    right = std::max(right, best.stones[static_cast<std::size_t>(k)].reach.max.x());
  }
  plan.T_W_V = search.frame().value_or(frame_of(target, problem.site, 0.5 * (left + right)));
  const std::vector<std::vector<int>> supports = rests_upon(context, best);
  for (std::size_t k = problem.stack.stones.size(); k < best.stones.size(); ++k) {
    plan.placements.push_back(in_world(
        plan.T_W_V, {best.trials[k].placement, best.stones[k].course, supports[k]}, best.compared[k]));
  }
  if (!search.is_whole()) plan.reason = search.reason();
  plan.seconds = context.watch.seconds();
  return plan;
}

WallMetrics measure_wall(const SearchProblem& problem, const WallTarget& target, const WallBegun& begun,
                         const SearchOptions& options) {
  check_problem(problem, options);
  check_begun(problem, begun);
  if (target.task) {
    check_task(*target.task);
    return measure_task(problem, *target.task, begun, options);
  }
  const SearchContext context = wall_context(problem, options, {});
  return wall_metrics(context, standing_state(context, begun));
}

}  // namespace stonestack::search
