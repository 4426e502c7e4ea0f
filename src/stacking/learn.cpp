#include "stacking/learn.hpp"

#include <algorithm>
#include <cmath>

#include "core/constants.hpp"
#include "search/constants.hpp"
#include "stacking/arrangement.hpp"
#include "stacking/choose_in_wall.hpp"
#include "stacking/constants.hpp"
#include "stacking/next_view.hpp"
#include "stacking/settle_stack.hpp"
#include "stacking/unknown_objects.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::stacking {
namespace {

constexpr double kStillUp = 0.9;    // cosine (26 deg) between the ups of a stone as set down and as seen
constexpr double kPushed = 0.010;   // m: a stone that moved less was not pushed
constexpr double kMaxBias = 0.008;  // m: a stone that came to rest further off has slid

using Outcome = PlacementRecord::Outcome;
using Status = ExecutionResult::Status;

const StoneEstimate* find(const std::vector<StoneEstimate>& stones, StoneIndex stone) {
  const auto found =
      std::find_if(stones.begin(), stones.end(), [&](const StoneEstimate& s) { return s.stone == stone; });
  return found == stones.end() ? nullptr : &*found;
}

void erase(std::vector<StoneEstimate>& stones, StoneIndex stone) {
  std::erase_if(stones, [&](const StoneEstimate& s) { return s.stone == stone; });
}

/// Alternatives that a search had to the placement that is carried out, best first.
std::vector<Alternative> compared_with(const Placement& chosen, const SearchResult& found) {
  std::vector<Alternative> list;
  for (const Placement& other : found.best)
    if (other.stone != chosen.stone || !other.T_W_O.isApprox(chosen.T_W_O, 1e-9))
      list.push_back({other.stone,
                      other.T_W_O,
                      other.cost,
                      other.terms,
                      other.predicted_success,
                      other.expected_height,
                      {}});
  list.insert(list.end(), found.others.begin(), found.others.end());
  list.resize(std::min(list.size(), search::kMaxAlternatives));
  return list;
}

/// Drops what holds for one world only.
void forget_world(RunMemory& memory) {
  memory.search.reset();
  memory.no_pick.clear();
  memory.refused.clear();
  memory.sought_where_it_was.clear();
  memory.sought_beside_site = 0;
  memory.stray_stays = memory.stack_stays = false;
  memory.not_pushed.clear();
}

void note_view(RunMemory& memory, const LookAgain& view) {
  if (view.where == LookAgain::Where::kWhereItWas)
    memory.sought_where_it_was.insert(view.stone);
  else
    ++memory.sought_beside_site;
}

/// The program ended while the action was carried out.
bool is_broken_off(const Attempt& attempt) {
  return attempt.done.status == Status::kUnknown || attempt.done.status == Status::kTakenBack;
}

/// How the world should be seen after a motion that ended like that.
void expect(Attempt& attempt, const WorldEstimate& world) {
  attempt.expected_stack = world.stack;
  attempt.expected_loose = world.loose;
  const StoneIndex stone = attempt.placement.stone;
  const StoneEstimate there{stone, attempt.placement.T_W_O, attempt.placement.T_W_O};
  const bool released = attempt.done.status == Status::kReleased;
  if (is_broken_off(attempt)) {  // it may be at either end
    auto& list =
        std::holds_alternative<Place>(attempt.action) ? attempt.expected_stack : attempt.expected_loose;
    list.push_back(there);
    return;
  }
  if (std::holds_alternative<Place>(attempt.action)) {
    if (released) attempt.expected_stack.push_back(there);
    erase(attempt.expected_loose, stone);
    return;
  }
  // What the gripper missed is still expected where it was, on the stack maybe.
  if (released || attempt.done.status == Status::kLost) {
    erase(attempt.expected_stack, stone);
    erase(attempt.expected_loose, stone);  // or the gripper, which is there now, would seem to be in it
  }
  if (released) attempt.expected_loose.push_back(there);
}

void report_moved(const std::vector<StoneEstimate>& expected, const WorldEstimate& seen,
                  const BuildOptions& options, const Listener& emit) {
  for (const StoneEstimate& before : expected) {
    const StoneEstimate* now = find(seen.stack, before.stone);
    if (now == nullptr) {
      emit(StoneLeftStack{before.stone});
      continue;
    }
    const double shift = difference(now->T_W_O_at_rest, before.T_W_O_at_rest).translation;
    if (shift > options.moved_shift) emit(StoneMoved{before.stone, shift});
  }
}

/// A stone that was released there, on those, did not stay: the frictions with which it should have are less
/// likely than was thought. Frictions at which those below could not have stood are not: they did.
FrictionEstimate learn_from_fall(const FrictionEstimate& friction, const Attempt& attempt,
                                 const WorldEstimate& seen, const Models& models,
                                 const BuildOptions& options) {
  SearchProblem problem;
  problem.shapes = &models.shapes;
  problem.possible_shapes = &models.possible_shapes;
  problem.stack.stones = attempt.below;
  problem.site = seen.layout.site;
  const PlacedStone stone{attempt.placement.stone, attempt.placement.T_W_O};
  problem.available = {stone};
  const std::vector<RestingStack> resting =
      resting_stacks(models.shapes, Stack{attempt.below}, options.search, friction.frictions, true);
  const std::vector<bool> all(friction.frictions.size(), true);
  std::vector<double> success =
      expected_by_friction(problem, {stone}, friction.frictions, all, &resting, options.search);
  if (stands_at_some_friction(resting))
    for (std::size_t k = 0; k < success.size(); ++k)
      if (!resting[k].stack) success[k] = 1.0;
  return update_estimate(friction, success);
}

/// Picks that failed of one stone.
long missed_picks(const std::vector<PlacementRecord>& records, const std::string& stone) {
  return std::count_if(records.begin(), records.end(), [&](const PlacementRecord& record) {
    return (record.outcome == Outcome::kNotPicked || record.outcome == Outcome::kDropped) &&
           record.stone == stone;
  });
}

void learn_from_placing(RunMemory& memory, const Attempt& attempt, const PlacementRecord& record,
                        const WorldEstimate& seen, const Models& models, const BuildOptions& options,
                        const Listener& emit) {
  const bool gone = record.outcome == Outcome::kFallen || record.outcome == Outcome::kLost;
  if (gone) memory.plan.reset();  // a plan that failed is not followed again
  // What of a wall falls says little about one pair of stones.
  if (gone && attempt.done.status == Status::kReleased && !models.wall) {
    memory.friction = learn_from_fall(memory.friction, attempt, seen, models, options);
    emit(FrictionUpdated{memory.friction});
  }
  if (record.outcome == Outcome::kPlaced) {
    memory.pushed = 0;  // what was pushed led to something
    return;
  }
  if (record.outcome == Outcome::kNotPicked || record.outcome == Outcome::kDropped) {
    memory.failed_grasps[attempt.placement.stone].push_back(attempt.T_O_T);
    if (missed_picks(memory.records, record.stone) < options.pick_attempts) return;
  }
  if (++memory.failures < options.max_failures) return;
  memory.failure = {RunEnd::kPlacementFailed,
                    concat("placing ", record.stone, " failed: ", to_text(record.outcome),
                           record.note.empty() ? "" : ", " + record.note)};
}

/// An object of which the gripper twice held too little weight for stone is none: the camera modelled it, and
/// its mass was a guess. It is not looked for any more, and kept clear of.
void learn_from_weight(RunMemory& memory, const Attempt& attempt, const Models& models,
                       const Listener& emit) {
  const StoneIndex index = attempt.placement.stone;
  const Stone& stone = models.stone(index);
  if (attempt.done.status != Status::kNotPicked || !attempt.done.weight || !stone.surface) return;
  if (*attempt.done.weight > kGravity * kLightStone * volume(stone.scan)) return;
  if (memory.too_light.insert(index).second) return;
  emit(StoneTooLight{index, *attempt.done.weight});
  memory.disproved.insert(index);
  memory.awaited.erase(index);
  if (const auto seen = memory.last_seen.find(index); seen != memory.last_seen.end()) {
    memory.p_W_objects.emplace_back(seen->second.head<2>());  // so that it is not modelled once more
    memory.last_seen.erase(seen);
  }
  memory.plan.reset();
}

/// A stone that is seen otherwise than it was set down: that resting pose is not tried with it again.
void learn_from_reorienting(RunMemory& memory, const Attempt& attempt, const PlacementRecord& record,
                            const Listener& emit) {
  const auto up = [](const Pose& T_W_O) -> Eigen::Vector3d { return T_W_O.linear().row(2).transpose(); };
  if (record.outcome != Outcome::kReoriented || !record.T_W_O_measured) return;
  const Eigen::Vector3d n_O_up = up(attempt.placement.T_W_O);
  if (n_O_up.dot(up(*record.T_W_O_measured)) > kStillUp) return;
  emit(StoneToppled{attempt.placement.stone});
  memory.toppled[attempt.placement.stone].push_back(n_O_up);
}

PlacementRecord judge_placing(const Attempt& attempt, const WorldEstimate& seen, PlacementRecord record,
                              const BuildOptions& options) {
  const StoneEstimate* in_stack = find(seen.stack, attempt.placement.stone);
  const StoneEstimate* on_table = find(seen.loose, attempt.placement.stone);
  record.level = static_cast<int>(attempt.below.size()) + 1;
  record.course = attempt.course;
  if (attempt.done.status == Status::kLost) {
    record.outcome = Outcome::kDropped;
    record.note += in_stack != nullptr   ? "; it lies on the tower"
                   : on_table != nullptr ? "; it lies on the table"
                                         : "; it is not seen";
  } else if (attempt.done.status == Status::kNotPicked && on_table != nullptr) {
    record.outcome = Outcome::kNotPicked;
  } else if (in_stack != nullptr) {
    const auto error = difference(in_stack->T_W_O_at_rest, attempt.placement.T_W_O);
    const bool near = error.translation <= options.placed_shift && error.angle <= options.placed_turn;
    record.outcome = near ? Outcome::kPlaced : Outcome::kMoved;
    record.note = concat(std::lround(1000 * error.translation), " mm and ",
                         std::lround(error.angle * 57.29578), " deg from the plan");
  } else {
    record.outcome = on_table != nullptr ? Outcome::kFallen : Outcome::kLost;
    record.note = on_table != nullptr ? "it lies on the table" : "it is not seen";
  }
  return record;
}

/// Was nothing done with the stone, as far as is seen? `expected_loose` and `below` have it where it was.
bool lies_as_before(const Attempt& attempt, const WorldEstimate& seen, const BuildOptions& options) {
  const StoneIndex stone = attempt.placement.stone;
  const StoneEstimate* now = find(seen.loose, stone);
  if (std::holds_alternative<Unstack>(attempt.action)) return find(seen.stack, stone) != nullptr;
  if (now == nullptr) return false;
  if (attempt.done.status == Status::kTakenBack) return true;
  const StoneEstimate* before = find(attempt.expected_loose, stone);  // the first of that stone
  if (before == nullptr) return false;
  const auto moved = difference(now->T_W_O_at_rest, before->T_W_O_at_rest);
  return moved.translation <= options.placed_shift && moved.angle <= options.placed_turn;
}

/// The memory before the attempt was made.
RunMemory undo(RunMemory memory, const Attempt& attempt) {
  --memory.actions;
  if (std::holds_alternative<Reorient>(attempt.action)) --memory.reoriented;
  if (std::holds_alternative<ClearBase>(attempt.action)) --memory.cleared;
  if (std::holds_alternative<Push>(attempt.action)) --memory.pushed;
  if (!std::holds_alternative<Unstack>(attempt.action)) return memory;
  --memory.unstacked;
  if (memory.unstacking) {
    ++memory.unstacking->remaining;
    --memory.unstacking->tried;
  }
  return memory;
}

constexpr std::size_t kCloudPoints = 5000;              // of an observation, for reports
constexpr double kCloudLow = -0.02, kCloudHigh = 0.60;  // m above the table

/// An even choice of the points that the views of an estimate show near the table.
std::vector<Eigen::Vector3f> cloud_of(const WorldEstimate& world) {
  std::vector<Eigen::Vector3f> cloud;
  if (!world.views) return cloud;
  std::size_t pixels = 0;
  for (const CameraView& view : *world.views) pixels += view.image.z.size();
  const std::size_t step = std::max<std::size_t>(1, pixels / (2 * kCloudPoints));
  for (const CameraView& view : *world.views)
    for (std::size_t k = 0; k < view.image.z.size(); k += step) {
      const auto z = static_cast<double>(view.image.z[k]);
      if (!(z > 0.0)) continue;
      const auto width = static_cast<std::size_t>(view.image.camera.width);
      const Eigen::Vector3d p_W =
          view.T_W_C *
          (z * deproject(view.image.camera, static_cast<double>(k % width), static_cast<double>(k / width)));
      if (p_W.z() > kCloudLow && p_W.z() < kCloudHigh) cloud.push_back(p_W.cast<float>());
    }
  return cloud;
}

/// Remembers what is no stone as long as every awaited stone is in sight.
void learn_objects(RunMemory& memory, const WorldEstimate& seen) {
  if (memory.awaited.empty() || !awaited_in_vain(seen, memory).empty()) return;
  memory.p_W_objects.clear();
  for (const Obstacle& object : seen.layout.obstacles)
    if (const Eigen::AlignedBox2d ground = ground_of(object); !ground.isEmpty())
      memory.p_W_objects.push_back(ground.center());
}

/// A stone that stayed where it was is not pushed in the same world once more.
void learn_from_pushing(RunMemory& memory, const Push& push, const WorldEstimate& seen) {
  const StoneEstimate* now = find(seen.loose, push.stone.stone);
  if (now != nullptr && difference(now->T_W_O_at_rest, push.stone.T_W_O).translation < kPushed)
    memory.not_pushed.insert(push.stone.stone);
}

}  // namespace

