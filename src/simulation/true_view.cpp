#include "simulation/true_view.hpp"

namespace stonestack {
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

DepthImage true_view(const TrueWorld& world, const std::vector<Stone>& stones, const Pose& T_W_C,
                     const SensorModel& sensor, Random& random) {
  RayScene scene;
  scene.add(make_table(), Pose::Identity());
  for (const int i : world.present()) scene.add(stones[static_cast<std::size_t>(i)].scan, world.pose(i));
  for (const auto& box : world.hand_model().boxes) scene.add(make_box(box.size), box_pose(box, world.hand()));
  scene.commit();
  return add_noise(render(scene, sensor.camera, T_W_C), T_W_C, sensor, random);
}

}  // namespace stonestack
