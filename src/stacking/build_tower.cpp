#include "stonestack/stacking/build_tower.hpp"

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <list>
#include <nlohmann/json.hpp>
#include <utility>

#include "hardware/read_only_devices.hpp"
#include "kinematics/fastest_tool.hpp"
#include "stacking/choose_action.hpp"
#include "stacking/device_tape.hpp"
#include "stacking/learn.hpp"
#include "stacking/model_unrecognised.hpp"
#include "stacking/plan_motion.hpp"
#include "stacking/record.hpp"
#include "stacking/recorded_devices.hpp"
#include "stacking/replay.hpp"
#include "stacking/resume_point.hpp"
#include "stacking/state_file.hpp"
#include "stacking/stepped_devices.hpp"
#include "stacking/take_back.hpp"
#include "stacking/workcell.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"

namespace stonestack::stacking {
namespace {

constexpr const char* kByUser = "interrupted by the user";

/// World and memory: all that the next decision depends on.
struct Known {
  WorldEstimate world;
  RunMemory memory;
};

/// Does it belong to the progress of a search, which may also be heard while the arm moves?
bool is_of_search(const Event& event) {
  return std::holds_alternative<SearchProgress>(event) || std::holds_alternative<SearchedAtFriction>(event) ||
         std::holds_alternative<PlanHolds>(event) || std::holds_alternative<PlanBroken>(event);
}

Decision decide(Workcell& w, const Known& known, const Listener& listener, Basis basis = Basis::kObserved) {
  const Stopwatch watch;
  Decision decision = choose_action(known.world, known.memory, w.models, w.options, listener, basis);
  w.seconds.search += watch.seconds();
  return decision;
}

RunMemory learn_timed(Workcell& w, RunMemory memory, const WorldEstimate& seen, const Listener& listener) {
  const Stopwatch watch;
  memory = learn(std::move(memory), seen, w.models, w.options, listener);
  w.seconds.search += watch.seconds();
  return memory;
}

/// Observes and learns. While the arm moves the next action is chosen for the world as predicted; what the
/// search found for it is kept if the prediction comes true. What is learned is written for a resume before
/// anybody hears of it.
Known observe_and_learn(Workcell& w, const Expectation& expected, RunMemory memory,
                        const ResumeWriter& resume) {
  std::optional<SearchOutcome> ahead;
  const auto while_moving = [&](const WorldEstimate& predicted) {
    const Known then{predicted, learn(memory, predicted, w.models, w.options, {})};
    if (then.memory.failure || predicted.loose.empty()) return;
    const auto hear = [&](const Event& event) {
      if (is_of_search(event)) w.emit(event);
    };
    ahead = decide(w, then, hear, Basis::kPredicted).memory.search;
  };
  Observation seen = observe(w, expected, while_moving);
  const std::size_t judged = memory.records.size();
  Known known{std::move(seen.world), {}};
  std::vector<Event> learned;
  known.memory =
      learn_timed(w, std::move(memory), known.world, [&](const Event& event) { learned.push_back(event); });
  const auto& records = known.memory.records;
  const bool as_meant =
      records.size() == judged || records.back().outcome == PlacementRecord::Outcome::kPlaced;
  if (seen.as_predicted && as_meant) known.memory.search = std::move(ahead);
  resume.observed(known.world, known.memory, learned);
  for (const Event& event : learned) w.emit(event);
  return known;
}

/// Where `run.save_states` asks for it: STATES_FOLDER/state-001.json and so on.
class StateWriter {
 public:
  StateWriter(const Workcell& w, std::string folder) : w_(w), folder_(std::move(folder)) {}
  void write(const Known& known) {
    if (!w_.options.save_states || folder_.empty()) return;
    char name[32];
    do {  // a run that goes on has some already
      std::snprintf(name, sizeof name, "/state-%03d.json", ++count_);
    } while (std::filesystem::exists(folder_ + name));
    write_state(folder_ + name, known.world, known.memory, w_.models, w_.options);
  }

