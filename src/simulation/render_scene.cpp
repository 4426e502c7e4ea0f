#include "stonestack/simulation/simulated_cell.hpp"

#include <cmath>

#include "core/constants.hpp"
#include "simulation/foreign_object.hpp"
#include "simulation/scatter.hpp"
#include "simulation/true_shape.hpp"
#include "simulation/true_view.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/geometry/cloud.hpp"
#include "stonestack/stone/scene_file.hpp"

namespace stonestack::simulation {
namespace {

// Optical frame that looks from `tilt` off the vertical at a point on the table.
Pose look_at(const Eigen::Vector2d& target, double distance, double tilt, double azimuth) {
  const Eigen::Vector3d away(std::sin(tilt) * std::cos(azimuth), std::sin(tilt) * std::sin(azimuth),
                             std::cos(tilt));
  const Eigen::Vector3d z = -away;
  const Eigen::Vector3d x = Eigen::Vector3d(-std::sin(azimuth), std::cos(azimuth), 0);
  Pose T_W_C = Pose::Identity();
  T_W_C.linear() << x, z.cross(x), z;
  T_W_C.translation() = Eigen::Vector3d(target.x(), target.y(), 0) + distance * away;
  return T_W_C;
}

}  // namespace

FieldList fields(SceneOptions& o) {
  return {field("distance", o.distance, {0.2, 3.0}, "m", "from the camera to the middle of the field"),
          field("tilt", o.tilt, {0.0, 1.4}, "rad", "of the camera's axis off the vertical")};
}

SimulatedScene render_scene(const std::vector<Stone>& stones, const std::vector<StoneIndex>& present,
                            const CellLayout& layout, const SceneOptions& options) {
  const auto seed = static_cast<std::uint64_t>(options.simulation.seed);
  std::vector<Stone> real = as_they_are(stones, options.simulation);
  std::vector<StoneIndex> all = present;
  for (const Stone& object : make_foreign_objects(options.simulation)) {
    all.emplace_back(real.size());
    real.push_back(object);
  }
  TrueWorld world(real, all, make_robotiq_3f(), options.simulation,
                  {TrueTable(options.simulation, layout.field_centre), options.simulation.foreign_objects});
  GripperPose away;
  away.T_W_T = make_pose(Eigen::Vector3d(0, 0, 100.0));
  world.set_gripper_pose(away);
  scatter_stones(world, {layout.field_centre, layout.field_size, options.simulation.clearance}, seed);
  SensorModel sensor = choose_sensor(options.simulation);
  sensor.bias_seed = Random::stream(seed, "camera bias").bits();
  Random random = Random::stream(seed, "render");
  SimulatedScene scene;
  scene.T_W_C = look_at(layout.field_centre, options.distance, options.tilt, random.uniform(0.0, kTwoPi));
  scene.depth = true_view(what_is_seen(world), real, scene.T_W_C, sensor, random);
  scene.depth_unit = sensor.unit;
  for (const StoneIndex i : world.present())
    if (!world.is_foreign(i)) scene.stones.push_back({i, world.pose(i)});
  return scene;
}

void write_scene(const std::string& folder, const SimulatedScene& scene, const std::vector<Stone>& stones) {
  const std::string base = folder + "/";
  write_depth_png(base + "depth.png", scene.depth, scene.depth_unit);
  write_cloud(base + "cloud.ply", to_cloud(scene.depth));
  SceneFile file;
  file.camera = scene.depth.camera;
  file.T_W_C = scene.T_W_C;
  file.depth_file = "depth.png";
  file.depth_unit = scene.depth_unit;
  file.cloud_file = "cloud.ply";
  for (const auto& placed : scene.stones)
    file.stones.push_back({at(stones, placed.stone).name, placed.T_W_O});
  write_scene_file(base + "scene.yaml", file);
}

}  // namespace stonestack::simulation
