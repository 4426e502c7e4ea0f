#include "simulation/true_view.hpp"

namespace stonestack::simulation {
namespace {

constexpr double kTableHalf = 3.0;  // m

Mesh make_table() {
  Mesh table;
  table.vertices = {{-kTableHalf, -kTableHalf, 0},
                    {kTableHalf, -kTableHalf, 0},
                    {kTableHalf, kTableHalf, 0},
                    {-kTableHalf, kTableHalf, 0}};
  table.faces = {{0, 1, 2}, {0, 2, 3}};
  return table;
}

}  // namespace

SensorModel choose_sensor(const SimulationOptions& options) {
  const SensorModel sensor = make_sensor(options.sensor);
  if (options.sensor_noise) return sensor;
  SensorModel quiet;
  quiet.camera = sensor.camera;
  quiet.unit = sensor.unit;
  quiet.nearest = sensor.nearest;
  quiet.farthest = sensor.farthest;
  return quiet;
}

SeenWorld what_is_seen(const TrueWorld& world) {
  SeenWorld seen;
  for (const StoneIndex i : world.present()) seen.stones.emplace_back(i, world.pose(i));
  for (const auto& box : world.gripper_body().boxes)  // the camera does not see itself
    if (!box.camera) seen.boxes.emplace_back(box.size, box_pose(box, world.gripper_pose()));
  return seen;
}

DepthImage true_view(const SeenWorld& world, const std::vector<Stone>& stones, const Pose& T_W_C,
                     const SensorModel& sensor, Random& random) {
  RayScene scene;
  scene.add(make_table(), Pose::Identity());
  for (const auto& [i, T_W_O] : world.stones) scene.add(at(stones, i).scan, T_W_O);
  for (const auto& [size, T_W_box] : world.boxes) scene.add(make_box(size), T_W_box);
  scene.commit();
  return add_noise(render(scene, sensor.camera, T_W_C), T_W_C, sensor, random);
}

}  // namespace stonestack::simulation
