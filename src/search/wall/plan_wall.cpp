#include "stonestack/search/plan_wall.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "physics/shape.hpp"
#include "search/orientations.hpp"
#include "search/parallel.hpp"
#include "search/wall/wall_state.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::search {
namespace {

constexpr std::size_t kSettledInSlot = 12;  // proposals of a slot that are let down in simulation
constexpr std::size_t kTriedInSlot = 4;     // of these, that are judged before the search goes back
constexpr int kPasses = 16;                 // from the table up, at most
constexpr int kPassesOfLength = 3;          // of these, where a length is given
constexpr int kPassesWithArm = 4;     // likewise where the arm is asked: it makes most of the difference
constexpr int kJudgedPerStone = 3;    // judgements of a pass, for each stone that is asked for
constexpr double kUrgency = 0.5;      // worth that a stone gains with each pass that left it over
constexpr double kVariation = 0.3;    // of the worth of stones, one sigma, from the second pass on
constexpr double kCloseGap = 0.001;   // m between stones that counts as resting on each other
constexpr double kAsPlanned = 0.015;  // m that a stone may come to rest beside where it was planned
constexpr double kBaseStep = 0.02;    // m that a slot moves on where no stone fits

/// A stone that came to rest in a slot.
struct Settled {
  Trial trial;
  WallStonePlaced placed;
  double worth = 0.0;
};

/// The wall's frame in W.
Pose frame_of(const WallTarget& target, const Eigen::Vector2d& site, double middle) {
  Pose T_W_V = Pose::Identity();
  T_W_V.linear() = yaw_rotation(target.yaw);
  T_W_V.translation() << target.centre_W.value_or(site), 0.0;
  return T_W_V * Eigen::Translation3d(-middle, 0.0, 0.0);
}

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

/// A stone at a pose in the wall's frame, as one of a course.
WallStonePlaced standing(const SearchContext& context, const PlacedStone& stone, int course) {
  const StoneGeometry& geometry = at(context.geometry, stone.stone);
  const BodyPose body = body_pose(geometry, stone.T_W_O);
  return placed_in_wall({stone.stone, &geometry, {}}, standing_side(context, geometry, body.R_W_O),
                        body.R_W_O, body.p_W_M, course);
}

/// The state of a wall that stands in part.
WallState state_of(const SearchContext& context, const std::optional<WallBegun>& begun) {
  WallState state;
  if (!begun) return state;
  const Pose T_V_W = begun->T_W_V.inverse();
  for (std::size_t k = 0; k < context.stack.stones.size(); ++k) {
    const PlacedStone& stone = context.stack.stones[k];
    state.stones.push_back(standing(context, {stone.stone, T_V_W * stone.T_W_O}, begun->courses[k]));
    state.trials.emplace_back();
  }
  return state;
}

class WallSearch {
 public:
  WallSearch(const SearchContext& context, const WallTarget& target, const std::optional<WallBegun>& begun)
      : context_(context),
        target_(target),
        stones_(wall_stones(context, 2 * raster_half(context, context.options->grid) + 1)),
        start_(state_of(context, begun)) {
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
    const int passes = context_.problem->reachable ? kPassesWithArm : kPasses;
    try {
      bool done = go_on_as_planned() || rest_only_;
      for (int pass = 0; pass < passes && !done && !context_.out_of_time(); ++pass) {
        variation_ = pass == 0 ? 0.0 : kVariation;
        random_ = Random::stream(static_cast<std::uint64_t>(context_.options->seed), concat("wall ", pass));
        judged_ = 0;
        longest_ = {};
        if (asked_ == 0)
          grow(start_);
        else
          done = complete(start_);
        done = done || (asked_ == 0 && pass + 1 == kPassesOfLength);
        for (const WallStone& stone : stones_)
          if (!longest_.holds(stone.stone)) urgency_[stone.stone] += kUrgency;
      }
      if (context_.out_of_time()) reason_ = kTimeOver;
    } catch (const Interrupted&) {
      reason_ = why_interrupted();
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
  [[nodiscard]] int unreachable() const { return unreachable_; }
  [[nodiscard]] const std::string& reason() const { return reason_; }

 private:
  /// Puts the stones of an earlier plan where it meant them to go, as far as they hold.
  /// @return true if the wall is whole then
  bool go_on_as_planned() {
    WallState state = start_;
    keep(state);
    for (const WallPlacement& planned : rest_) {
      if (context_.out_of_time()) return false;
      const Stack below = state.stack();
      const Placement& placement = planned.placement;
      if (state.stones.size() == start_.stones.size() && !is_reachable(placement, below)) {
        reason_ = "the arm does not bring the next stone to its place";
        return false;
      }
      Settled next;
      next.trial.stone = placement.stone;
      next.trial.T_W_O = T_W_V_->inverse() * placement.T_W_O;
      next.trial = settled_trial(context_, below, std::move(next.trial));
      if (next.trial.alive &&
          (next.trial.placement.T_W_O.translation() - next.trial.T_W_O.translation()).norm() > kAsPlanned) {
        next.trial.alive = false;
        next.trial.outcome = "a stone comes to rest beside where it was planned";
      }
      if (!next.trial.alive || !holds(state, next)) {
        reason_ = next.trial.outcome;
        return false;
      }
      next.placed = standing(context_, {placement.stone, next.trial.placement.T_W_O}, planned.course);
      state = with(state, next);
      keep(state);
    }
    return !rest_.empty() && !slot_after(state);
  }

  /// Can the arm bring the stone to that pose, in W, among those stones of the wall?
  [[nodiscard]] bool is_reachable(const Placement& placement, const Stack& below_V) const {
    if (!context_.problem->reachable) return true;
    Stack below = context_.stack;  // in W; what the search has put there follows
    for (std::size_t k = below.stones.size(); k < below_V.stones.size(); ++k)
      below.stones.push_back({below_V.stones[k].stone, *T_W_V_ * below_V.stones[k].T_W_O});
    return context_.problem->reachable(placement.stone, placement.T_W_O, below);
  }

  /// Best first, the proposals that the arm can carry out, at most `kSettledInSlot`.
  void keep_reachable(std::vector<WallProposal>& list, const Stack& below) {
    if (!context_.problem->reachable) {
      list.resize(std::min(list.size(), kSettledInSlot));
      return;
    }
    std::vector<WallProposal> kept;
    for (WallProposal& made : list) {
      if (kept.size() == kSettledInSlot) break;
      throw_if_interrupted();
      Placement placement;
      placement.stone = made.proposal.stone;
      placement.T_W_O = *T_W_V_ * stone_pose(made.proposal.body);
      if (is_reachable(placement, below))
        kept.push_back(std::move(made));
      else
        ++unreachable_;
    }
    list = std::move(kept);
  }

  /// The stones that come to rest in a slot in balance, best first.
  std::vector<Settled> settled(const WallState& state, const WallSlot& slot) {
    WallProposals proposals = wall_proposals(context_, state, slot, stones_);
    candidates_ += proposals.evaluated;
    const Stack below = state.stack();
    const bool fits = !proposals.list.empty();
    keep_reachable(proposals.list, below);
    std::vector<Settled> list(proposals.list.size());
    run_tasks(context_.options->threads, list.size(), [&](std::size_t k) {
      const WallProposal& made = proposals.list[k];
      Trial trial;
      trial.stone = made.proposal.stone;
      trial.T_W_O = stone_pose(made.proposal.body);
      trial.estimate = made.proposal.robust;
      list[k].trial = settled_trial(context_, below, std::move(trial));
      if (!list[k].trial.alive) return;
      const Pose& T_W_O = list[k].trial.placement.T_W_O;
      const BodyPose body = body_pose(*made.stone->geometry, T_W_O);
      list[k].placed = placed_in_wall(*made.stone, *made.side, body.R_W_O, body.p_W_M, slot.course);
      list[k].worth = worth_in_slot(slot, list[k].placed, list[k].trial.margin, context_.options->friction);
    });
    for (const Settled& one : list)
      if (!one.trial.alive) reason_ = one.trial.outcome;
    if (list.empty())
      reason_ =
          fits ? "the arm brings none of the stones that fit to its place" : "no stone that is left fits";
    std::erase_if(list, [](const Settled& one) { return !one.trial.alive; });
    for (Settled& one : list) one.worth += urgency_[one.placed.stone] + random_.normal(0.0, variation_);
    std::stable_sort(list.begin(), list.end(),
                     [](const Settled& p, const Settled& q) { return p.worth > q.worth; });
    return list;
  }

  /// Judges a stone in place, and predicts it; false if it does not hold.
  bool holds(const WallState& state, Settled& next) {
    ++judged_;
    const Stack below = state.stack();
    next.trial = judged_trial(context_, below, std::move(next.trial));
    if (next.trial.alive && context_.options->perturbations > 0) {
      const Candidate candidate{&below, &next.trial};
      next.trial = predicted_trials(context_, {&candidate, 1}, context_.options->perturbations).front();
    }
    if (!next.trial.alive) reason_ = next.trial.outcome;
    return next.trial.alive;
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

  WallState with(const WallState& state, const Settled& next) const {
    WallState higher = state;
    higher.stones.push_back(next.placed);
    higher.trials.push_back(next.trial);
    return higher;
  }

  [[nodiscard]] bool out_of_tries() const { return context_.out_of_time() || judged_ >= budget_; }

  [[nodiscard]] std::optional<WallSlot> slot_after(const WallState& state) const {
    return next_slot(target_, state, [&] { return common_thickness(stones_, state); });
  }

  /// Depth-first, until the wall is complete.
  bool complete(const WallState& state) {
    keep(state);
    const std::optional<WallSlot> slot = slot_after(state);
    if (!slot) return true;
    std::vector<Settled> list = settled(state, *slot);
    std::size_t tried = 0;
    for (Settled& next : list) {
      if (out_of_tries() || tried == kTriedInSlot) return false;
      if (!holds(state, next)) continue;
      ++tried;
      if (complete(with(state, next))) return true;
    }
    return false;
  }

  /// Stone after stone, as far as the length goes; a place where nothing fits is left open.
  void grow(WallState state) {
    std::optional<WallSlot> slot = slot_after(state);
    while (slot && !out_of_tries()) {
      std::vector<Settled> list = settled(state, *slot);
      const auto next =
          std::find_if(list.begin(), list.end(), [&](Settled& one) { return holds(state, one); });
      if (next != list.end()) {
        state = with(state, *next);
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
  WallState start_;                  // what stands before the search
  std::optional<Pose> T_W_V_;        // see frame()
  std::vector<WallPlacement> rest_;  // of an earlier plan, in W
  bool rest_only_ = false;
  int unreachable_ = 0;
  WallState best_, longest_;              // of all passes, of this pass
  std::map<StoneIndex, double> urgency_;  // a stone that is hard to place is placed early
  int asked_ = 0, judged_ = 0, budget_ = 0;
  double variation_ = 0.0;
  Random random_ = Random::stream(0, "wall");
  long candidates_ = 0;
  std::string reason_;
};

void check_target(const WallTarget& target, std::size_t stones) {
  require((!target.centre_W || target.centre_W->allFinite()) && std::isfinite(target.yaw),
          "the wall's place must be finite");
  if (target.courses.empty()) {
    require(target.length > 0.0 && std::isfinite(target.length) && target.levels > 0,
            "a wall needs stones a course (4+3+2+1), or a length and a number of courses");
    return;
  }
  for (std::size_t k = 0; k < target.courses.size(); ++k) {
    const int count = target.courses[k];
    require(count > 0, "a course needs at least one stone, got ", count);
    require(k == 0 || count <= target.courses[k - 1], "course ", k + 1, " has more stones (", count,
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

SearchContext wall_context(const SearchProblem& problem, const SearchOptions& options,
                           const std::function<void(const std::string&)>& report) {
  SearchContext context = make_context(problem, options, report);
  context.tower = false;
  return context;
}

/// Placements that each stone rests on.
std::vector<std::vector<int>> supports_of(const SearchContext& context, const WallState& state) {
  std::vector<std::vector<int>> supports(state.stones.size());
  for (const Contact& contact : geometric_contacts(context.shapes(), state.stack(), kCloseGap)) {
    auto& list = supports[static_cast<std::size_t>(contact.above)];
    if (contact.below == kTable || contact.n_W.z() < 0.3) continue;
    if (std::find(list.begin(), list.end(), contact.below) == list.end()) list.push_back(contact.below);
  }
  return supports;
}

}  // namespace

WallPlan plan_wall(const SearchProblem& problem, const WallTarget& target, const SearchOptions& options,
                   const std::function<void(const std::string&)>& report,
                   const std::optional<WallBegun>& begun) {
  check_problem(problem, options);
  check_begun(problem, begun);
  check_target(target, problem.available.size() + problem.stack.stones.size());
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
  const std::vector<std::vector<int>> supports = supports_of(context, best);
  for (std::size_t k = problem.stack.stones.size(); k < best.stones.size(); ++k) {
    WallPlacement placement{best.trials[k].placement, best.stones[k].course, supports[k]};
    placement.placement.T_W_O = plan.T_W_V * placement.placement.T_W_O;
    placement.placement.support = {};
    plan.placements.push_back(std::move(placement));
  }
  if (!search.is_whole()) plan.reason = search.reason();
  plan.seconds = context.watch.seconds();
  return plan;
}

WallMetrics measure_wall(const SearchProblem& problem, const WallBegun& begun, const SearchOptions& options) {
  check_problem(problem, options);
  check_begun(problem, begun);
  const SearchContext context = wall_context(problem, options, {});
  return wall_metrics(context, state_of(context, begun));
}

}  // namespace stonestack::search