std::string to_text(PlacementRecord::Outcome outcome) {
  switch (outcome) {
    case Outcome::kPlaced:
      return "placed";
    case Outcome::kMoved:
      return "moved";
    case Outcome::kFallen:
      return "fallen";
    case Outcome::kNotPicked:
      return "not picked";
    case Outcome::kDropped:
      return "dropped";
    case Outcome::kLost:
      return "lost";
    case Outcome::kUnstacked:
      return "unstacked";
    case Outcome::kReoriented:
      return "reoriented";
    case Outcome::kPushed:
      return "pushed";
  }
  return "unknown";
}

Eigen::Vector3d placing_bias(const std::vector<PlacementRecord>& records) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  for (const PlacementRecord& record : records) {
    if (record.outcome != Outcome::kPlaced || !record.T_W_O_at_rest) continue;
    const Eigen::Vector3d offset = record.T_W_O_at_rest->translation() - record.planned.T_W_O.translation();
    if (offset.head<2>().norm() > kMaxBias) continue;
    sum += Eigen::Vector3d(offset.x(), offset.y(), 0.0) + record.p_W_aim;
    ++count;
  }
  return count == 0 ? sum : Eigen::Vector3d(sum / count);
}

RunMemory remember_refusal(RunMemory memory, const Action& action, const MotionPlan& plan) {
  if (const auto* view = std::get_if<LookAgain>(&action)) {
    note_view(memory, *view);
  } else if (std::holds_alternative<ClearBase>(action)) {
    ++memory.cleared;
    memory.stray_stays = true;
  } else if (std::holds_alternative<Unstack>(action)) {
    memory.stack_stays = memory.unstacking && memory.unstacking->tried == 0;
    memory.unstacking.reset();
  } else if (const auto* push = std::get_if<Push>(&action)) {
    memory.not_pushed.insert(push->stone.stone);
  } else if (memory.search) {
    ++memory.search->refused;
    if (std::holds_alternative<Place>(action))
      memory.search->refusals += concat(memory.search->refusals.empty() ? "" : "; ", plan.refusal);
    memory.no_pick = plan.no_pick;
  }
  return memory;
}

