#include "stonestack/stacking/build_tower.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "stacking/believe.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/motion/grasp_check.hpp"
#include "stonestack/stacking/execute.hpp"

namespace stonestack {
namespace {

/// What is to be done next, with the plan that does it.
struct Target {
  Placement placement;
  PickAndPlacePlan plan;
  PlanningScene scene;
};

/// One run: the belief, what it was made from, and the record.
class Builder {
 public:
  Builder(Cell& cell, const Catalogue& catalogue, const RobotModel& robot, const BuildOptions& options,
          const BuildHooks& hooks)
      : cell_(cell),
        catalogue_(catalogue),
        robot_(robot),
        options_(options),
        hooks_(hooks),
        shapes_(make_contact_shapes(catalogue.stones)),
        models_(catalogue.stones, options.detection) {}

  RunResult run() {
    look_around();
    if (belief_.loose.empty()) return end(RunResult::End::kNothingSeen, "no stone was seen in the field");
    while (!high_enough()) {
      throw_if_interrupted();
      const auto target = find_target();
      if (!target) break;
      if (!place(*target)) break;
    }
    return std::move(result_);
  }

  [[nodiscard]] RunResult stopped(RunResult::End how, const std::string& why) {
    cell_.arm.stop();
    return end(how, why);
  }

 private:
  [[nodiscard]] RunResult end(RunResult::End how, const std::string& why) {
    result_.end = how;
    result_.ended = why;
    update_height();
    return std::move(result_);
  }

  void report(const std::string& line) const {
    if (hooks_.report) hooks_.report(line);
  }
  void record(const std::string& kind, const std::string& json) const {
    if (hooks_.journal != nullptr) hooks_.journal->record(kind, json);
  }
  [[nodiscard]] const std::string& name(int stone) const {
    return catalogue_.stones[static_cast<std::size_t>(stone)].name;
  }

  void update_height() {
    result_.height = static_cast<int>(belief_.stack.size());
    result_.belief = belief_;
  }

  [[nodiscard]] bool high_enough() {
    update_height();
    if (belief_.loose.empty()) {
      result_.end = RunResult::End::kAllPlaced;
      result_.ended = "all stones are placed";
      return true;
    }
    if (options_.most_stones > 0 && result_.height >= options_.most_stones) {
      result_.end = RunResult::End::kHeightReached;
      result_.ended = concat("the tower has the ", options_.most_stones, " stones that were asked for");
      return true;
    }
    return false;
  }

  /// Eq. (1) for every stone that can be seen: first the field, then, when something stands there, the site.
  void look_around();
  /// Tells of stones of the stack that are no longer where they were.
  void report_moved(const std::vector<PlacedStone>& expected) const;
  [[nodiscard]] Look look_at(const Eigen::Vector3d& p_W_target, bool field_unknown);
  [[nodiscard]] std::optional<Target> find_target();
  [[nodiscard]] SearchResult search_by_friction(const SearchProblem& problem) const;
  [[nodiscard]] std::optional<Target> plan(const Placement& placement, std::string* refusal);
  /// By how much placed stones were seen beside their targets so far, level: hand-eye and arm calibration err
  /// the same way each time, and the camera tells by how much.
  [[nodiscard]] Eigen::Vector3d placing_bias() const;
  /// False when the run is over.
  [[nodiscard]] bool place(const Target& target);
  void judge(PlacementRecord& record, const Placement& planned, bool released);

