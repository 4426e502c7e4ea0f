#include "report/perform_run.hpp"

#include <algorithm>
#include <exception>
#include <functional>
#include <limits>

#include "hardware/cell_config.hpp"
#include "hardware/read_only_devices.hpp"
#include "report/drawn_arm.hpp"
#include "report/live_run.hpp"
#include "report/picture.hpp"
#include "report/plan_preview.hpp"
#include "report/text.hpp"
#include "stacking/journal.hpp"
#include "stacking/model_field.hpp"
#include "stacking/resume_point.hpp"
#include "stacking/stepped_devices.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/report/record_run.hpp"
#include "stonestack/report/results.hpp"
#include "stonestack/search/plan_wall.hpp"
#include "stonestack/stacking/build_tower.hpp"
#include "stonestack/stacking/observe.hpp"

namespace stonestack::report {
namespace {

constexpr double kPreviewPeriod = 0.1;  // s between clearances of a dry run

/// Opens the report with what is known before anything is done.
RunReport open_report(const SimulatedRun& run, const Catalogue& catalogue, const RobotModel& robot,
                      const std::vector<StoneIndex>& present, const std::string& version) {
  RunReport report;
  report.version = version;
  report.robot = robot.name;
  report.catalogue = catalogue.path;
  report.seed = run.seed;
  if (!run.build.wall.empty()) report.structure = read_wall_target(run.build.wall).task ? "bridge" : "wall";
  SimulatedRun copy = run;
  report.options_text = write_fields(fields(copy));
  for (const StoneIndex stone : present) report.present.push_back(catalogue[stone].name);
  return report;
}

/// A line for a person, or else the journal's line for who wants to see all.
void log_event(const Event& event, const Catalogue& catalogue) {
  if (const std::string line = to_text(event, catalogue); !line.empty()) return log_info(line);
  if (const auto [kind, data] = to_record(event, catalogue); !kind.empty()) log_debug(kind + " " + data);
}

/// Shows how far the tower or wall has come.
class RunProgress {
 public:
  RunProgress(const BuildOptions& options, std::size_t stones) {
    progress_.what = options.wall.empty() ? "tower" : "wall";
    if (options.max_stones > 0) asked_ = options.max_stones;
    progress_.total = std::min(static_cast<double>(stones), asked_);
  }
  void hear(const Event& event) {
    if (const auto* seen = std::get_if<Observed>(&event)) {
      progress_.done = static_cast<double>(seen->world.stack.size());
      const double seen_now = progress_.done + static_cast<double>(seen->world.loose.size());
      progress_.total = std::max(progress_.total, std::min(seen_now, asked_));
    } else if (const auto* searched = std::get_if<SearchedAtFriction>(&event); searched && searched->found) {
      progress_.best = format("%.1f expected", searched->expected);
    }
    progress_.seconds = watch_.seconds();
    show_progress(progress_);
  }

