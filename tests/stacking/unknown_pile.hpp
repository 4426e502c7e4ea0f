#pragma once
#include <utility>
#include <vector>

#include "rooms.hpp"
#include "stacking/workcell.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/simulation/simulated_cell.hpp"

namespace stonestack::test {

/// A cell at whose site limestone_4 lies upon limestone_2, and a program that has models of some stones only.
struct UnknownPile {
  Catalogue truth = read_catalogue(data_path("stones"));
  RobotModel robot = read_robot("ur10");
  simulation::SimulatedCell cell{
      truth.stones, {1_stone, 2_stone, 3_stone}, robot, CellLayout{}, simulation_options()};
  Pose T_W_lower = at_site(0.03), T_W_upper = at_site(0.10);
  Catalogue known;
  BuildOptions options;
  stacking::Models models;
  DetectionModels detection;
  StageSeconds seconds;
  stacking::Workcell workcell;

  /// @param stones of the catalogue, whose models the program has, in this order
  explicit UnknownPile(const std::vector<StoneIndex>& stones)
      : known(part_of(truth, stones)),
        models(stacking::make_models(known, robot, CellLayout{})),
        detection(known.stones, options.detection),
        workcell{placed(), models, detection, options, seconds, [](const Event&) {}, {}} {}

  /// The world by a view, when a tower was begun and `stack` is expected of it.
  [[nodiscard]] WorldEstimate observed(std::vector<StoneEstimate> stack = {}, bool new_top = false) {
    stacking::Expectation expected;
    expected.friction = stacking::make_memory(options).friction;
    expected.was_built = true;
    expected.new_top = new_top;
    expected.stack = std::move(stack);
    return observe(workcell, expected, [](const WorldEstimate&) {}).world;
  }

  /// Both stones, to where no view shows them.
  void take_away() {
    cell.place(1_stone, make_pose({-0.6, -0.6, 0.05}));
    cell.place(3_stone, make_pose({-0.6, -0.4, 0.05}));
  }

 private:
  Cell placed() {
    cell.place(1_stone, T_W_lower);
    cell.place(3_stone, T_W_upper);
    return cell.cell();
  }
  static Pose at_site(double z) {
    const Eigen::Vector2d site = CellLayout{}.site;
    return make_pose({site.x(), site.y(), z});
  }
  static Catalogue part_of(const Catalogue& all, const std::vector<StoneIndex>& stones) {
    Catalogue part;
    for (const StoneIndex stone : stones) part.stones.push_back(all[stone]);
    return part;
  }
  static simulation::SimulationOptions simulation_options() {
    simulation::SimulationOptions options;
    options.seed = 5;
    options.clearance = 0.02;
    return options;
  }
};

}  // namespace stonestack::test
