#include "stacking/choose_action.hpp"

#include <algorithm>
#include <cmath>

#include "stacking/choose_in_wall.hpp"
#include "stacking/choose_placement.hpp"
#include "stacking/free_places.hpp"
#include "stacking/next_view.hpp"
#include "stacking/push_free.hpp"
#include "stacking/settle_stack.hpp"
#include "stacking/unstack_depth.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/motion/planning_scene.hpp"

namespace stonestack::stacking {
namespace {

constexpr int kMaxCleared = 4;   // tries to take stones away from the base of the tower
constexpr int kMaxModelled = 4;  // stones in whose place something else is modelled, a run
// rad: 60 runs without scans showed 0 to 0.06 where models were right, five of 0.09 to 0.15 on which towers
// stood, and 0.18 to 0.33 in eight runs, of which five failed.
constexpr double kOtherInclination = 0.16;
constexpr double kAboveSite = 0.02;  // m above the table: what reaches there from below lies at the site
constexpr double kOnTable = 0.015;   // m: a lowest stone higher than that stands on something unseen

/// Why nothing can be built at the site when a run begins; empty: it is free, or holds a tower of known
/// stones.
std::string fault_of_site(const WorldEstimate& world, const Models& models) {
  if (world.site == SiteStatus::kFree) return "";
  if (world.site == SiteStatus::kUnseen)
    return "no view shows whether something stands at the site: check the camera, and that the site is on "
           "the table";
  if (models.wall)
    return "something stands at the site, and a wall is begun on the empty table: clear the site";
  if (world.stack.empty())
    return "something stands at the site that is none of the known stones: clear the site, or name another";
  const StoneEstimate& base = world.stack.front();
  const double low = lowest(*at(models.shapes, base.stone), base.T_W_O_at_rest);
  if (low > kOnTable)
    return concat(models.name(base.stone), " stands at the site, ", std::lround(1000 * low),
                  " mm above the table, on something that is not seen: clear the site, or name another");
  return "";
}

/// Reason for which a run cannot begin.
std::optional<Stop> stop_at_start(const Situation& s) {
  const WorldEstimate& world = s.world;
  if (world.loose.empty() && world.stack.empty() && world.site != SiteStatus::kOccupied)
    return Stop{RunEnd::kNothingSeen, "no stone was seen in the field"};
  if (const std::string fault = fault_of_site(world, s.models); !fault.empty())
    return Stop{RunEnd::kNoPose, fault};
  std::vector<StoneNote> unfit;
  for (const PlacedStone& loose : s.arrangement.loose)
    if (const std::string& why = at(s.models.unfit, loose.stone); !why.empty())
      unfit.push_back({loose.stone, why});
  s.emit(StonesUnfit{unfit});
  return std::nullopt;
}

/// Stones that are awaited and nowhere to be seen lie there with a side up that their models do not have, or
/// were not recognised from the start.
std::optional<Action> model_anew(const Situation& s, const RunMemory& memory) {
  if (memory.modelled_anew >= kMaxModelled || height_is_reached(s.arrangement, s.options))
    return std::nullopt;
  ModelAnew action{awaited_in_vain(s.world, memory)};
  if (action.lost.empty()) return std::nullopt;
  return action;
}

/// A stone was set down, and rests otherwise inclined than its model would.
bool rests_inclined(const PlacementRecord& last) {
  const Eigen::Matrix3d R_W_O = last.planned.T_W_O.linear(), R_W_O_measured = last.T_W_O_measured->linear();
  return R_W_O.row(2).dot(R_W_O_measured.row(2)) < std::cos(kOtherInclination);
}

/// By their models the stones below the top one stand as they are seen.
bool rests_without_top(const Situation& s, const RunMemory& memory) {
  Stack below{s.arrangement.stack};
  below.stones.pop_back();
  return stands_at_some_friction(
      resting_stacks(s.models.shapes, below, s.options.search, memory.friction.frictions));
}

/// The top stone was just set down, and rests as its model cannot: part of that was a guess. It is modelled
/// where it stands.
std::optional<Action> model_top(const Situation& s, const RunMemory& memory) {
  if (memory.modelled_anew >= kMaxModelled || s.world.stack.empty() || memory.records.empty() ||
      s.models.wall || height_is_reached(s.arrangement, s.options))
    return std::nullopt;  // a wall plans by stones, and has no place for another one
  const StoneIndex top = s.world.stack.back().stone;
  const PlacementRecord& last = memory.records.back();
  const bool guessed = s.models.stone(top).surface && memory.awaited.contains(top);
  if (last.stone != s.models.name(top) || !last.T_W_O_measured || !guessed) return std::nullopt;
  const bool rests = stands_at_some_friction(s.world.resting);
  const bool on_table = s.world.stack.size() == 1;
  if (rests && !(on_table && rests_inclined(last))) return std::nullopt;
  if (!on_table && !rests_without_top(s, memory)) return std::nullopt;  // the fault lies below it
  return ModelAnew{{top}, true};
}

/// The top stone into the field.
Unstack unstack_top(const Situation& s, const Unstacking& unstacking) {
  const PlacedStone& top = s.arrangement.stack.back();
  if (unstacking.freed) s.emit(UnstackToFree{top.stone, unstacking.freed->stone});
  return {top, free_places(s.models.shapes, s.world.layout, s.arrangement, top)};
}

std::optional<Action> go_on_unstacking(const Situation& s, RunMemory& memory) {
  if (!memory.unstacking) return std::nullopt;
  if (memory.unstacking->remaining > 0 && s.arrangement.stack.size() > memory.unstacking->down_to)
    return unstack_top(s, *memory.unstacking);
  memory.unstacking.reset();
  return std::nullopt;
}

/// A stone that fell against the tower goes back into the field: a tower on which a stone leans is not clean,
/// and fingers do not fit between the two. Where no motion can, it is pushed off, or else the tower is
/// unstacked down to the stone that it leans on, with that one: above it nothing counts, and without it the
/// other lies free.
std::optional<Action> clear_base(const Situation& s, RunMemory& memory) {
  const auto stray = stray_at_stack(s.models.shapes, s.arrangement);
  if (!stray) return std::nullopt;
  if (!memory.stray_stays) {
    if (memory.cleared >= kMaxCleared) return std::nullopt;
    s.emit(StoneLeans{stray->stone.stone});
    Arrangement others = s.arrangement;
    std::erase_if(others.loose, [&](const PlacedStone& stone) { return stone.stone == stray->stone.stone; });
    return ClearBase{stray->stone, stray->level,
                     free_places(s.models.shapes, s.world.layout, others, stray->stone)};
  }
  if (s.models.wall) return std::nullopt;  // of a wall only the last stones are unstacked
  if (const auto push = push_off_stack(s, memory, stray->stone)) return *push;
  const std::size_t count = s.arrangement.stack.size() - stray->level;
  const int allowed = s.options.max_unstacked - memory.unstacked;
  if (memory.stack_stays || static_cast<int>(count) > allowed) return std::nullopt;
  if (count == 1 && height_is_reached(s.arrangement, s.options)) return std::nullopt;  // all of it counts
  memory.unstacking = Unstacking{allowed, 0, stray->level, stray->stone};
  return unstack_top(s, *memory.unstacking);
}

/// Nothing is set down on what is not recognised.
std::optional<Stop> stop_at_blocked_site(const Situation& s) {
  if (!s.arrangement.stack.empty()) return std::nullopt;
  const Eigen::Vector2d& site = s.world.layout.site;
  const Eigen::Vector3d p_W(site.x(), site.y(), kAboveSite);
  for (const Obstacle& obstacle : s.world.layout.obstacles)
    for (const Mesh& piece : obstacle.pieces)
      if (bounds(transformed(piece, obstacle.T_W_O)).contains(p_W))
        return Stop{
            RunEnd::kNoPose,
            concat(obstacle.name, " lies at the site, where nothing can be built now: clear the site")};
  return std::nullopt;
}

std::optional<Stop> stop_when_done(const Situation& s, const RunMemory& memory) {
  if (wall_has_its_stones(s)) return wall_stands(s);
  if (s.arrangement.loose.empty()) {
    Stop stop{RunEnd::kAllPlaced, "all stones that are seen are placed"};
    for (const StoneIndex stone : memory.out_of_sight)
      stop.reason += concat("; ", s.models.name(stone), " is out of sight");
    return stop;
  }
  if (height_is_reached(s.arrangement, s.options))
    return Stop{RunEnd::kHeightReached, concat(s.models.wall ? "the wall" : "the tower", " has the ",
                                               s.options.max_stones, " stones that were asked for")};
  return std::nullopt;
}

/// No stone is set down like that again: neither where the top one lies, nor where it was meant to lie and
/// came to rest otherwise.
void give_up_top(const Situation& s, RunMemory& memory) {
  const PlacedStone& top = s.arrangement.stack.back();
  memory.given_up.push_back(top);
  const auto last = std::find_if(memory.records.rbegin(), memory.records.rend(), [&](const auto& record) {
    return record.planned.stone == top.stone && record.outcome == PlacementRecord::Outcome::kPlaced;
  });
  if (last != memory.records.rend()) memory.given_up.push_back({top.stone, last->planned.T_W_O});
}

/// Where nothing fits on the stack: as many stones into the field as leave the most to expect, if the search
/// then finds a higher tower, or a wall of more stones.
std::optional<Action> unstack(const Situation& s, RunMemory& memory) {
  throw_if_interrupted();
  if (memory.stack_stays) return std::nullopt;
  if (memory.search->dead_end && memory.search->dead_end->end == RunEnd::kHeightReached)
    return std::nullopt;  // it is finished
  if (!s.arrangement.stack.empty()) give_up_top(s, memory);
  auto& expected = memory.search->expected_unstacked;
  if (!expected) expected = expected_unstacked(s, memory);
  const std::size_t count = unstack_depth(*expected, s.arrangement.stack.size());
  if (count == 0) return std::nullopt;
  memory.unstacking = Unstacking{static_cast<int>(count), 0, 0, std::nullopt};
  s.emit(UnstackChosen{s.arrangement.stack.back().stone, (*expected)[count - 1], static_cast<int>(count)});
  return unstack_top(s, *memory.unstacking);
}

/// Forgets which grasps failed twice: better one of these once more than none. False if none did.
bool retry_failed_grasps(const Situation& s, RunMemory& memory) {
  const auto& failed = memory.failed_grasps;
  if (std::all_of(failed.begin(), failed.end(),
                  [&](const auto& of_stone) { return failed_twice(memory, of_stone.first).empty(); }))
    return false;
  s.emit(GraspsRetried{});
  memory.failed_grasps.clear();
  memory.search.reset();
  memory.stack_stays = false;
  return true;
}

/// Is a tower planned of fewer stones than lie there? Those that are left out may only want room for a grasp,
/// and what is built before they have it may be no tower for them.
bool leaves_stones_out(const Situation& s, const RunMemory& memory) {
  if (s.models.wall || memory.search->found.best.empty()) return false;
  const std::size_t planned = 1 + memory.search->found.best.front().then.size();
  std::size_t possible = s.arrangement.loose.size();
  if (s.options.max_stones > 0)
    possible =
        std::min(possible, static_cast<std::size_t>(s.options.max_stones) - s.arrangement.stack.size());
  return planned < std::min(possible, static_cast<std::size_t>(s.options.search.horizon));
}

Action choose(const Situation& s, RunMemory& memory) {
  throw_if_interrupted();
  if (memory.failure) return Stop{memory.failure->end, memory.failure->reason};
  if (const auto view = next_view(s.world, memory)) return *view;
  if (memory.actions == 0)
    if (const auto stop = stop_at_start(s)) return *stop;
  if (const auto action = model_anew(s, memory)) return *action;
  if (const auto action = go_on_unstacking(s, memory)) return *action;
  if (const auto action = model_top(s, memory)) return *action;
  if (const auto action = clear_base(s, memory)) return *action;
  if (const auto stop = stop_when_done(s, memory)) return *stop;
  if (const auto stop = stop_at_blocked_site(s)) return *stop;
  if (const auto push = push_free(s, memory, Neighbours::kLasting)) return *push;
  do {
    if (const auto action = choose_placement(s, memory)) {
      if (leaves_stones_out(s, memory))
        if (const auto push = push_free(s, memory, Neighbours::kAll)) return *push;
      return *action;
    }
    if (s.basis == Basis::kPredicted)
      return Stop{RunEnd::kNoPose, "nothing is found for the world as predicted"};
    if (const auto push = push_free(s, memory, Neighbours::kAll)) return *push;
    if (const auto action = unstack(s, memory)) return *action;
  } while (retry_failed_grasps(s, memory));
  return *memory.search->dead_end;
}

}  // namespace

const std::string& Models::name(StoneIndex stone) const {
  return this->stone(stone).name;
}

const Stone& Models::stone(StoneIndex stone) const {
  return (*catalogue)[stone];
}

Models make_models(const Catalogue& catalogue, const RobotModel& robot, const CellLayout& layout,
                   const std::string& wall) {
  Models models{&catalogue, &robot,       make_contact_shapes(catalogue.stones),
                {},         std::nullopt, make_possible_shapes(catalogue.stones)};
  if (!wall.empty()) models.wall = read_wall_target(wall);
  const GripperModel gripper = gripper_of(layout);
  for (const Stone& stone : catalogue.stones)
    models.unfit.push_back(unfit_for_gripper(stone, gripper, robot));
  return models;
}

void add_resting_stacks(const Models& models, const BuildOptions& options, const FrictionEstimate& friction,
                        WorldEstimate& world) {
  world.resting = resting_stacks(models.shapes, Stack{at_rest(world).stack}, options.search,
                                 friction.frictions, options.wall.empty());
}

RunMemory make_memory(const BuildOptions& options) {
  RunMemory memory;
  memory.friction = first_estimate(assumed_frictions(options));
  return memory;
}

Decision choose_action(const WorldEstimate& world, const RunMemory& memory, const Models& models,
                       const BuildOptions& options, const Listener& listener, Basis basis) {
  require(world.resting.size() == memory.friction.frictions.size(), "the stack was settled at ",
          world.resting.size(), " frictions, not at ", memory.friction.frictions.size());
  Decision decision{Stop{}, memory, {}};
  const Listener note = [&](const Event& event) {
    decision.why.push_back(event);
    if (listener) listener(event);
  };
  Situation situation = make_situation(world, models, options, note, basis);
  // What turned out to be no stone just now: an object from the next observation on.
  std::erase_if(situation.arrangement.loose,
                [&](const PlacedStone& loose) { return memory.disproved.contains(loose.stone); });
  decision.action = choose(situation, decision.memory);
  return decision;
}

std::string name_of(const Action& action) {
  constexpr const char* kNames[] = {"place", "reorient",   "unstack",    "clear_base",
                                    "push",  "look_again", "model_anew", "stop"};
  return kNames[action.index()];
}

}  // namespace stonestack::stacking
