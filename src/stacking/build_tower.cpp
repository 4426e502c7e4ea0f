#include "stonestack/stacking/build_tower.hpp"

#include <algorithm>
#include <cmath>
#include <future>
#include <nlohmann/json.hpp>

#include "stacking/builder.hpp"
#include "stacking/steady.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/kinematics/forward.hpp"
#include "stonestack/motion/timing.hpp"
#include "stonestack/motion/transit.hpp"

namespace stonestack::stacking {
namespace {

constexpr double kBackAwaySpeed = 0.05;  // m/s
constexpr double kOpeningError = 0.003;  // m: fingers may be open that much wider than the hand says

/// Where a stone that fell off the tower may have rolled to and the look at the field does not reach.
std::vector<Eigen::Vector3d> beside_the_site(const CellLayout& layout) {
  constexpr double kBeside = 0.22;  // m
  std::vector<Eigen::Vector3d> places;
  for (const auto& [x, y] : {std::pair(0, 1), std::pair(-1, 0), std::pair(1, 0), std::pair(0, -1)})
    places.emplace_back(layout.site.x() + kBeside * x, layout.site.y() + kBeside * y, 0.04);
  return places;
}

/// Unit, W: where a straight path takes the tool.
Eigen::Vector3d way_of_tool(const PlanningScene& scene, const JointPath& path) {
  const auto p_W = [&](const Joints& q) -> Eigen::Vector3d {
    return (scene.T_W_R * forward(scene.robot, q) * scene.T_F_T).translation();
  };
  return (p_W(path.back()) - p_W(path.front())).normalized();
}

}  // namespace

Look Builder::look_at(const Eigen::Vector3d& p_W_target, bool all_unknown) {
  return look_from(look_poses(cell_.layout, p_W_target, options_.look_distance), all_unknown);
}

PlanningScene Builder::scene_of_look() const {
  PlanningScene scene = make_planning_scene(cell_.layout, robot_, catalogue_, belief_);
  // Fingers that let a stone go beside another were opened no further than there was room.
  scene.opening = std::min(scene.opening, cell_.gripper.state().opening + kOpeningError);
  return scene;
}

void Builder::step_clear(const PlanningScene& scene) {
  const auto out = way_out(scene, cell_.arm.state().q, options_.motion);
  if (!out || out->size() < 2) return;  // without a way out the look finds no way, and says so
  report("the hand stands too near to something to go on: it backs away first");
  record("step", "{\"name\": \"back away\"}");
  TimingLimits limits = timing_limits(robot_, options_.motion);
  limits.tool_speed = kBackAwaySpeed;
  GuardedMotion away;
  away.trajectory = time_path(*out, limits, robot_, scene.T_F_T);
  away.n_W_direction = way_of_tool(scene, *out);
  away.threshold = options_.motion.early_threshold;
  const MotionResult moved = cell_.arm.follow_guarded(away);
  if (moved.status == MotionResult::Status::kNoContact) return;
  throw DeviceError("arm", "stopped as the hand backed away from what it is near: " + moved.reason,
                    "look at the cell and free the hand");
}

std::optional<JointTrajectory> Builder::find_way_to_look(const std::vector<Pose>& T_W_C, bool all_unknown) {
  PlanningScene scene = scene_of_look();
  if (all_unknown) {
    scene.objects.push_back(unseen_field(cell_.layout));
    scene.objects.push_back(unseen_site(cell_.layout));
  }
  const double start = cell_.clock.now();
  step_clear(scene);
  result_.seconds.motion += cell_.clock.now() - start;
  const Stopwatch watch;
  auto way = stacking::find_way_to_look(cell_, scene, T_W_C, options_.motion);
  result_.seconds.planning += watch.seconds();
  return way;
}

JointTrajectory Builder::way_to_look(const std::vector<Pose>& T_W_C, bool all_unknown) {
  if (auto way = find_way_to_look(T_W_C, all_unknown)) return *std::move(way);
  throw DeviceError("arm", concat("none of ", T_W_C.size(), " camera poses can be reached"),
                    "check the cell's layout: site, field and robot base");
}

Look Builder::look_from(const std::vector<Pose>& T_W_C, bool all_unknown) {
  return look_along(way_to_look(T_W_C, all_unknown));
}

Look Builder::look_along(const JointTrajectory& way, const std::function<void()>& meanwhile) {
  double moved = 0.0;
  const auto go = [&] {
    const double start = cell_.clock.now();
    try {
      Look look = stacking::look_along(cell_, robot_, way);
      moved = cell_.clock.now() - start;
      return look;
    } catch (...) {  // stopped at once, whatever else is still being done
      try {
        cell_.arm.stop();
      } catch (const Error& problem) {
        log_warning(problem.what());  // what ended the motion is told by the caller
      }
      throw;
    }
  };
  const StageSeconds before = result_.seconds;
  std::future<Look> coming;
  if (meanwhile) {
    coming = std::async(std::launch::async, go);
    meanwhile();  // if it throws, the future waits until the arm has stopped
  }
  Look look = coming.valid() ? coming.get() : go();
  double left = moved;  // of the motion, beside which nobody waited for anything
  for (double StageSeconds::*stage : {&StageSeconds::detection, &StageSeconds::search}) {
    const double beside = std::min(left, result_.seconds.*stage - before.*stage);
    result_.seconds.*stage -= beside;
    result_.seconds.beside_motion += beside;
    left -= beside;
  }
  result_.seconds.motion += moved;
  return look;
}

std::optional<Look> Builder::look_if_possible(const Eigen::Vector3d& p_W_target) {
  const PlanningScene scene = scene_of_look();
  const Pose T_C_F = (cell_.layout.T_F_T * cell_.layout.T_T_C).inverse();
  for (const Pose& T_W_C : look_poses(cell_.layout, p_W_target, options_.look_distance))
    if (plan_transit(scene, cell_.arm.state().q, Pose(T_W_C * T_C_F), options_.motion))
      return look_from({T_W_C}, false);
  return std::nullopt;
}

std::vector<int> Builder::out_of_sight() const {
  std::vector<int> missing;
  const auto here = [&](const std::vector<PlacedStone>& list, int stone) {
    return std::any_of(list.begin(), list.end(), [&](const PlacedStone& s) { return s.stone == stone; });
  };
  for (const auto& [stone, place] : seen_before_)
    if (!here(belief_.stack, stone) && !here(belief_.loose, stone) && !gone_.contains(stone))
      missing.push_back(stone);
  return missing;
}

Eigen::Vector3d Builder::com_of(const PlacedStone& stone) const {
  return stone.T_W_O * shapes_[static_cast<std::size_t>(stone.stone)]->mass.p_O_M;
}

void Builder::look_around(bool as_planned) {
  refused_.clear();
  no_pick_.clear();
  ahead_.reset();
  const bool first = seen_before_.empty();
  const Eigen::Vector3d field(cell_.layout.field_centre.x(), cell_.layout.field_centre.y(), 0.05);
  const Eigen::Vector2d& site = cell_.layout.site;
  const std::vector<PlacedStone> expected = belief_.stack;
  Belief before = belief_;
  std::vector<Look> looks;
  if (expected.empty()) {
    looks.push_back(look_at(field, first));
    if (first && options_.refine_camera) before = refine_camera(looks);
    if (first) look_at_site(looks);
  } else {
    // The tower first: what comes next hangs on it, and the field rarely shows anything new.
    looks.push_back(look_at({site.x(), site.y(), top_height(shapes_, expected) - 0.03}, false));
    const auto way = way_to_look(look_poses(cell_.layout, field, options_.look_distance), false);
    looks.push_back(look_along(way, [&] {
      if (as_planned) search_on_tower(looks.front());
    }));
  }

  // What no first look showed may come to light when others are taken away, but is not worth a search in all
  // looks together after each of them.
  std::vector<int> wanted, together;
  for (int i = 0; i < static_cast<int>(catalogue_.stones.size()); ++i) {
    wanted.push_back(i);
    if (first || seen_before_.contains(i)) together.push_back(i);
  }
  const auto see = [&] {
    const Stopwatch watch;
    const auto sightings = find_in_looks(looks, models_, wanted, together, before, options_.detection);
    belief_ = believe(shapes_, cell_.layout,
                      first && site_ == SiteView::kTaken ? standing(sightings) : expected, sightings);
    if (!options_.measure_placed) believe_the_plan(belief_.stack, expected);
    belief_.stack = steadied(shapes_, Stack{belief_.stack}, options_.most_friction).stones;
    forget_reach();
    result_.seconds.detection += watch.seconds();
    report_doubtful(sightings);
  };
  see();
  keep_ahead();
  const auto look_for = [&](int stone, const Eigen::Vector3d& p_W, const char* where) {
    report(concat("looking for ", name(stone), where));
    auto look = look_if_possible(p_W);
    if (!look) return;
    looks.push_back(std::move(*look));
    see();
    keep_ahead();
  };
  // What slipped out of the hand rolls from where it was lifted, beyond the rim of the field perhaps.
  for (const int stone : out_of_sight())
    if (const auto missing = out_of_sight();
        std::find(missing.begin(), missing.end(), stone) != missing.end())
      look_for(stone, seen_before_[stone], " where it was");  // unless the look for another showed it
  for (const auto& beside : beside_the_site(cell_.layout)) {
    if (out_of_sight().empty()) break;
    look_for(out_of_sight().front(), beside, " beside the site");
  }
  for (const int stone : out_of_sight()) gone_.insert(stone);
  for (const auto* list : {&belief_.stack, &belief_.loose})
    for (const PlacedStone& stone : *list) {
      seen_before_[stone.stone] = com_of(stone);
      gone_.erase(stone.stone);
    }
  report(describe(catalogue_, belief_));
  record("observed", belief_json(catalogue_, belief_));
  report_moved(expected);
}

void Builder::report_moved(const std::vector<PlacedStone>& expected) const {
  for (const auto& before : expected) {
    const auto now = std::find_if(belief_.stack.begin(), belief_.stack.end(),
                                  [&](const PlacedStone& s) { return s.stone == before.stone; });
    if (now == belief_.stack.end()) {
      report(concat(name(before.stone), " is no longer on the stack"));
      continue;
    }
    const double shift = difference(now->T_W_O, before.T_W_O).translation;
    if (shift <= options_.moved_shift) continue;
    report(
        concat(name(before.stone), " of the stack is ", std::lround(1000 * shift), " mm from where it was"));
    record("moved", concat("{\"stone\": \"", name(before.stone), "\", \"shift_m\": ", shift, "}"));
  }
}

FieldList fields(BuildOptions& o) {
  return join({nest("detection", fields(o.detection)), nest("search", fields(o.search)),
               nest("motion", fields(o.motion)),
               nest("run", {field("most_stones", o.most_stones, {0, 100}, "", "ours"),
                            field("look_distance", o.look_distance, {0.3, 1.2}, "m", "SR300: 0.2 to 1.5 m"),
                            field("placed_shift", o.placed_shift, {0.001, 0.2}, "m", "ours"),
                            field("placed_turn", o.placed_turn, {0.01, 3.2}, "rad", "ours"),
                            field("moved_shift", o.moved_shift, {0.001, 0.2}, "m", "ours"),
                            field("most_friction", o.most_friction, {0, 2}, "", "ours"),
                            field("first_rounds", o.first_rounds, {1, 1000}, "",
                                  "measured: docs/measurements.md, Search"),
                            field("sure_success", o.sure_success, {0, 1}, "", "ours"),
                            field("least_expected", o.least_expected, {0, 100}, "", "ours"),
                            field("most_failures", o.most_failures, {1, 100}, "", "paper: 1"),
                            field("refine_camera", o.refine_camera, "ours"),
                            field("measure_placed", o.measure_placed, "ours: true"),
                            field("correct_aim", o.correct_aim, "ours"),
                            field("most_turned_over", o.most_turned_over, {0, 100}, "", "paper: 0"),
                            field("most_taken_off", o.most_taken_off, {0, 100}, "", "paper: 0"),
                            field("friction_step", o.friction_step, {0.01, 2}, "", "ours"),
                            field("pick_attempts", o.pick_attempts, {1, 10}, "", "ours")})});
}

std::string to_text(PlacementRecord::Outcome outcome) {
  switch (outcome) {
    case PlacementRecord::Outcome::kPlaced:
      return "placed";
    case PlacementRecord::Outcome::kMoved:
      return "moved";
    case PlacementRecord::Outcome::kFallen:
      return "fallen";
    case PlacementRecord::Outcome::kNotPicked:
      return "not picked";
    case PlacementRecord::Outcome::kDropped:
      return "dropped";
    case PlacementRecord::Outcome::kLost:
      return "lost";
    case PlacementRecord::Outcome::kTakenOff:
      return "taken off";
    case PlacementRecord::Outcome::kTurnedOver:
      return "turned over";
  }
  return "unknown";
}

std::string to_text(RunResult::End end) {
  switch (end) {
    case RunResult::End::kAllPlaced:
      return "all_placed";
    case RunResult::End::kHeightReached:
      return "height_reached";
    case RunResult::End::kNoPose:
      return "no_feasible_pose";
    case RunResult::End::kNoPlan:
      return "no_plan";
    case RunResult::End::kPlacementFailed:
      return "placement_failed";
    case RunResult::End::kNothingSeen:
      return "nothing_seen";
    case RunResult::End::kStopped:
      return "stopped";
    case RunResult::End::kInterrupted:
      return "interrupted";
  }
  return "unknown";
}

namespace {

/// The journal's last line. Whoever finds the run stopped reads there what stopped it. Nothing moves any
/// more: a disk that refuses costs this line, not the result.
void record_end(const BuildHooks& hooks, const std::string& end, const std::string& reason) {
  using nlohmann::json;
  if (hooks.journal == nullptr) return;
  const json data = {{"end", end}, {"reason", reason}};
  try {
    hooks.journal->record("end", data.dump(-1, ' ', false, json::error_handler_t::replace));
  } catch (const FileError& error) {
    log_warning(error.what());
  }
}

RunResult run_to_end(Builder& builder) {
  try {
    return builder.run();
  } catch (const Interrupted&) {
    return builder.stopped(RunResult::End::kInterrupted, "interrupted by the user");
  } catch (const DeviceError& error) {
    return builder.stopped(RunResult::End::kStopped, error.what());
  }
}

}  // namespace

RunResult build_tower(Cell& cell, const Catalogue& catalogue, const RobotModel& robot,
                      const BuildOptions& options, const BuildHooks& hooks) {
  Builder builder(cell, catalogue, robot, options, hooks);
  RunResult result;
  try {
    result = run_to_end(builder);
  } catch (const std::exception& error) {
    record_end(hooks, "failed", error.what());
    throw;
  }
  record_end(hooks, to_text(result.end), result.ended);
  return result;
}

}  // namespace stonestack::stacking