RunMemory remember(RunMemory memory, const WorldEstimate& world, const Action& action, const MotionPlan& plan,
                   const ExecutionResult& done) {
  ++memory.actions;
  if (done.friction) {
    memory.friction = update_by_measurement(std::move(memory.friction), *done.friction);
    memory.friction_measured = true;
  }
  if (done.status == Status::kStopped) memory.failure = {RunEnd::kStopped, "the arm stopped: " + done.reason};
  if (const auto* view = std::get_if<LookAgain>(&action)) {
    note_view(memory, *view);
    return memory;
  }
  FollowedPlan followed{plan.placement, world.stack.size(), memory.search ? memory.search->friction_level : 0,
                        memory.search ? memory.search->route : Route::kDirect};
  if (std::holds_alternative<Reorient>(action))
    followed.placement = plan.followed;  // to be gone on with when the stone lies there
  if (memory.search) followed.compared = compared_with(followed.placement, memory.search->found);
  if (std::holds_alternative<Place>(action)) {
    memory.plan = std::move(followed);
  } else if (std::holds_alternative<Reorient>(action)) {
    ++memory.reoriented;
    memory.plan = std::move(followed);
  } else if (std::holds_alternative<Push>(action)) {
    ++memory.pushed;
  } else {
    memory.plan.reset();  // it led nowhere
    if (std::holds_alternative<ClearBase>(action)) ++memory.cleared;
    if (std::holds_alternative<Unstack>(action)) ++memory.unstacked;
  }
  if (std::holds_alternative<Unstack>(action) && memory.unstacking) {
    --memory.unstacking->remaining;
    ++memory.unstacking->tried;
  }
  const bool failed = done.status != Status::kReleased && done.status != Status::kUnknown;
  if (!std::holds_alternative<Place>(action) && !std::holds_alternative<Push>(action) && failed)
    memory.failed_grasps[plan.placement.stone].push_back(plan.pick_and_place.T_O_T);
  if (memory.search && memory.search->wall) memory.wall = memory.search->wall;
  forget_world(memory);
  Attempt attempt{action, done, plan.placement, plan.pick_and_place.T_O_T, plan.p_W_aim, {}, 0, {}, {}};
  attempt.placement.then_compared.clear();  // kept with the plan
  attempt.below = at_rest(world).stack;
  if (memory.wall && std::holds_alternative<Place>(action))
    attempt.course = memory.wall->course.at(plan.placement.stone) + 1;
  expect(attempt, world);
  memory.attempt = std::move(attempt);
  return memory;
}

