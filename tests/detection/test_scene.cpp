#include "detection/test_scene.hpp"
#include "rooms.hpp"

#include <algorithm>
#include <cmath>

namespace stonestack::test {
namespace {

/// A star-shaped surface: radius over direction.
struct RubbleShape {
  Eigen::Vector3d half;                                  ///< [m]
  std::vector<std::pair<Eigen::Vector3d, double>> cuts;  ///< unit normal, distance
  std::vector<Eigen::Vector4d> waves;                    ///< wave vector and phase

  [[nodiscard]] double radius(const Eigen::Vector3d& d) const {
    double r = 1.0 / d.cwiseQuotient(half).norm();
    double wave = 0;
    for (const auto& w : waves) wave += std::sin(w.head<3>().dot(d) + w(3)) / w.head<3>().norm();
    r *= 1.0 + 0.12 * wave;
    for (const auto& [n, distance] : cuts)
      if (const double along = n.dot(d); along > 1e-6) r = std::min(r, distance / along);
    return r;
  }
};

RubbleShape make_shape(int seed) {
  Random random = Random::stream(static_cast<std::uint64_t>(seed), "test stone");
  RubbleShape shape;
  shape.half = {random.uniform(0.07, 0.09), random.uniform(0.055, 0.068), random.uniform(0.038, 0.05)};
  for (int i = 0; i < 7; ++i) {
    const Eigen::Vector3d n = random.unit_vector();
    shape.cuts.emplace_back(n, random.uniform(0.72, 0.92) * shape.half.cwiseProduct(n).norm());
  }
  for (const double frequency : {2.5, 4.0, 6.0, 9.0})
    for (int i = 0; i < 3; ++i) {
      Eigen::Vector4d w;
      w << frequency * random.unit_vector(), random.uniform(0, 6.28);
      shape.waves.push_back(w);
    }
  return shape;
}

Mesh surface_of(const RubbleShape& shape, int subdivisions) {
  Mesh mesh = make_sphere(1.0, subdivisions);
  for (auto& p : mesh.vertices) p = shape.radius(p.normalized()) * p.normalized();
  return mesh;
}

}  // namespace

Stone make_test_stone(int seed) {
  const RubbleShape shape = make_shape(seed);
  Stone stone;
  stone.name = "test_" + std::to_string(seed);
  stone.mesh = surface_of(shape, 3);
  stone.scan = surface_of(shape, 5);
  return stone;
}

Pose on_table(const Stone& stone, const Eigen::Quaterniond& R_W_O, double x, double y) {
  double lowest = 1e9;
  for (const auto& p : stone.scan.vertices) lowest = std::min(lowest, (R_W_O * p).z());
  return make_pose({x, y, -lowest}, R_W_O);
}

Pose make_camera_pose(double tilt, double azimuth, double distance) {
  const Eigen::Vector3d from = distance * Eigen::Vector3d(std::sin(tilt) * std::cos(azimuth),
                                                          std::sin(tilt) * std::sin(azimuth), std::cos(tilt));
  Eigen::Matrix3d R;  // columns: x right, y down, z forward
  R.col(2) = -from.normalized();
  R.col(0) = R.col(2).cross(Eigen::Vector3d(std::cos(azimuth), std::sin(azimuth), 0.3)).normalized();
  R.col(1) = R.col(2).cross(R.col(0));
  return make_pose(from, Eigen::Quaterniond(R));
}

DepthImage look_at(const std::vector<StandingStone>& stones, const Pose& T_W_C,
                   const CameraIntrinsics& camera) {
  RayScene scene;
  scene.add(make_box({1.6, 1.6, 0.02}), make_pose({0, 0, -0.01}));
  for (const auto& s : stones) scene.add(s.stone->scan, s.T_W_O);
  scene.commit();
  return render(scene, camera, T_W_C).depth;
}

DepthImage with_noise(const DepthImage& image, double sigma, std::uint64_t seed) {
  Random random = Random::stream(seed, "test noise");
  DepthImage out = image;
  const int width = image.camera.width, height = image.camera.height;
  for (int v = 1; v + 1 < height; ++v)
    for (int u = 1; u + 1 < width; ++u) {
      const auto i = static_cast<std::size_t>(v * width + u);
      const float z = image.z[i];
      if (z <= 0) continue;
      float low = z, high = z;
      for (int dv = -1; dv <= 1; ++dv)
        for (int du = -1; du <= 1; ++du) {
          const float n = image.at(u + du, v + dv);
          low = std::min(low, n), high = std::max(high, n);
        }
      const double draw = random.uniform(), part = random.uniform();
      const double noise = sigma * (0.4 + static_cast<double>(z) * z) * random.normal();
      out.z[i] = static_cast<float>(z + noise);
      if (high - low > 0.015F && draw < 0.3) out.z[i] = 0.0F;
      if (high - low > 0.015F && draw > 0.7) out.z[i] = low + static_cast<float>(part) * (high - low);
      if (draw > 0.496 && draw < 0.5) out.z[i] = 0.0F;
    }
  return out;
}

FourOfFive::Scene FourOfFive::make_scene(std::uint64_t seed) {
  Random random = Random::stream(seed, "scene");
  Scene scene;
  scene.T_W_C = make_camera_pose(random.uniform(0.0, 0.7), random.uniform(0.0, 6.28));
  std::vector<StandingStone> standing;
  for (int i = 0; i < 4; ++i) {
    const auto& stone = stones()[static_cast<std::size_t>(i)];
    scene.T_W_O.push_back(
        on_table(stone, random.rotation(), i % 2 == 0 ? -0.11 : 0.11, i < 2 ? -0.11 : 0.11));
    standing.push_back({&stone, scene.T_W_O.back()});
  }
  scene.image = with_noise(look_at(standing, scene.T_W_C), 0.001, seed);
  return scene;
}

bool FourOfFive::right(const Detection& d, const Scene& scene) {
  const PoseDifference error = difference(d.T_C_O, scene.T_W_C.inverse() * at(scene.T_W_O, d.stone));
  return error.translation < 0.005 && error.angle < 5 * 3.14159265358979 / 180.0;
}

}  // namespace stonestack::test
