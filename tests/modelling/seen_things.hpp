#pragma once
#include <cmath>
#include <vector>

#include "geometry/depth_render.hpp"
#include "rooms.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/modelling/model_objects.hpp"
#include "stonestack/stone/model_stone.hpp"

/// Depth images of things on a table, as a camera of the resolution of an SR300 shows them.
namespace stonestack::modelling::test {

/// A mesh that stands on the table.
struct Thing {
  Mesh mesh;
  Pose T_W_O = Pose::Identity();
};

inline Pose looking_at(const Eigen::Vector3d& p_W_eye, const Eigen::Vector3d& p_W_target) {
  const Eigen::Vector3d z = (p_W_target - p_W_eye).normalized();
  const Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
  Pose T_W_C = Pose::Identity();
  T_W_C.linear() << x, z.cross(x), z;
  T_W_C.translation() = p_W_eye;
  return T_W_C;
}

/// `count` cameras around the middle of the table, 0.55 m away and 40 to 65 deg above it.
inline std::vector<Pose> cameras_around(int count) {
  std::vector<Pose> poses;
  for (int k = 0; k < count; ++k) {
    const double azimuth = 2.0 * M_PI * k / count + 0.3, elevation = k % 2 == 0 ? 0.75 : 1.1;
    poses.push_back(
        looking_at(0.55 * Eigen::Vector3d(std::cos(elevation) * std::cos(azimuth),
                                          std::cos(elevation) * std::sin(azimuth), std::sin(elevation)),
                   {0, 0, 0.03}));
  }
  return poses;
}

inline std::vector<DepthView> views_of(const std::vector<Thing>& things, const std::vector<Pose>& T_W_C,
                                       double sigma = 0.0006) {
  RayScene world;
  world.add(make_box({1.6, 1.6, 0.02}), make_pose({0, 0, -0.01}));
  for (const Thing& thing : things) world.add(thing.mesh, thing.T_W_O);
  world.commit();
  std::vector<DepthView> views;
  Random random(11);
  for (const Pose& pose : T_W_C) {
    DepthView view{render(world, CameraIntrinsics{}, pose).depth, pose};
    for (float& z : view.image.z)
      if (z > 0) z += static_cast<float>(sigma * random.normal());
    views.push_back(std::move(view));
  }
  return views;
}

/// A limestone lying flat on the table: its shortest extent is along z.
inline Thing lying_stone(std::uint64_t seed, double x, double y, double turn = 0.0) {
  Thing thing{make_limestone(seed), Pose::Identity()};
  thing.T_W_O.rotate(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()));
  double lowest = 1.0;
  for (const auto& v : thing.mesh.vertices) lowest = std::min(lowest, (thing.T_W_O * v).z());
  thing.T_W_O = Eigen::Translation3d(x, y, -lowest) * thing.T_W_O;
  return thing;
}

}  // namespace stonestack::modelling::test
