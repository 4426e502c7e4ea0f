#include <algorithm>
#include <cmath>

#include "stacking/builder.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/stacking/execute.hpp"

namespace stonestack::stacking {

bool Builder::place(const Target& target) {
  const Placement& placement = target.placement;
  report(concat("level ", belief_.stack.size() + 1, ": ", name(placement.stone), ", cost ", placement.cost,
                ", predicted success ", placement.predicted_success));
  record("target", placement_json(catalogue_, placement));
  last_ = placement;
  last_below_ = belief_.stack.size();
  const double start = cell_.clock.now();
  const ExecutionResult done =
      execute(target.plan, catalogue_.stones[static_cast<std::size_t>(placement.stone)], target.scene, cell_,
              options_.motion, hooks_.journal);
  result_.seconds.motion += cell_.clock.now() - start;

  aimed_off_.push_back(placing_bias());
  PlacementRecord entry{name(placement.stone), placement,
                        std::nullopt,          PlacementRecord::Outcome::kPlaced,
                        done.reason,           static_cast<int>(last_below_) + 1};
  if (done.status == ExecutionResult::Status::kStopped) {
    entry.outcome = PlacementRecord::Outcome::kLost;
    result_.placements.push_back(entry);
    result_.end = RunResult::End::kStopped;
    result_.ended = "the arm stopped: " + done.reason;
    update_height();
    return false;
  }
  const bool released = done.status == ExecutionResult::Status::kReleased;
  const std::vector<PlacedStone> below = belief_.stack;
  if (released) belief_.stack.push_back({placement.stone, placement.T_W_O});
  std::erase_if(belief_.loose, [&](const PlacedStone& s) { return s.stone == placement.stone; });
  look_around(released);
  judge(entry, placement, done.status);
  if (entry.outcome != PlacementRecord::Outcome::kPlaced) ahead_.reset();
  result_.placements.push_back(entry);
  record("outcome",
         concat("{\"stone\": \"", entry.stone, "\", \"outcome\": \"", to_text(entry.outcome), "\"}"));
  report(concat(entry.stone, ": ", to_text(entry.outcome), entry.note.empty() ? "" : ", " + entry.note));
  update_height();
  using Outcome = PlacementRecord::Outcome;
  if (entry.outcome == Outcome::kFallen || entry.outcome == Outcome::kLost)
    last_ = {};  // a plan that failed is not followed again
  if (released && (entry.outcome == Outcome::kFallen || entry.outcome == Outcome::kLost))
    learn_from_fall(below, placement);
  if (entry.outcome == Outcome::kPlaced) return true;
  if (entry.outcome == Outcome::kNotPicked || entry.outcome == Outcome::kDropped) {
    failed_grasps_[placement.stone].push_back(target.plan.T_O_T);
    const auto misses =
        std::count_if(result_.placements.begin(), result_.placements.end(), [&](const PlacementRecord& r) {
          return (r.outcome == Outcome::kNotPicked || r.outcome == Outcome::kDropped) &&
                 r.stone == entry.stone;
        });
    if (misses < options_.pick_attempts) return true;
  }
  if (++failures_ < options_.most_failures && entry.outcome != PlacementRecord::Outcome::kLost) return true;
  result_.end = RunResult::End::kPlacementFailed;
  result_.ended = concat("placing ", entry.stone, " failed: ", to_text(entry.outcome),
                         entry.note.empty() ? "" : ", " + entry.note);
  return false;
}

void Builder::believe_the_plan(std::vector<PlacedStone>& stack,
                               const std::vector<PlacedStone>& expected) const {
  for (std::size_t i = 0; i < std::min(stack.size(), expected.size()); ++i)
    if (same_place(shapes_, stack[i], expected[i], options_.placed_shift, options_.placed_turn))
      stack[i].T_W_O = expected[i].T_W_O;
}

/// Compares what was seen with what was planned.
void Builder::judge(PlacementRecord& entry, const Placement& planned, ExecutionResult::Status done) {
  using Outcome = PlacementRecord::Outcome;
  const auto find = [&](const std::vector<PlacedStone>& list) -> std::optional<Pose> {
    for (const auto& placed : list)
      if (placed.stone == planned.stone) return placed.T_W_O;
    return std::nullopt;
  };
  const auto in_stack = find(belief_.stack);
  const auto on_table = find(belief_.loose);
  entry.T_W_O_measured = in_stack ? in_stack : on_table;
  if (done == ExecutionResult::Status::kLost) {
    entry.outcome = Outcome::kDropped;
    entry.note += in_stack   ? "; it lies on the tower"
                  : on_table ? "; it lies on the table"
                             : "; it is not seen";
  } else if (done == ExecutionResult::Status::kNotPicked && on_table) {
    entry.outcome = Outcome::kNotPicked;
  } else if (in_stack) {
    const auto error = difference(*in_stack, planned.T_W_O);
    const bool near = error.translation <= options_.placed_shift && error.angle <= options_.placed_turn;
    entry.outcome = near ? Outcome::kPlaced : Outcome::kMoved;
    entry.note = concat(std::lround(1000 * error.translation), " mm and ",
                        std::lround(error.angle * 57.29578), " deg from the plan");
  } else {
    entry.outcome = on_table ? Outcome::kFallen : Outcome::kLost;
    entry.note = on_table ? "it lies on the table" : "it is not seen";
  }
}

}  // namespace stonestack::stacking