 private:
  const Workcell& w_;
  std::string folder_;
  int count_ = 0;
};

/// The next action with the motion that carries it out. A Stop has none.
struct NextStep {
  Action action;
  RunMemory memory;
  MotionPlan plan;
};

/// Chooses until a motion is found, or the run is to end; `known` remembers what was refused.
NextStep choose_with_motion(Workcell& w, StateWriter& states, Known& known) {
  for (;;) {
    states.write(known);
    auto [action, memory, why] = decide(w, known, w.emit);
    const SearchResult found = memory.search ? memory.search->found : SearchResult{};
    w.emit(ActionChosen{action, found.best, found.others});
    if (std::holds_alternative<Stop>(action)) return {action, memory, {}};
    MotionPlan plan = plan_motion(w, known.world, action, memory);
    if (plan.found) return {std::move(action), std::move(memory), std::move(plan)};
    known.memory = remember_refusal(memory, action, plan);
  }
}

bool is_empty(const WorldEstimate& world) {
  return world.loose.empty() && world.stack.empty() && world.site != SiteStatus::kOccupied;
}

/// The first observation: at the site, in the field, or with `views` from where the arm stands. A field that
/// seems empty is observed once more: a stone that was moved between two views is in neither's place.
Known observe_first(Workcell& w, const ResumeWriter& resume, std::shared_ptr<const Views> views = nullptr) {
  Expectation at_first;
  at_first.first = true;
  at_first.views = std::move(views);
  RunMemory empty = make_memory(w.options);
  if (w.add_stone)
    for (const StoneIndex stone : first_stones(w.models.shapes.size())) empty.awaited.insert(stone);
  at_first.friction = empty.friction;
  Known known = observe_and_learn(w, at_first, empty, resume);
  if (!is_empty(known.world) || at_first.views) return known;
  log_info("no stone was seen: the field is observed once more");
  return observe_and_learn(w, at_first, empty, resume);
}

/// The first observation of a run that goes on, once the gripper is free. Where nothing was observed before,
/// that of a new run.
Known observe_again(Workcell& w, ResumePoint point, const ResumeWriter& resume, Journal* journal) {
  if (!point.state) {
    (void)leave_motion(w, {}, {}, nullptr, journal);
    return observe_first(w, resume);
  }
  const WorldEstimate& world = point.state->world;
  RunMemory memory = without_world(std::move(point.state->memory));
  w.cell.layout = world.layout;
  if (leave_motion(w, world, memory, point.motion ? &*point.motion : nullptr, journal))
    memory.attempt->done.status = ExecutionResult::Status::kTakenBack;
  const Expectation expected = expected_again(world, memory);
  return observe_and_learn(w, expected, std::move(memory), resume);
}

/// Models what may be stones that are lost, adds it to the stones of the run, and observes.
Known model_and_observe(Workcell& w, const ModelAnew& action, const ResumeWriter& resume, Journal* journal,
                        const Known& known, const RunMemory& chosen) {
  w.emit(ModellingBegun{action.lost, action.in_sight});
  const ModelledField field = model_unrecognised(w, known.world, chosen, action, journal);
  for (const std::string& left : field.left_out) log_info(left);
  std::vector<PlacedStone> modelled;
  for (std::size_t k = 0; k < field.stones.size(); ++k) {
    w.add_stone(field.catalogue.stones[k], field.stones[k]);
    modelled.push_back({StoneIndex(static_cast<int>(w.models.shapes.size()) - 1), *field.stones[k].T_W_O});
    w.emit(StoneModelled{modelled.back().stone, action.lost, action.in_sight});
  }
  const RunMemory memory = remember_modelled(chosen, action, modelled, w.models);
  const Expectation expected = expected_modelled(known.world, memory, action, modelled, w.models);
  return observe_and_learn(w, expected, memory, resume);
}

/// The loop, from the first observation on.
Stop build(Workcell& w, StateWriter& states, const ResumeWriter& resume, Journal* journal, Known known) {
  for (;;) {
    const auto [action, memory, plan] = choose_with_motion(w, states, known);
    if (const auto* stop = std::get_if<Stop>(&action)) return *stop;
    if (const auto* model = std::get_if<ModelAnew>(&action)) {
      known = model_and_observe(w, *model, resume, journal, known, memory);
      continue;
    }
    ExecutionResult unknown;
    unknown.status = ExecutionResult::Status::kUnknown;
    resume.acting(known.world, remember(memory, known.world, action, plan, unknown), plan);
    const ExecutionResult done = execute(w, action, plan, known.world.stack.size(), journal);
    known.memory = remember(memory, known.world, action, plan, done);
    if (known.memory.failure)
      known.memory = learn_of_stop(known.memory, w.models, w.emit);
    else
      known = observe_and_learn(w, expected_after(known.world, known.memory, action), known.memory, resume);
  }
}

/// The end of a run. Nothing moves any more: a disk that refuses costs the journal's last line, not the
/// result.
void report_end(Recorder& recorder, const Stop& stop) {
  try {
    recorder.hear(RunEnded{stop.end, stop.reason});
  } catch (const FileError& error) {
    log_warning(error.what());
  }
}

/// An arm that does not answer any more is part of the reason.
Stop stop_arm(Arm& arm, RunEnd end, std::string reason) {
  try {
    arm.stop();
  } catch (const Error& problem) {
    reason += concat("; the arm did not confirm a stop: ", problem.what());
  }
  return {end, reason};
}

/// The steps of a plan, each with its speed.
std::vector<PlannedStep> steps_of(const Workcell& w, const Action& action, const MotionPlan& plan) {
  std::vector<PlannedStep> steps;
  const auto add = [&](const std::string& name, const JointTrajectory& trajectory) {
    steps.push_back(
        {name, trajectory.duration(), fastest_tool(trajectory, *w.models.robot, w.cell.layout.T_F_T)});
  };
  if (std::holds_alternative<LookAgain>(action)) add("move to a view", plan.route);
  for (const PlanStep& step : plan.pick_and_place.steps) add(step.name, step.trajectory);
  return steps;
}

/// One view without a motion, and the first action that a motion is found for.
Stop look_and_plan(Workcell& w, StateWriter& states, FirstStep& first, std::vector<PlannedStep>& steps) {
  const ResumeWriter nowhere({}, w.models, w.options, w.seconds, nullptr);
  Known known = observe_first(w, nowhere, std::make_shared<const Views>());
  if (known.world.site == SiteStatus::kUnseen) {
    log_info("the site is not in view; it is taken to be free");
    known.world.site = SiteStatus::kFree;
  }
  auto [action, memory, plan] = choose_with_motion(w, states, known);
  if (const auto* stop = std::get_if<Stop>(&action)) {
    if (stop->end != RunEnd::kNothingSeen) return *stop;
    return {stop->end, stop->reason + " from where the arm stands; jog it so that the camera looks there"};
  }
  steps = steps_of(w, action, plan);
  const Arrangement lying = at_rest(known.world);
  const StoneIndex stone = plan.placement.stone;
  if (holds(known.world.loose, stone))
    first.task = make_task(*w.models.catalogue, lying, stone, plan.placement.T_W_O, w.cell.arm.state().q);
  std::string what = name_of(action);
  if (!std::holds_alternative<LookAgain>(action)) {
    const Eigen::Vector3d p_W = plan.placement.T_W_O.translation();
    what += concat(' ', w.models.name(stone), " at (", p_W.x(), ", ", p_W.y(), ", ", p_W.z(), ") m");
  }
  first.scene = std::move(plan.scene);
  first.plan = std::move(plan.pick_and_place);
  return {RunEnd::kPlanned, "dry run, nothing moved; the first step would be: " + what};
}

/// Lets the journal write where the arm is with each step, as long as this object lives.
class WatchedArm {
 public:
  WatchedArm(Journal* journal, const Timeline& timeline) : journal_(journal) {
    if (journal_ == nullptr) return;
    journal_->watch_arm([&timeline] {
      if (timeline.samples.empty()) return std::string();
      const MotionSample& now = timeline.samples.back();
      const auto to_digits = [](double value) { return std::round(1e5 * value) / 1e5; };
      nlohmann::json q = nlohmann::json::array();
      for (const double angle : now.q) q.push_back(to_digits(angle));
      return nlohmann::json{{"q", q}, {"force", to_digits(now.force)}, {"holds", now.holds}}.dump();
    });
  }
  ~WatchedArm() {
    if (journal_ != nullptr) journal_->watch_arm({});
  }
  WatchedArm(const WatchedArm&) = delete;
  WatchedArm& operator=(const WatchedArm&) = delete;