RunMemory remember_modelled(RunMemory memory, const ModelAnew& action,
                            const std::vector<PlacedStone>& modelled, const Models& models) {
  ++memory.actions;
  memory.modelled_anew += static_cast<int>(action.lost.size());
  for (const StoneIndex stone : action.lost) {
    memory.awaited.erase(stone);
    if (!action.in_sight || modelled.empty()) continue;
    memory.disproved.insert(stone);
    memory.last_seen.erase(stone);
  }
  memory.plan.reset();  // it counted on stones that are lost
  forget_world(memory);
  for (const PlacedStone& stone : modelled) {
    memory.awaited.insert(stone.stone);
    memory.last_seen[stone.stone] = com_of(models.shapes, stone);
  }
  return memory;
}

namespace {

/// Nothing that is no stone is expected to be seen as one: what lies there is an object then.
void expect_no_disproved(Expectation& expected) {
  std::erase_if(expected.loose,
                [&](const StoneEstimate& stone) { return expected.disproved.contains(stone.stone); });
}

}  // namespace

Expectation expected_after(const WorldEstimate& world, const RunMemory& memory, const Action& action) {
  Expectation expected;
  expected.site = world.site;
  expected.friction = memory.friction;
  expected.disproved = memory.disproved;
  expected.was_built = (memory.attempt && std::holds_alternative<Place>(memory.attempt->action)) ||
                       std::any_of(memory.records.begin(), memory.records.end(),
                                   [](const PlacementRecord& record) { return record.level > 0; });
  for (const auto& [stone, p_W] : memory.last_seen) expected.known.push_back(stone);
  if (memory.attempt) {
    expected.stack = memory.attempt->expected_stack;
    expected.loose = memory.attempt->expected_loose;
    expected.as_planned = std::holds_alternative<Place>(memory.attempt->action) &&
                          memory.attempt->done.status == Status::kReleased;
    expected.new_top = expected.stack.size() > memory.attempt->below.size();
  }
  expect_no_disproved(expected);
  if (std::holds_alternative<LookAgain>(action)) expected.views = world.views;
  return expected;
}

