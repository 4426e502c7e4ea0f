// Plans grasp and motion for one stone: turned by 40 deg and moved to the site.
#include <cstdio>

#include "stonestack/stacking/observe.hpp"
#include "stonestack/stonestack.hpp"

int main() try {
  const stonestack::Catalogue catalogue = stonestack::read_catalogue(stonestack::data_path("stones"));
  const stonestack::RobotModel robot = stonestack::read_robot("ur10");
  const stonestack::CellLayout layout;

  // The stone lies where a simulated scene shows it.
  const auto scene =
      stonestack::simulation::render_scene(catalogue.stones, {stonestack::StoneIndex(2)}, layout);
  const stonestack::PlacedStone stone = scene.stones.front();
  stonestack::stacking::Arrangement arrangement;
  arrangement.loose.push_back(stone);

  stonestack::Pose T_W_O = stone.T_W_O;  // the target: the same attitude at the site
  T_W_O.translation().head<2>() = layout.site;
  T_W_O.rotate(Eigen::AngleAxisd(0.7, T_W_O.linear().transpose() * Eigen::Vector3d::UnitZ()));

  const auto planning = stonestack::stacking::make_planning_scene(layout, robot, catalogue, arrangement);
  const auto task = stonestack::stacking::make_task(catalogue, arrangement, stone.stone, T_W_O,
                                                    stonestack::stacking::home_joints());
  const auto plan = stonestack::plan_pick_and_place(planning, task);
  if (plan.status != stonestack::motion::PickAndPlacePlan::Status::kPlanned) {
    std::printf("no plan: %s\n", plan.reason.c_str());
    return 6;
  }
  for (const auto& step : plan.steps) std::printf("%s\n", step.name.c_str());
  std::printf("%.1f s of motion\n", plan.seconds);
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "%s\n", error.what());
  return 1;
}
