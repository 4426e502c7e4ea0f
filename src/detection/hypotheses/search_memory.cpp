#include "detection/hypotheses/search_memory.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "detection/constants.hpp"

namespace stonestack::detection {
namespace {

constexpr int kBesidePixels = 24;     // px: outline checks reach 18 px beyond a model (compare_contour)
constexpr double kBesideBall = 0.02;  // m: gates of registrations and surface beside a model reach 15 mm

/// Adds 64 bits to a fingerprint (the finalizer of SplitMix64, Steele, Lea and Flood 2014).
std::uint64_t mixed(std::uint64_t hash, std::uint64_t bits) {
  hash = (hash ^ bits) + 0x9E3779B97F4A7C15U;
  hash = (hash ^ (hash >> 30U)) * 0xBF58476D1CE4E5B9U;
  hash = (hash ^ (hash >> 27U)) * 0x94D049BB133111EBU;
  return hash ^ (hash >> 31U);
}

/// Pixels of a view, from low to below high.
struct PixelBox {
  int u0, v0, u1, v1;
};

/// The pixels that drawing a model and checking its outline read; all, where it is too near to be drawn.
PixelBox pixels_about(const DetectionModel& model, const Pose& T_V_O, const CameraIntrinsics& camera) {
  const Eigen::Vector3d centre = T_V_O * model.centre;
  const PixelBox all{0, 0, camera.width, camera.height};
  if (!(centre.z() > 1.05 * model.radius)) return all;
  Eigen::AlignedBox2d box;
  for (int corner = 0; corner < 8; ++corner) {
    const auto sign = [&](int bit) { return (corner >> bit & 1) != 0 ? model.radius : -model.radius; };
    box.extend(project(camera, centre + Eigen::Vector3d(sign(0), sign(1), sign(2))));
  }
  if (!box.min().allFinite() || !box.max().allFinite()) return all;
  const auto within = [](double x, int size) { return static_cast<int>(std::clamp(x, 0.0, 1.0 * size)); };
  return {within(box.min().x() - kBesidePixels, camera.width),
          within(box.min().y() - kBesidePixels, camera.height),
          within(box.max().x() + kBesidePixels + 1, camera.width),
          within(box.max().y() + kBesidePixels + 1, camera.height)};
}

long explained_within(const SeenView& view, const PixelBox& box) {
  if (view.explained_before.empty()) return 0;
  const auto before = [&](int u, int v) {
    return view.explained_before[static_cast<std::size_t>(v * (view.depth.camera.width + 1) + u)];
  };
  return static_cast<long>(before(box.u1, box.v1)) - before(box.u0, box.v1) - before(box.u1, box.v0) +
         before(box.u0, box.v0);
}

long explained_about(const DetectionModel& model, const Pose& T_C_O, const DetectionScene& scene) {
  long sum = 0;
  for (const auto& view : scene.views)
    sum += explained_within(view, pixels_about(model, view.T_C_V.inverse() * T_C_O, view.depth.camera));
  return sum;
}

}  // namespace

SceneState state_about(const DetectionModel& model, const Pose& T_C_O, const DetectionScene& scene) {
  return {scene.taken.size(), explained_about(model, T_C_O, scene)};
}

std::uint64_t fingerprint(const Pose& pose) {
  std::uint64_t hash = 0;
  for (int column = 0; column < 4; ++column)
    for (int row = 0; row < 3; ++row) hash = mixed(hash, std::bit_cast<std::uint64_t>(pose(row, column)));
  return hash;
}

std::uint64_t fingerprint(const SurfacePoints& seen, std::span<const int> points, int view) {
  std::uint64_t hash = mixed(points.size(), static_cast<std::uint64_t>(view));
  for (const int i : points) {
    const Eigen::Vector3f& p = seen.points[static_cast<std::size_t>(i)];
    const auto bits = [](float x) { return static_cast<std::uint64_t>(std::bit_cast<std::uint32_t>(x)); };
    hash = mixed(mixed(hash, bits(p.x()) << 32U | bits(p.y())), bits(p.z()));
  }
  return hash;
}

bool still_holds(const SceneState& state, const DetectionModel& model, const Pose& T_C_O,
                 const Pose& T_C_O_last, const DetectionScene& scene) {
  const Eigen::Vector3d first = T_C_O * model.centre, last = T_C_O_last * model.centre;
  for (std::size_t k = state.taken; k < scene.taken.size(); ++k) {
    const double reach = model.radius + kBesideBall + scene.taken[k].radius;
    if ((scene.taken[k].centre_C - first).norm() < reach || (scene.taken[k].centre_C - last).norm() < reach)
      return false;
  }
  return state.taken == scene.taken.size() || explained_about(model, T_C_O_last, scene) == state.explained;
}

}  // namespace stonestack::detection
