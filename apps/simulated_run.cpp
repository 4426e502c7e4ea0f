#include "simulated_run.hpp"

#include <filesystem>

#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/stacking/build_tower.hpp"

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

FinishedRun perform(const SimulatedRun& run, const Catalogue& catalogue, const RobotModel& robot,
                    const std::vector<int>& present, const std::string& folder,
                    const SurvivalOptions* survival) {
  require(!std::filesystem::exists(folder + "/journal.jsonl"), folder,
          " holds a run already; name another folder with --out, or remove it");
  FinishedRun done;
  RunReport& report = done.report;
  report.robot = robot.name;
  report.catalogue = catalogue.path;
  report.seed = run.seed;
  SimulatedRun copy = run;
  report.options_text = write_fields(fields(copy));
  for (const int stone : present)
    report.present.push_back(catalogue.stones[static_cast<std::size_t>(stone)].name);
  log_info(concat("simulated cell, seed ", run.seed, ": ", present.size(), " of ", catalogue.stones.size(),
                  " stones; record in ", folder));
  SimulatedCell world(catalogue.stones, present, robot, CellLayout{}, run.simulation);
  write_file(folder + "/options.yaml", report.options_text);
  Journal journal(folder + "/journal.jsonl");
  Cell cell = world.cell();
  report.result = build_tower(cell, catalogue, robot, run.build,
                              {[](const std::string& line) { log_info(line); }, &journal});
  if (report.result.end != RunResult::End::kInterrupted) {  // who interrupts does not wait for the judge
    log_info("judging the tower in the true world");
    report.truth = judge(world, report.result);
    if (survival != nullptr) done.survival = world.try_tower(*survival);
  }
  report.picture = folder + "/tower.png";
  draw_truth(world.truth(), catalogue, present, cell.layout, report.picture);
  write_file(folder + "/result.json", run_json(report));
  write_file(folder + "/report.html", run_html(report));
  return done;
}

}  // namespace stonestack::apps