 private:
  Progress progress_{"", 0.0, 0.0, "stones", "", 0.0};
  double asked_ = std::numeric_limits<double>::infinity();  ///< stones, by the user
  Stopwatch watch_;
};

/// Adds the clearance of each step, where it is known what each may touch.
void measure_clearance(FirstStep& first) {
  if (!first.task || first.plan.steps.size() != first.result.planned.size()) return;
  for (const PlanMoment& moment : preview(first.scene, *first.task, first.plan, kPreviewPeriod)) {
    auto& least = first.result.planned[moment.step].clearance;
    least = std::min(least.value_or(moment.clearance), moment.clearance);
  }
}

/// The stones that the planner knows: those of a catalogue, or once they are modelled those that nobody
/// scanned.
struct KnownStones {
  const Catalogue& given;
  std::optional<Catalogue> modelled;
  [[nodiscard]] const Catalogue& catalogue() const { return modelled ? *modelled : given; }
};

StoneModelReport report_of(const Stone& stone, const stacking::ModelledStone& made) {
  return {made.name,       made.turned,           made.views, made.seen_share, made.sigma,
          stone.mass.mass, made.mass.has_value(), made.note};
}

ModellingReport report_of(const stacking::ModelledField& field, const std::string& folder) {
  ModellingReport report{folder, field.views,   field.seconds, field.apart_before, field.apart_after,
                         {},     field.left_out};
  for (std::size_t k = 0; k < field.stones.size(); ++k)
    report.stones.push_back(report_of(field.catalogue.stones[k], field.stones[k]));
  return report;
}

/// Models what lies in the field, and keeps it as a catalogue. Ends the run where that is not possible; true
/// where it may go on.
bool model_unseen(RunReport& report, Cell cell, const SimulatedRun& run, const RobotModel& robot,
                  const RunMode& mode, const std::string& folder, Journal& journal, KnownStones& stones) {
  const auto end_run = [&](RunResult::End end, const std::string& why) {
    report.result.end = end;
    report.result.ended = why;
    try {
      cell.arm.stop();
    } catch (const Error& problem) {
      log_warning(problem.what());
    }
    return false;
  };
  try {
    stacking::ModelFieldOptions options;
    options.motion = run.build.motion;
    options.modelling.segment.seed = run.build.detection.seed;
    options.stone.friction = run.build.search.friction;
    options.detection = run.build.detection;
    const Catalogue known = mode.known.empty() ? Catalogue{} : read_catalogue(mode.known);
    options.known = &known;
    cell.layout.linkage = run.build.linkage;
    std::optional<stacking::SteppedDevices> stepped;
    if (mode.before_motion) stepped.emplace(cell, robot, mode.before_motion, &journal);
    Cell used = stepped ? stepped->cell() : cell;
    stacking::ModelledField field = stacking::model_field(used, robot, options, &journal);
    report.modelling = report_of(field, folder);
    for (const std::string& left : field.left_out) log_info(left);
    for (const Stone& stone : field.catalogue.stones) write_stone(folder, stone);
    report.catalogue = folder;
    stones.modelled = std::move(field.catalogue);
    stones.modelled->path = folder;
    if (field.interrupted)
      return end_run(RunResult::End::kInterrupted, "interrupted while the stones were modelled");
    if (!field.stopped.empty()) return end_run(RunResult::End::kStopped, field.stopped);
    if (stones.modelled->stones.empty())
      return end_run(
          RunResult::End::kNothingSeen,
          "no stone was modelled" + (field.left_out.empty() ? std::string(": nothing lies in the field")
                                                            : ": " + field.left_out.front()));
    log_info(concat(stones.modelled->stones.size(),
                    known.stones.empty() ? " stones modelled" : " stones modelled or recognised", " in ",
                    field.seconds, " s of the robot, kept in ", folder));
    return true;
  } catch (const Interrupted&) {
    return end_run(RunResult::End::kInterrupted, "interrupted while the stones were modelled");
  } catch (const DeviceError& problem) {
    return end_run(RunResult::End::kStopped, problem.what());
  } catch (const FileError& problem) {  // of the journal or the catalogue: without them nothing moves
    return end_run(RunResult::End::kStopped, problem.what());
  }
}

RunResult perform_in(Cell& cell, const SimulatedRun& run, const Catalogue& catalogue, const RobotModel& robot,
                     const BuildHooks& hooks, const RunMode& mode, const stacking::ModelledHook& modelled) {
  if (!mode.dry)
    return stacking::build_resumable(cell, catalogue, robot, run.build, hooks,
                                     mode.keeps ? hooks.states_folder : std::string(), mode.resumes,
                                     modelled);
  FirstStep first = plan_first_step(cell, catalogue, robot, run.build, hooks);
  measure_clearance(first);
  return std::move(first.result);
}

/// Everything that a run is performed with, beside its devices.
struct Performance {
  const SimulatedRun& run;
  const RobotModel& robot;
  const std::string& folder;
  const LiveView& view;
  const RunMode& mode;
  CellLayout layout;  ///< as the page shows it
  KnownStones stones;
  std::optional<LiveRun> live = {};  ///< from where the stones are known
};

void build(RunReport& report, Cell cell, Performance& p) {
  write_file(p.folder + "/options.yaml", report.options_text);
  Journal journal(p.folder + "/journal.jsonl");
  log_info("record in " + p.folder);
  if (p.run.build.unseen) {
    const std::string stones = p.mode.save_catalogue.empty() ? p.folder + "/stones" : p.mode.save_catalogue;
    if (p.mode.resumes) {
      p.stones.modelled = read_catalogue(stones);
      report.catalogue = stones;
    } else if (!model_unseen(report, cell, p.run, p.robot, p.mode, stones, journal, p.stones)) {
      return;
    }
    if (p.mode.only_model) {
      report.result.end = RunResult::End::kHeightReached;  // none was asked for
      report.result.ended = "the stones are modelled";
      return;
    }
  }
  const Catalogue& catalogue = p.stones.catalogue();
  std::optional<Catalogue> begun;  // a run that may add stones begins with these
  if (p.stones.modelled) begun = catalogue;
  const auto keep_stone = [&](const Stone& stone, const stacking::ModelledStone& made) {
    write_stone(catalogue.path, stone);
    p.stones.modelled->stones.push_back(stone);
    if (report.modelling) report.modelling->stones.push_back(report_of(stone, made));
  };
  p.live.emplace(p.view, report, catalogue, p.robot, p.layout);
  RunProgress progress(p.run.build, report.present.empty() ? catalogue.stones.size() : report.present.size());
  Cell watched = p.live->watched(cell);
  const BuildHooks hooks{[&](const Event& event) {
                           log_event(event, catalogue);
                           p.live->hear(event);
                           progress.hear(event);
                         },
                         &journal, p.folder, p.mode.before_motion};
  report.result = perform_in(watched, p.run, begun ? *begun : catalogue, p.robot, hooks, p.mode,
                             p.stones.modelled ? keep_stone : stacking::ModelledHook());
  clear_progress();
}

/// Connects the devices of a cell. A dry run only reads arm and camera.
void build_on_devices(RunReport& report, const CellConfig& config, Performance& p) {
  if (p.mode.dry) {
    ReadOnlyHardware hardware(config);
    return build(report, hardware.cell(), p);
  }
  HardwareCell hardware(config);
  report.safety_checksum = hardware.safety_checksum();
  if (p.mode.before_motion && hardware.activates_gripper() &&
      !p.mode.before_motion({"activate the gripper, whose fingers open and close fully"}))
    throw Interrupted();
  if (p.mode.resumes && hardware.activates_gripper())
    throw DeviceError("gripper",
                      "is not active any more: it would open fully, and drop a stone that it holds",
                      "take what it holds out of it, activate it at the pendant, then resume");
  hardware.activate_gripper();
  build(report, hardware.cell(), p);
}

void build_over_sockets(RunReport& report, SimulatedCell& world, const CellFile& file, Performance& p) {
  // The controller knows nothing of the limits of the cell: it is the host that keeps them.
  const SimulatedServers servers(world, read_robot(file.cell().robot), file.servers());
  CellConfig config = file.cell();
  connect_to(servers, config);
  log_info("simulated devices:\n" + servers.text());
  build_on_devices(report, config, p);
}

/// Draws the cell as the run left it: the stones and the arm.
void draw_cell(const std::string& path, const RunResult& result, const Catalogue& catalogue,
               const RobotModel& robot, const CellLayout& layout, const std::vector<PlacedStone>& stones) {
  std::vector<DrawnMesh> meshes = drawn_stones(catalogue, stones);
  if (!result.timeline.samples.empty()) {
    const MotionSample& last = result.timeline.samples.back();
    const auto arm =
        drawn_arm(robot, stacking::gripper_of(layout), layout.T_W_R, layout.T_F_T, {last.q, last.opening});
    meshes.insert(meshes.end(), arm.begin(), arm.end());
  }
  View view;
  view.p_W_target = {0.75 * layout.site.x(), 0.4 * layout.site.y(), 0.26};
  view.p_W_eye = view.p_W_target + Eigen::Vector3d(1.25, -1.25, 0.61);
  write_png(path, draw(meshes, view));
}

/// Keeps what goes wrong first in `problem` instead of throwing it: the tower stands, and the caller goes on
/// to report it.
void attempt(std::string& problem, const std::function<void()>& write) {
  try {
    write();
  } catch (const std::exception& error) {
    if (problem.empty()) problem = error.what();
  }
}

/// Stones and robot, of which the report shows meshes and arm.
struct Shown {
  const Catalogue& catalogue;
  const RobotModel& robot;
};

void write_result(std::string& problem, const RunReport& report, const std::string& folder) {
  attempt(problem, [&] { write_file(folder + "/result.json", run_json(report)); });
}

using DrawPicture = std::function<void(const std::string& path)>;

/// Writes what cannot be made again first, the largest last: a disk that fills up costs picture and report.
void close_report(RecordedRun& done, const Shown& shown, const std::string& folder,
                  const DrawPicture& draw_picture) {
  write_result(done.unwritten, done.report, folder);
  if (draw_picture) {
    const std::string picture = folder + "/tower.png";
    attempt(done.unwritten, [&] {
      draw_picture(picture);
      done.report.picture = picture;
    });
    if (!done.report.picture.empty()) write_result(done.unwritten, done.report, folder);
  }
  attempt(done.unwritten,
          [&] { write_file(folder + "/report.html", run_html(done.report, shown.catalogue, shown.robot)); });
}

}  // namespace

RecordedRun perform(const SimulatedRun& run, const Catalogue& catalogue, const RobotModel& robot,
                    const std::vector<StoneIndex>& present, const RecordFolder& folder,
                    const std::string& version, const SurvivalOptions* survival, const CellFile* file,
                    const LiveView& view, const RunMode& mode) {
  RecordedRun done;
  done.folder = folder.path();
  RunReport& report = done.report;
  report = open_report(run, catalogue, robot, present, version);
  report.cell = run.simulation.cell;
  report.cell_changes = changed_in_cell(run.simulation);
  log_info(concat("simulated cell ", run.simulation.cell, ", seed ", run.seed, ": ", present.size(), " of ",
                  catalogue.stones.size(), " stones"));
  CellLayout layout = with_option_gripper(
      file == nullptr ? CellLayout{} : true_layout(to_layout(file->cell()), file->servers()),
      run.build.gripper, file != nullptr);
  layout.linkage = run.build.linkage;
  SimulatedCell world(catalogue.stones, present, robot, layout, run.simulation,
                      mode.resumes ? folder.path() : std::string());
  if (mode.keeps) world.keep_in(folder.path());
  Performance p{run, robot, done.folder, view, mode, layout, {catalogue, {}}};
  if (file == nullptr) {
    build(report, world.cell(), p);
  } else {
    build_over_sockets(report, world, *file, p);
  }
  if (!mode.only_model && report.result.end != RunResult::End::kInterrupted &&
      !mode.dry) {      // who interrupts does not wait for the judge
    std::string later;  // what cannot be written now is tried, and told of, again below
    write_result(later, report, folder.path());
    log_info("judging in the true world what stands");
    try {
      report.truth = judge_run(world, report.result);
      if (survival != nullptr)
        done.survival = try_tower(
            world, *survival, tower_bounds(),
            report.result.wall ? stacking::at_rest(report.result.world).stack : std::vector<PlacedStone>());
    } catch (const Interrupted&) {  // what was built is reported, without a verdict
      log_info("interrupted before the tower was judged");
    }
  }
  close_report(done, {p.stones.catalogue(), robot}, folder.path(), [&](const std::string& path) {
    const Truth truth = world.truth();
    std::vector<PlacedStone> stones;
    for (const StoneIndex stone : present) stones.push_back({stone, at(truth.T_W_O, stone)});
    draw_cell(path, report.result, catalogue, robot, layout, stones);
  });
  if (p.live) p.live->finish(report);
  return done;
}

RecordedRun perform_real(const SimulatedRun& run, const Catalogue& catalogue, const CellFile& file,
                         const RecordFolder& folder, const std::string& version, const LiveView& view,
                         const RunMode& mode) {
  const RobotModel robot = read_cell_robot(file.cell());
  RecordedRun done;
  done.folder = folder.path();
  done.report = open_report(run, catalogue, robot, {}, version);
  log_info(concat("cell ", file.path, ": arm at ", file.cell().arm.address));
  Performance p{run, robot, done.folder, view, mode, to_layout(file.cell()), {catalogue, {}}};
  build_on_devices(done.report, file.cell(), p);
  const Arrangement seen = at_rest(done.report.result.world);
  auto stack = seen.stack;
  if (mode.dry) stack.insert(stack.end(), seen.loose.begin(), seen.loose.end());
  const auto draw_stack = [&](const std::string& path) {
    CellLayout layout = to_layout(file.cell());
    layout.linkage = run.build.linkage;
    draw_cell(path, done.report.result, p.stones.catalogue(), robot, layout, stack);
  };
  close_report(done, {p.stones.catalogue(), robot}, folder.path(),
               stack.empty() ? DrawPicture() : draw_stack);
  if (p.live) p.live->finish(done.report);
  return done;
}

}  // namespace stonestack::report