  Cell& cell_;
  const Catalogue& catalogue_;
  const RobotModel& robot_;
  const BuildOptions& options_;
  const BuildHooks& hooks_;
  ShapeList shapes_;
  DetectionModels models_;
  Belief belief_;
  RunResult result_;
  std::vector<Eigen::Vector3d> aimed_off_;  ///< m, the bias that each placement already made up for
  int failures_ = 0;                        ///< placements that did not hold
};

Look Builder::look_at(const Eigen::Vector3d& p_W_target, bool field_unknown) {
  PlanningScene scene = make_planning_scene(cell_.layout, robot_, catalogue_, belief_);
  if (field_unknown) scene.objects.push_back(unseen_field(cell_.layout));
  const double start = cell_.clock.now();
  Look look = take_look(cell_, robot_, scene, look_poses(cell_.layout, p_W_target, options_.look_distance),
                        options_.motion);
  result_.seconds.motion += cell_.clock.now() - start;
  return look;
}

void Builder::look_around() {
  const bool first = belief_.stack.empty() && belief_.loose.empty();
  const Eigen::Vector2d& field = cell_.layout.field_centre;
  const Eigen::Vector2d& site = cell_.layout.site;
  std::vector<Look> looks{look_at({field.x(), field.y(), 0.05}, first)};
  const std::vector<PlacedStone> expected = belief_.stack;
  if (!expected.empty())
    looks.push_back(look_at({site.x(), site.y(), top_height(shapes_, expected) - 0.03}, false));

  const Stopwatch watch;
  std::vector<int> wanted;
  for (int i = 0; i < static_cast<int>(catalogue_.stones.size()); ++i) wanted.push_back(i);
  const auto sightings = find_in_looks(looks, models_, wanted, expected, options_.detection);
  belief_ = believe(shapes_, cell_.layout, expected, sightings);
  result_.seconds.detection += watch.seconds();
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

std::optional<Target> Builder::find_target() {
  SearchProblem problem;
  problem.shapes = &shapes_;
  problem.stack.stones = belief_.stack;
  problem.available = belief_.loose;
  problem.site = cell_.layout.site;
  const PlanningScene scene = make_planning_scene(cell_.layout, robot_, catalogue_, belief_);
  const Joints q = cell_.arm.state().q;
  std::map<int, GraspFinder> finders;  // the pick side of each stone, worked out once
  problem.reachable = [&](int stone, const Pose& T_W_O) {
    auto finder = finders.find(stone);
    if (finder == finders.end()) {
      const auto task = make_task(catalogue_, belief_, stone, T_W_O, q);
      finder =
          finders
              .emplace(stone, GraspFinder(scene, *task.stone, task.object, task.T_W_O_pick, options_.motion))
              .first;
    }
    return finder->second.serves(T_W_O);
  };

  const Stopwatch watch;
  const SearchResult found = search_by_friction(problem);
  result_.seconds.search += watch.seconds();
  if (found.best.empty()) {
    result_.end = RunResult::End::kNoPose;
    result_.ended = "no feasible pose: " + found.reason;
    return std::nullopt;
  }
  std::string refusals;
  for (const auto& placement : found.best) {
    std::string refusal;
    if (auto target = plan(placement, &refusal)) return target;
    refusals += concat(refusals.empty() ? "" : "; ", name(placement.stone), ": ", refusal);
  }
  result_.end = RunResult::End::kNoPlan;
  result_.ended = concat("none of ", found.best.size(), " poses can be reached: ", refusals);
  return std::nullopt;
}

/// Poses that hold with little friction first; those that need more only when there is nothing as sure.
SearchResult Builder::search_by_friction(const SearchProblem& problem) const {
  SearchOptions search = options_.search;
  SearchResult best;
  for (;;) {
    SearchResult found = find_next_pose(problem, search, hooks_.report);
    const double sure = found.best.empty() ? 0.0 : found.best.front().predicted_success;
    const bool better = best.best.empty() || sure > best.best.front().predicted_success;
    if (better) best = std::move(found);
    if (sure >= options_.sure_success || search.friction >= options_.most_friction) return best;
    report(concat("friction ", search.friction, ": ",
                  better && best.best.empty() ? best.reason : concat("best predicted success ", sure)));
    search.friction = std::min(options_.most_friction, search.friction + options_.friction_step);
  }
}

std::optional<Target> Builder::plan(const Placement& placement, std::string* refusal) {
  throw_if_interrupted();
  const Stopwatch watch;
  Target target{placement, {}, make_planning_scene(cell_.layout, robot_, catalogue_, belief_)};
  const Pose T_W_O_aim = Eigen::Translation3d(-placing_bias()) * placement.T_W_O;
  const auto task = make_task(catalogue_, belief_, placement.stone, T_W_O_aim, cell_.arm.state().q);
  target.plan = plan_pick_and_place(target.scene, task, options_.motion);
  result_.seconds.planning += watch.seconds();
  if (target.plan.status == PickAndPlacePlan::Status::kPlanned) return target;
  *refusal = target.plan.reason;
  return std::nullopt;
}

Eigen::Vector3d Builder::placing_bias() const {
  constexpr double kLargest = 0.008;  // m: a stone seen further off has slid
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  for (const auto& entry : result_.placements) {
    if (entry.outcome != PlacementRecord::Outcome::kPlaced || !entry.T_W_O_measured) continue;
    const Eigen::Vector3d offset = entry.T_W_O_measured->translation() - entry.planned.T_W_O.translation();
    if (offset.head<2>().norm() > kLargest) continue;
    sum += Eigen::Vector3d(offset.x(), offset.y(), 0.0) +
           aimed_off_[static_cast<std::size_t>(&entry - result_.placements.data())];
    ++count;
  }
  return count == 0 ? sum : Eigen::Vector3d(sum / count);
}

bool Builder::place(const Target& target) {
  const Placement& placement = target.placement;
  report(concat("level ", belief_.stack.size() + 1, ": ", name(placement.stone), ", cost ", placement.cost,
                ", predicted success ", placement.predicted_success));
  record("target", placement_json(catalogue_, placement));
  const double start = cell_.clock.now();
  const ExecutionResult done =
      execute(target.plan, catalogue_.stones[static_cast<std::size_t>(placement.stone)], target.scene, cell_,
              options_.motion, hooks_.journal);
  result_.seconds.motion += cell_.clock.now() - start;

  aimed_off_.push_back(placing_bias());
  PlacementRecord entry{name(placement.stone), placement, std::nullopt, PlacementRecord::Outcome::kPlaced,
                        done.reason};
  if (done.status == ExecutionResult::Status::kStopped) {
    entry.outcome = PlacementRecord::Outcome::kLost;
    result_.placements.push_back(entry);
    result_.end = RunResult::End::kStopped;
    result_.ended = "the arm stopped: " + done.reason;
    update_height();
    return false;
  }
  const bool released = done.status == ExecutionResult::Status::kReleased;
  if (released) belief_.stack.push_back({placement.stone, placement.T_W_O});
  std::erase_if(belief_.loose, [&](const PlacedStone& s) { return s.stone == placement.stone; });
  look_around();
  judge(entry, placement, released);
  result_.placements.push_back(entry);
  record("outcome",
         concat("{\"stone\": \"", entry.stone, "\", \"outcome\": \"", to_text(entry.outcome), "\"}"));
  report(concat(entry.stone, ": ", to_text(entry.outcome), entry.note.empty() ? "" : ", " + entry.note));
  update_height();
  if (entry.outcome == PlacementRecord::Outcome::kPlaced) return true;
  if (entry.outcome == PlacementRecord::Outcome::kNotPicked) {
    const auto misses =
        std::count_if(result_.placements.begin(), result_.placements.end(), [&](const PlacementRecord& r) {
          return r.outcome == PlacementRecord::Outcome::kNotPicked && r.stone == entry.stone;
        });
    if (misses < options_.pick_attempts) return true;
  }
  if (++failures_ < options_.most_failures && entry.outcome != PlacementRecord::Outcome::kLost) return true;
  result_.end = RunResult::End::kPlacementFailed;
  result_.ended = concat("placing ", entry.stone, " failed: ", to_text(entry.outcome),
                         entry.note.empty() ? "" : ", " + entry.note);
  return false;
}

/// Compares what was seen with what was planned.
void Builder::judge(PlacementRecord& entry, const Placement& planned, bool released) {
  using Outcome = PlacementRecord::Outcome;
  const auto find = [&](const std::vector<PlacedStone>& list) -> std::optional<Pose> {
    for (const auto& placed : list)
      if (placed.stone == planned.stone) return placed.T_W_O;
    return std::nullopt;
  };
  const auto in_stack = find(belief_.stack);
  const auto on_table = find(belief_.loose);
  entry.T_W_O_measured = in_stack ? in_stack : on_table;
  if (!released && on_table) {
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

}  // namespace

FieldList fields(BuildOptions& o) {
  return join({nest("detection", fields(o.detection)), nest("search", fields(o.search)),
               nest("motion", fields(o.motion)),
               nest("run", {field("most_stones", o.most_stones, {0, 100}, "", "ours"),
                            field("look_distance", o.look_distance, {0.3, 1.2}, "m", "SR300: 0.2 to 1.5 m"),
                            field("placed_shift", o.placed_shift, {0.001, 0.2}, "m", "ours"),
                            field("placed_turn", o.placed_turn, {0.01, 3.2}, "rad", "ours"),
                            field("moved_shift", o.moved_shift, {0.001, 0.2}, "m", "ours"),
                            field("most_friction", o.most_friction, {0, 2}, "", "ours"),
                            field("sure_success", o.sure_success, {0, 1}, "", "ours"),
                            field("most_failures", o.most_failures, {1, 100}, "", "paper: 1"),
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
    case PlacementRecord::Outcome::kLost:
      return "lost";
  }
  return "unknown";
}

RunResult build_tower(Cell& cell, const Catalogue& catalogue, const RobotModel& robot,
                      const BuildOptions& options, const BuildHooks& hooks) {
  Builder builder(cell, catalogue, robot, options, hooks);
  try {
    return builder.run();
  } catch (const Interrupted&) {
    return builder.stopped(RunResult::End::kInterrupted, "interrupted by the user");
  } catch (const DeviceError& error) {
    return builder.stopped(RunResult::End::kStopped, error.what());
  }
}

}  // namespace stonestack
