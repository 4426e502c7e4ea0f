#include "simulated_run.hpp"

#include <filesystem>

#include "cell_input.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/stacking/build_tower.hpp"
#include "version.hpp"

namespace stonestack::apps {
namespace {

/// Does what the run reports stand in the simulated world's own state, with the arm away?
TruthReport judge(const SimulatedCell& world, const RunResult& result) {
  const StandOptions options = tower_bounds();
  const TowerVerdict verdict = world.judge_tower(options);
  TruthReport truth;
  truth.height = verdict.stand.standing;
  truth.stands = verdict.stand.stands && truth.height >= result.height;
  truth.seconds = options.seconds;
  truth.shift = verdict.stand.shift;
  truth.turn = verdict.stand.turn;
  truth.note = verdict.stand.reason;
  return truth;
}

void draw_truth(const Truth& truth, const Catalogue& catalogue, const std::vector<int>& present,
                const CellLayout& layout, const std::string& path) {
  std::vector<PlacedStone> placed;
  for (const int stone : present) placed.push_back({stone, truth.T_W_O[static_cast<std::size_t>(stone)]});
  const auto meshes = drawn_stones(catalogue, placed);
  double top = 0.0;
  for (const auto& item : meshes) {
    const auto box = bounds(transformed(item.mesh, item.T_W_A));
    if ((box.center().head<2>() - layout.site).norm() < 0.15) top = std::max(top, box.max().z());
  }
  write_png(path, draw(meshes, view_of_site(layout.site, top)));
}

}  // namespace

void spread_seed(SimulatedRun& run) {
  run.build.search.seed = run.build.detection.seed = run.build.motion.seed = run.simulation.seed = run.seed;
}

FieldList fields(SimulatedRun& run) {
  return join({fields(run.build), nest("simulation", fields(run.simulation))});
}

namespace {

/// What is known before anything is done; the folder must not hold a run yet.
RunReport open_report(const SimulatedRun& run, const Catalogue& catalogue, const RobotModel& robot,
                      const std::vector<int>& present, const std::string& folder) {
  require(!std::filesystem::exists(folder + "/journal.jsonl"), folder,
          " holds a run already; name another folder with --out, or remove it");
  RunReport report;
  report.version = program_version();
  report.robot = robot.name;
  report.catalogue = catalogue.path;
  report.seed = run.seed;
  SimulatedRun copy = run;
  report.options_text = write_fields(fields(copy));
  for (const int stone : present)
    report.present.push_back(catalogue.stones[static_cast<std::size_t>(stone)].name);
  return report;
}

void build(RunReport& report, Cell cell, const SimulatedRun& run, const Catalogue& catalogue,
           const RobotModel& robot, const std::string& folder) {
  write_file(folder + "/options.yaml", report.options_text);
  Journal journal(folder + "/journal.jsonl");
  report.result = build_tower(cell, catalogue, robot, run.build,
                              {[](const std::string& line) { log_info(line); }, &journal});
}

void build_over_sockets(RunReport& report, SimulatedCell& world, const CellFile& file,
                        const SimulatedRun& run, const Catalogue& catalogue, const RobotModel& robot,
                        const std::string& folder) {
  // The controller knows nothing of the limits of the cell: it is the host that keeps them.
  const SimulatedServers servers(world, read_robot(file.cell.robot), file.servers);
  CellConfig config = file.cell;
  connect_to(servers, config);
  log_info("simulated devices:\n" + servers.text());
  HardwareCell hardware(config);
  hardware.activate_gripper();
  build(report, hardware.cell(), run, catalogue, robot, folder);
}

void close_report(const RunReport& report, const std::string& folder) {
  write_file(folder + "/result.json", run_json(report));
  write_file(folder + "/report.html", run_html(report));
}

}  // namespace

FinishedRun perform(const SimulatedRun& run, const Catalogue& catalogue, const RobotModel& robot,
                    const std::vector<int>& present, const std::string& folder,
                    const SurvivalOptions* survival, const CellFile* file) {
  FinishedRun done;
  RunReport& report = done.report;
  report = open_report(run, catalogue, robot, present, folder);
  log_info(concat("simulated cell, seed ", run.seed, ": ", present.size(), " of ", catalogue.stones.size(),
                  " stones; record in ", folder));
  const CellLayout layout =
      file == nullptr ? CellLayout{} : true_layout(to_layout(file->cell), file->servers);
  SimulatedCell world(catalogue.stones, present, robot, layout, run.simulation);
  if (file == nullptr) {
    build(report, world.cell(), run, catalogue, robot, folder);
  } else {
    build_over_sockets(report, world, *file, run, catalogue, robot, folder);
  }
  if (report.result.end != RunResult::End::kInterrupted) {  // who interrupts does not wait for the judge
    log_info("judging the tower in the true world");
    report.truth = judge(world, report.result);
    if (survival != nullptr) done.survival = world.try_tower(*survival);
  }
  report.picture = folder + "/tower.png";
  draw_truth(world.truth(), catalogue, present, layout, report.picture);
  close_report(report, folder);
  return done;
}

RunReport perform_real(const SimulatedRun& run, const Catalogue& catalogue, const CellFile& file,
                       const std::string& folder) {
  const RobotModel robot = read_cell_robot(file.cell);
  RunReport report = open_report(run, catalogue, robot, {}, folder);
  log_info(concat("cell ", file.path, ": arm at ", file.cell.arm.address, "; record in ", folder));
  HardwareCell hardware(file.cell);
  hardware.activate_gripper();
  build(report, hardware.cell(), run, catalogue, robot, folder);
  const auto& stack = report.result.belief.stack;
  if (!stack.empty()) {
    report.picture = folder + "/tower.png";
    write_png(report.picture,
              draw(drawn_stones(catalogue, stack), view_of_site(to_layout(file.cell).site, 0.3)));
  }
  close_report(report, folder);
  return report;
}

}  // namespace stonestack::apps
