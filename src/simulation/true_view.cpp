#include "simulation/true_view.hpp"

#include <cmath>

#include "core/constants.hpp"

namespace stonestack::simulation {
namespace {

constexpr double kMaxSpoilt = 0.95;  // share of edge pixels that float or are holes

/// The lens with the errors that its calibration left over; `reported` is what the device says of itself.
CameraIntrinsics true_lens(const CameraIntrinsics& reported, const SimulationOptions& options) {
  CameraIntrinsics lens = reported;
  Random random = Random::stream(static_cast<std::uint64_t>(options.seed), "lens error");
  const auto sign = [&] { return random.uniform() < 0.5 ? -1.0 : 1.0; };
  const double focal = 1.0 + sign() * options.lens_focal, direction = random.uniform(0.0, kTwoPi);
  lens.fx *= focal;
  lens.fy *= focal;
  lens.cx += options.lens_centre * std::cos(direction);
  lens.cy += options.lens_centre * std::sin(direction);
  if (options.lens_distortion > 0.0) {
    const double corner = std::hypot(0.5 * lens.width, 0.5 * lens.height);  // px
    lens.distortion = CameraIntrinsics::Distortion::kBrownConrady;
    lens.k[0] = sign() * options.lens_distortion * lens.fx * lens.fx / std::pow(corner, 3);
  }
  return lens;
}

void scale_errors(SensorModel& sensor, double factor) {
  for (double* error : {&sensor.sigma, &sensor.sigma_square, &sensor.stereo_subpixel, &sensor.bias,
                        &sensor.edge_jitter, &sensor.hole_share})
    *error *= factor;
  const double spoilt = factor * (sensor.edge_flying + sensor.edge_holes);
  const double share = spoilt > kMaxSpoilt ? factor * kMaxSpoilt / spoilt : factor;
  sensor.edge_flying *= share;
  sensor.edge_holes *= share;
}

}  // namespace

SensorModel choose_sensor(const SimulationOptions& options) {
  SensorModel sensor = read_sensor(options.sensor);
  sensor.lens = true_lens(sensor.camera, options);
  if (options.sensor_noise) {
    if (options.sensor_scale != 1.0) scale_errors(sensor, options.sensor_scale);
    return sensor;
  }
  SensorModel quiet;
  quiet.camera = sensor.camera;
  quiet.lens = sensor.lens;
  quiet.unit = sensor.unit;
  quiet.nearest = sensor.nearest;
  quiet.farthest = sensor.farthest;
  return quiet;
}

SeenWorld what_is_seen(const TrueWorld& world) {
  SeenWorld seen;
  seen.table = world.table().surface();
  for (const StoneIndex i : world.present()) seen.stones.emplace_back(i, world.pose(i));
  for (const auto& box : world.gripper_body().boxes)  // the camera does not see itself
    if (!box.camera)
      seen.boxes.emplace_back(box.size, box_pose(world.gripper_body(), box, world.gripper_pose()));
  return seen;
}

DepthImage true_view(const SeenWorld& world, const std::vector<Stone>& stones, const Pose& T_W_C,
                     const SensorModel& sensor, Random& random) {
  RayScene scene;
  scene.add(world.table, Pose::Identity());
  for (const auto& [i, T_W_O] : world.stones) scene.add(at(stones, i).scan, T_W_O);
  for (const auto& [size, T_W_box] : world.boxes) scene.add(make_box(size), T_W_box);
  scene.commit();
  DepthImage image = add_noise(render(scene, sensor.lens, T_W_C), T_W_C, sensor, random);
  image.camera = sensor.camera;
  return image;
}

}  // namespace stonestack::simulation