RunMemory without_world(RunMemory memory) {
  forget_world(memory);
  return memory;
}

Expectation expected_again(const WorldEstimate& world, const RunMemory& memory) {
  Expectation expected = expected_after(world, memory, Stop{});
  if (memory.attempt) return expected;
  expected.stack = world.stack;
  expected.loose = world.loose;
  expect_no_disproved(expected);
  return expected;
}

Expectation expected_modelled(const WorldEstimate& world, const RunMemory& memory, const ModelAnew& action,
                              const std::vector<PlacedStone>& modelled, const Models& models) {
  Expectation expected = expected_again(world, memory);
  for (const StoneEstimate& made : as_estimates(modelled)) {
    std::vector<StoneEstimate>& tower = expected.stack;
    const PlacedStone stone{made.stone, made.T_W_O_at_rest};
    if (action.in_sight) {
      std::replace_if(
          tower.begin(), tower.end(),
          [&](const StoneEstimate& before) { return before.stone == action.lost.front(); }, made);
      continue;
    }
    const bool stacked =
        !models.wall &&
        (tower.empty() ? !sort_by_site(models.shapes, world.layout.site, {stone}).stack.empty()
                       : rests_over(models.shapes, stone, {tower.back().stone, tower.back().T_W_O_at_rest}));
    (stacked ? tower : expected.loose).push_back(made);
  }
  return expected;
}

