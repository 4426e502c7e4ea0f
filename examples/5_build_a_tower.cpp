// Builds a tower of two in the simulated cell and lets the cell's truth judge it.
#include <cstdio>

#include "stonestack/stonestack.hpp"

int main() try {
  const stonestack::Catalogue catalogue = stonestack::read_catalogue(stonestack::data_path("stones"));
  const stonestack::RobotModel robot = stonestack::read_robot("ur10");
  stonestack::SimulatedCell world(catalogue.stones, stonestack::first_stones(2), robot,
                                  stonestack::CellLayout{});

  stonestack::stacking::BuildHooks hooks;
  hooks.listener = [&](const stonestack::stacking::Event& event) {
    const std::string line = stonestack::stacking::to_text(event, catalogue);
    if (!line.empty()) std::printf("%s\n", line.c_str());
  };
  stonestack::Cell cell = world.cell();
  const stonestack::RunResult result = stonestack::build_tower(cell, catalogue, robot, {}, hooks);
  std::printf("%d stones stand: %s\n", result.height, result.ended.c_str());
  return result.height == 2 ? 0 : 6;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
