#include <ctime>
#include <filesystem>
#include <iostream>
#include <memory>

#include "commands.hpp"
#include "common_options.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/report/run_report.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/build_tower.hpp"

namespace stonestack::apps {
namespace {

struct RunCommand {
  CommonOptions common;
  std::string robot = "ur10";
  std::string out;
  int per_run = 4;
  BuildOptions build;
  SimulationOptions simulation;
};

FieldList all_fields(RunCommand& command) {
  return join({fields(command.build), nest("simulation", fields(command.simulation))});
}

/// runs/20261121-143000-seed1, not yet there.
std::string run_folder(const RunCommand& command) {
  if (!command.out.empty()) {
    require(!std::filesystem::exists(command.out + "/journal.jsonl"), command.out,
            " holds a run already; name another folder with --out, or remove it");
    return command.out;
  }
  const std::time_t now = std::time(nullptr);
  char stamp[32];
  std::strftime(stamp, sizeof stamp, "%Y%m%d-%H%M%S", std::localtime(&now));
  std::string folder = concat("runs/", stamp, "-seed", command.common.seed);
  for (int n = 2; std::filesystem::exists(folder); ++n)
    folder = concat("runs/", stamp, "-seed", command.common.seed, "-", n);
  return folder;
}

/// The judge's view: does what the run reports stand in the simulated world's own state, with the arm away?
TruthReport judge(const SimulatedCell& world, const RunResult& result) {
  const StandOptions options{.seconds = 60.0, .largest_shift = 0.002};
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

ExitCode exit_code(const RunResult& result) {
  switch (result.end) {
    case RunResult::End::kAllPlaced:
    case RunResult::End::kHeightReached:
      return ExitCode::kDone;
    case RunResult::End::kNothingSeen:
      return ExitCode::kNothingDetected;
    case RunResult::End::kNoPose:
      return result.height > 1 ? ExitCode::kDone : ExitCode::kNoStablePose;
    case RunResult::End::kNoPlan:
    case RunResult::End::kPlacementFailed:
      return ExitCode::kExecutionFailed;
    case RunResult::End::kStopped:
      return ExitCode::kSafetyStop;
    case RunResult::End::kInterrupted:
      return ExitCode::kInterrupted;
  }
  return ExitCode::kInternal;
}

void run(RunCommand& command) {
  command.common.begin();
  command.build.search.seed = command.build.detection.seed = command.build.motion.seed =
      command.simulation.seed = command.common.seed;
  command.common.settings.apply(all_fields(command));
  const RobotModel robot = read_robot(command.robot);
  const Catalogue catalogue = command.common.read();
  const auto present = draw_stones(catalogue, command.per_run, command.common.seed);

  RunReport report;
  report.robot = robot.name;
  report.catalogue = catalogue.path;
  report.seed = command.common.seed;
  report.options_text = write_fields(all_fields(command));
  for (const int stone : present)
    report.present.push_back(catalogue.stones[static_cast<std::size_t>(stone)].name);

  const std::string folder = run_folder(command);
  write_file(folder + "/options.yaml", report.options_text);
  Journal journal(folder + "/journal.jsonl");
  log_info(concat("simulated cell, seed ", command.common.seed, ": ", present.size(), " of ",
                  catalogue.stones.size(), " stones; record in ", folder));
  SimulatedCell world(catalogue.stones, present, robot, CellLayout{}, command.simulation);
  Cell cell = world.cell();
  report.result = build_tower(cell, catalogue, robot, command.build,
                              {[](const std::string& line) { log_info(line); }, &journal});
  log_info("judging the tower in the true world");
  report.truth = judge(world, report.result);
  report.picture = folder + "/tower.png";
  draw_truth(world.truth(), catalogue, present, cell.layout, report.picture);
  const std::string json = run_json(report);
  write_file(folder + "/result.json", json);
  write_file(folder + "/report.html", run_html(report));

  std::cerr << run_table(report) << "picture: " << report.picture << "\nreport:  " << folder
            << "/report.html\n";
  if (command.common.json) std::cout << json;
  if (const ExitCode code = exit_code(report.result); code != ExitCode::kDone)
    throw Error(report.result.ended, code);
}

}  // namespace

void add_run(CLI::App& app) {
  auto command = std::make_shared<RunCommand>();
  CLI::App* sub = app.add_subcommand("run", "Build a tower: observe, search, plan, place, observe again");
  sub->add_option("--robot", command->robot,
                  "ur3, ur5, ur10, ur3e, ur5e, ur10e, ur16e or a URDF with UR kinematics")
      ->capture_default_str();
  sub->add_option("--per-run", command->per_run, "How many stones of the catalogue lie in the field")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  sub->add_option("--height", command->build.most_stones, "Stop at this height (0: all stones)")
      ->check(CLI::Range(0, 100));
  sub->add_option("--method", command->build.search.method, "Pose search: default or paper")
      ->check(CLI::IsMember({"default", "paper"}))
      ->capture_default_str();
  sub->add_option("--out", command->out,
                  "Folder for journal, options, picture and report (default: runs/<time>-<seed>)");
  command->common.register_on(*sub);
  sub->footer(
      "Without hardware the tower is built in a simulated cell that keeps its truth to itself.\n"
      "Examples:\n"
      "  stonestack run --robot ur10\n"
      "  stonestack run --robot ur10 --seed 7 --per-run 6 --json > result.json\n"
      "  stonestack run --catalogue rocks --set search.friction=0.3 --set simulation.friction=0.4");
  sub->callback([command] { run(*command); });
}

}  // namespace stonestack::apps
