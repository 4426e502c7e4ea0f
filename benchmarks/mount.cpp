// How well does the arm measure its camera's mount by itself? The simulated camera sits where the layout has
// it; the calibration starts from a mount that is some centimetres and degrees off.
#include <memory>
#include <vector>

#include "bench.hpp"
#include "core/constants.hpp"
#include "core/quantile.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/check_cell.hpp"
#include "stonestack/stone/catalogue.hpp"

namespace stonestack::bench {
namespace {

struct MountBench {
  int runs = 20, seed = 1, stations = 15;
  std::string cell = "lab";
  std::vector<double> block;
  double shift = 0.020, turn = 5.0;  // m, deg
};

struct MountErrors {
  std::vector<double> millimetres, degrees;
  void add(const PoseDifference& off) {
    millimetres.push_back(1e3 * off.translation);
    degrees.push_back(off.angle / kDegree);
  }
  [[nodiscard]] std::vector<TableValue> row(const std::string& name) const {
    return {name,
            quantile(millimetres, 0.5),
            quantile(millimetres, 0.95),
            quantile(millimetres, 1.0),
            quantile(degrees, 0.5),
            quantile(degrees, 0.95),
            quantile(degrees, 1.0)};
  }
};

void measure_mounts(const MountBench& bench, Results& results) {
  results.settings({{"runs", bench.runs},
                    {"cell", bench.cell},
                    {"target", bench.block.empty() ? "stone" : "block"},
                    {"stations", bench.stations},
                    {"shift_mm", 1e3 * bench.shift},
                    {"turn_deg", bench.turn},
                    {"seed", bench.seed}});
  const Catalogue targets = bench.block.empty()
                                ? read_catalogue(data_path("stones"))
                                : block_target({bench.block[0], bench.block[1], bench.block[2]});
  const RobotModel robot = read_robot("ur10");
  const CellLayout truth;
  MountErrors before, after;
  std::vector<double> seconds;
  std::vector<std::pair<int, std::string>> failures;
  for (int run = 0; run < bench.runs; ++run) {
    throw_if_interrupted();
    SimulationOptions options = options_of_cell(bench.cell);
    options.seed = 1000 * bench.seed + run;
    options.hand_eye_translation = options.hand_eye_rotation = 0.0;  // drawn here instead
    Random random = Random::stream(static_cast<std::uint64_t>(options.seed), "mount");
    const StoneIndex target(run % static_cast<int>(targets.stones.size()));
    SimulatedCell world(targets.stones, {target}, robot, truth, options);
    Cell devices = world.cell();
    CellLayout assumed = truth;
    assumed.T_T_C.translation() += random.uniform(0.0, bench.shift) * random.unit_vector();
    assumed.T_T_C.linear() =
        assumed.T_T_C.linear() *
        Eigen::AngleAxisd(random.uniform(0.0, bench.turn) * kDegree, random.unit_vector()).matrix();
    Cell cell{devices.arm, devices.gripper, devices.force_torque, devices.camera, devices.clock, assumed};
    const Pose T_F_C = truth.T_F_T * truth.T_T_C;
    const double start = devices.clock.now();
    try {
      const HandEyeFile stations =
          capture_stations(cell, robot, targets, {bench.stations, at(targets.stones, target).name});
      const HandEyeCalibration done = calibrate_stations(stations);
      if (!done.uncertainty.empty()) throw DeviceError("calibration", done.uncertainty, "nothing is written");
      before.add(difference(assumed.T_F_T * assumed.T_T_C, T_F_C));
      after.add(difference(done.chosen.T_A_C, T_F_C));
      seconds.push_back(devices.clock.now() - start);
    } catch (const DeviceError& error) {
      failures.emplace_back(run, error.what());
    }
  }
  results.table("errors of the mount", {{"mount"},
                                        {"median_mm", 2},
                                        {"q95_mm", 2},
                                        {"worst_mm", 2},
                                        {"median_deg", 3},
                                        {"q95_deg", 3},
                                        {"worst_deg", 3}});
  results.row(before.row("before"));
  results.row(after.row("after"));
  results.table("no result", {{"run"}, {"why"}});
  for (const auto& [run, why] : failures) results.row({run, why});
  results.figures(
      "totals",
      {{"runs", bench.runs}, {"no_result", failures.size()}, {"median_s", quantile(seconds, 0.5), 0}});
}

}  // namespace

void add_mount(CLI::App& app) {
  auto bench = std::make_shared<MountBench>();
  CLI::App* sub = app.add_subcommand(
      "mount", "The camera's mount as `calibrate --capture` measures it in simulated cells");
  sub->add_option("--runs", bench->runs, "Mounts that are drawn")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
  sub->add_option("--seed", bench->seed)->check(CLI::Range(0, 2000000))->capture_default_str();
  sub->add_option("--stations", bench->stations, "Stations of each")
      ->check(CLI::Range(4, 100))
      ->capture_default_str();
  sub->add_option("--cell", bench->cell, "Errors of the simulated cell")
      ->check(CLI::IsMember({"ideal", "mild", "lab", "paper", "hard"}))
      ->capture_default_str();
  sub->add_option("--block", bench->block,
                  "Sides of a block as the target, metres (default: the six stones in turn)")
      ->delimiter(',')
      ->expected(3);
  sub->add_option("--shift", bench->shift, "Greatest error of position that it starts from [m]")
      ->check(CLI::Range(0.0, 0.2))
      ->capture_default_str();
  sub->add_option("--turn", bench->turn, "Greatest error of attitude that it starts from [deg]")
      ->check(CLI::Range(0.0, 45.0))
      ->capture_default_str();
  sub->footer(
      "Examples:\n  stonestack-bench mount --runs 60\n"
      "  stonestack-bench mount --runs 60 --block 0.12,0.08,0.05 --cell hard");
  measure_by(*sub, [bench](Results& results) { measure_mounts(*bench, results); });
}

}  // namespace stonestack::bench