PlacementRecord judge(const Attempt& attempt, const WorldEstimate& seen, const Models& models,
                      const BuildOptions& options) {
  PlacementRecord record;
  record.stone = models.name(attempt.placement.stone);
  record.planned = attempt.placement;
  record.note = attempt.done.reason;
  record.p_W_aim = attempt.p_W_aim;
  const StoneEstimate* now = find(seen.loose, attempt.placement.stone);
  const bool places = std::holds_alternative<Place>(attempt.action);
  if (const StoneEstimate* in_stack = find(seen.stack, attempt.placement.stone);
      places && in_stack != nullptr)
    now = in_stack;
  if (now != nullptr) {
    record.T_W_O_measured = now->T_W_O_seen;
    record.T_W_O_at_rest = now->T_W_O_at_rest;
  }
  if (places) return judge_placing(attempt, seen, std::move(record), options);
  if (std::holds_alternative<Push>(attempt.action)) {
    record.outcome = Outcome::kPushed;
    return record;
  }
  record.outcome =
      attempt.done.status == Status::kReleased || attempt.done.status == Status::kUnknown
          ? (std::holds_alternative<Reorient>(attempt.action) ? Outcome::kReoriented : Outcome::kUnstacked)
      : attempt.done.status == Status::kLost ? Outcome::kDropped
                                             : Outcome::kNotPicked;
  return record;
}

RunMemory learn(RunMemory memory, const WorldEstimate& seen, const Models& models,
                const BuildOptions& options, const Listener& listener) {
  const Listener emit = [&](const Event& event) {
    if (listener) listener(event);
  };
  if (next_view(seen, memory)) return memory;
  for (const StoneIndex stone : missing_stones(seen, memory)) memory.out_of_sight.insert(stone);
  const Arrangement arrangement = at_rest(seen);
  for (const auto* list : {&arrangement.stack, &arrangement.loose})
    for (const PlacedStone& stone : *list) {
      memory.last_seen[stone.stone] = com_of(models.shapes, stone);
      memory.out_of_sight.erase(stone.stone);
    }
  learn_objects(memory, seen);
  WorldEstimate without_views = seen;
  without_views.views.reset();
  emit(Observed{std::move(without_views), cloud_of(seen)});
  if (memory.wall && models.wall)
    emit(WallMeasured{measure_wall(models, arrangement, memory, options.search)});
  if (!memory.attempt) return memory;
  const Attempt attempt = *std::move(memory.attempt);
  memory.attempt.reset();
  if (is_broken_off(attempt) && lies_as_before(attempt, seen, options))
    return undo(std::move(memory), attempt);
  report_moved(attempt.expected_stack, seen, options, emit);
  const PlacementRecord record = judge(attempt, seen, models, options);
  memory.records.push_back(record);
  emit(PlacementJudged{record});
  if (std::holds_alternative<Place>(attempt.action))
    learn_from_placing(memory, attempt, record, seen, models, options, emit);
  learn_from_weight(memory, attempt, models, emit);
  if (std::holds_alternative<Reorient>(attempt.action)) learn_from_reorienting(memory, attempt, record, emit);
  if (const auto* push = std::get_if<Push>(&attempt.action)) learn_from_pushing(memory, *push, seen);
  return memory;
}

RunMemory learn_of_stop(RunMemory memory, const Models& models, const Listener& listener) {
  if (!memory.attempt) return memory;
  const Attempt attempt = *std::move(memory.attempt);
  memory.attempt.reset();
  if (!std::holds_alternative<Place>(attempt.action)) return memory;
  PlacementRecord record;
  record.stone = models.name(attempt.placement.stone);
  record.planned = attempt.placement;
  record.outcome = Outcome::kLost;
  record.note = attempt.done.reason;
  record.level = static_cast<int>(attempt.below.size()) + 1;
  record.course = attempt.course;
  memory.records.push_back(record);
  if (listener) listener(PlacementJudged{record});
  return memory;
}

}  // namespace stonestack::stacking