 private:
  Journal* journal_;
};

/// Closes the gap in the journal, and opens its next part.
void note_resumed(Journal& journal, const ResumePoint& before) {
  complete_journal(journal, before);
  nlohmann::json data{{"placements", 0}, {"attempt", nullptr}};
  if (before.state) {
    const RunMemory& memory = before.state->memory;
    data["placements"] = memory.records.size();
    if (memory.attempt) data["attempt"] = name_of(memory.attempt->action);
  }
  journal.record("resumed", data.dump());
}

/// Models of stones and robot, for planning and for detection.
struct RunModels {
  Models planning;
  DetectionModels detection;
  std::list<Catalogue> grown =
      {};  ///< with stones that were modelled while the run went on; the last one counts

  void add(const Stone& stone, const CellLayout& layout, const BuildOptions& options) {
    Catalogue more = *planning.catalogue;
    more.stones.push_back(stone);
    grown.push_back(std::move(more));
    planning = make_models(grown.back(), *planning.robot, layout, options.wall);
    detection = DetectionModels(grown.back().stones, options.detection);
  }
};

/// Empty after Ctrl-C.
std::optional<RunModels> make_run_models(const Catalogue& catalogue, const RobotModel& robot,
                                         const CellLayout& layout, const BuildOptions& options) {
  try {
    Models planning = make_models(catalogue, robot, layout, options.wall);
    DetectionModels detection(catalogue.stones, options.detection);
    return RunModels{std::move(planning), std::move(detection)};
  } catch (const Interrupted&) {
    return std::nullopt;
  }
}

/// Everything around the loop: what it does, with which devices, and how it ended. `before`: a run that goes
/// on.
RunResult run_with(Cell& cell, const Catalogue& catalogue, const RobotModel& robot,
                   const BuildOptions& options, const BuildHooks& hooks,
                   const std::function<Stop(Workcell&, StateWriter&)>& work,
                   const ResumePoint* before = nullptr, const ModelledHook& modelled = {}) {
  Cell planned = cell;
  planned.layout.linkage = options.linkage;
  check_options(options);
  std::optional<RunModels> made = make_run_models(catalogue, robot, planned.layout, options);
  const Models none{&catalogue, &robot, {}, {}, std::nullopt};
  const Models& models = made ? made->planning : none;
  Recorder recorder(models, hooks, cell.clock);
  if (before != nullptr) recorder.go_on_from(*before);
  if (!made) {  // nothing has moved
    report_end(recorder, stop_arm(cell.arm, RunEnd::kInterrupted, kByUser));
    return std::move(recorder.result());
  }
  if (models.wall && models.wall->centre_W) planned.layout.site = *models.wall->centre_W;
  const WatchedArm watched(hooks.journal, recorder.result().timeline);
  std::optional<SteppedDevices> stepped;
  if (hooks.before_motion) stepped.emplace(planned, robot, hooks.before_motion, hooks.journal);
  RecordedDevices devices(stepped ? stepped->cell() : planned, recorder.result().timeline);
  ModelledHook add_stone;
  if (options.unseen && modelled)
    add_stone = [&](const Stone& stone, const ModelledStone& known) {
      made->add(stone, planned.layout, options);
      modelled(stone, known);
    };
  Workcell workcell{devices.cell(),
                    models,
                    made->detection,
                    options,
                    recorder.result().seconds,
                    [&](const Event& event) { recorder.hear(event); },
                    add_stone};
  StateWriter states(workcell, hooks.states_folder);
  Stop ended;
  try {
    ended = work(workcell, states);
  } catch (const Interrupted&) {
    ended = stop_arm(cell.arm, RunEnd::kInterrupted, kByUser);
  } catch (const DeviceError& error) {
    ended = stop_arm(cell.arm, RunEnd::kStopped, error.what());
  } catch (const FileError& error) {  // of the journal: without it nothing moves, but what stands is reported
    ended = stop_arm(cell.arm, RunEnd::kStopped, error.what());
  } catch (const std::exception& error) {
    report_end(recorder, {RunEnd::kFailed, error.what()});
    throw;
  }
  report_end(recorder, ended);
  return std::move(recorder.result());
}

}  // namespace

RunResult build_resumable(Cell& cell, const Catalogue& catalogue, const RobotModel& robot,
                          const BuildOptions& options, const BuildHooks& hooks, const std::string& folder,
                          bool resumes, const ModelledHook& modelled) {
  std::optional<ResumePoint> before;
  if (resumes) {
    before = read_resume_point(folder, catalogue);
    if (hooks.journal != nullptr) note_resumed(*hooks.journal, *before);
  }
  const auto run_in = [&](Cell& devices) {
    return run_with(
        devices, catalogue, robot, options, hooks,
        [&](Workcell& w, StateWriter& states) {
          const ResumeWriter resume(folder, w.models, w.options, w.seconds, hooks.journal);
          if (!before) resume.begin();
          Known known = before ? observe_again(w, *before, resume, hooks.journal) : observe_first(w, resume);
          return build(w, states, resume, hooks.journal, std::move(known));
        },
        before ? &*before : nullptr, modelled);
  };
  if (resumes) return run_in(cell);  // the tape of the devices ends where the run was broken off
  if (!options.save_states || hooks.states_folder.empty()) return run_in(cell);
  const std::string inputs = hooks.states_folder + kInputsFolder;
  write_start(inputs, cell.layout, catalogue, robot, options, hooks.journal);
  const auto tape = record_devices(inputs);
  TapedDevices taped(cell, *tape);
  Cell devices = taped.cell();
  return run_in(devices);
}

RunResult build_tower(Cell& cell, const Catalogue& catalogue, const RobotModel& robot,
                      const BuildOptions& options, const BuildHooks& hooks) {
  return build_resumable(cell, catalogue, robot, options, hooks, {}, false);
}

FirstStep plan_first_step(Cell& cell, const Catalogue& catalogue, const RobotModel& robot,
                          const BuildOptions& options, const BuildHooks& hooks) {
  const auto read = [&cell] { return cell.arm.state(); };
  ReadOnlyDevices devices(read, cell.camera, cell.clock, cell.layout);
  Cell watched = devices.cell();
  FirstStep first;
  std::vector<PlannedStep> steps;
  first.result = run_with(
      watched, catalogue, robot, options, hooks,
      [&](Workcell& workcell, StateWriter& states) { return look_and_plan(workcell, states, first, steps); });
  first.result.planned = std::move(steps);
  return first;
}

}  // namespace stonestack::stacking
