#include "detection/segment/grooves.hpp"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "detection/constants.hpp"

namespace stonestack::detection {
namespace {

constexpr std::array<double, 3> kGrooveReach{0.004, 0.008, 0.014};  // m to both sides
constexpr int kShortestReach = 2;     // px: less is within the window that smoothed the depth
constexpr double kStepReach = 0.004;  // m, a step of twice that counts 0.7
constexpr double kSteepest = 3.7;     // tangent of 75 deg: a steeper slope is a step

struct Direction {
  int u, v;
  double length;  // px
};
const std::array<Direction, 4> kDirections{{{1, 0, 1.0}, {0, 1, 1.0}, {1, 1, M_SQRT2}, {1, -1, M_SQRT2}}};

/// Depth behind the chord over half the chord's length across the view, at one distance; empty if the chord
/// does not end on objects.
std::optional<double> behind_chord(const ObjectSurface& surface, int u, int v, const Direction& d, int k) {
  const CameraIntrinsics& camera = surface.depth.camera;
  const int ua = u - k * d.u, va = v - k * d.v, ub = u + k * d.u, vb = v + k * d.v;
  if (std::min(ua, ub) < 0 || std::max(ua, ub) >= camera.width || std::min(va, vb) < 0 ||
      std::max(va, vb) >= camera.height)
    return std::nullopt;
  const auto a = static_cast<std::size_t>(va * camera.width + ua);
  const auto b = static_cast<std::size_t>(vb * camera.width + ub);
  if (surface.shown[a] == 0 || surface.shown[b] == 0) return std::nullopt;
  const double z = surface.depth.at(u, v), za = surface.depth.z[a], zb = surface.depth.z[b];
  const double on_chord = 2.0 / (1.0 / za + 1.0 / zb);  // a straight line is linear in 1 / z over the image
  const double half = k * d.length * z / surface.focal_length();
  const double across = 2.0 * half / std::hypot(2.0 * half, za - zb);
  return std::clamp((z - on_chord) * across / half, -1.0, 1.0);
}

float groove_at(const ObjectSurface& surface, int u, int v) {
  const double metre = surface.focal_length() / surface.depth.at(u, v);  // px
  double deepest = 0.0;
  for (const Direction& d : kDirections) {
    double sum = 0.0;
    int count = 0;
    for (const double reach : kGrooveReach) {
      const int k = std::max(kShortestReach, static_cast<int>(std::lround(reach * metre / d.length)));
      if (const auto depth = behind_chord(surface, u, v, d, k)) sum += *depth, ++count;
    }
    if (count > 0) deepest = std::max(deepest, sum / count);
  }
  return static_cast<float>(deepest);
}

}  // namespace

std::vector<float> groove_depths(const ObjectSurface& surface) {
  const CameraIntrinsics& camera = surface.depth.camera;
  std::vector<float> depths(surface.shown.size(), 0.0F);
  tbb::parallel_for(tbb::blocked_range<int>(0, camera.height, 16), [&](const auto& rows) {
    for (int v = rows.begin(); v < rows.end(); ++v)
      for (int u = 0; u < camera.width; ++u)
        if (const auto i = static_cast<std::size_t>(v * camera.width + u); surface.shown[i] != 0)
          depths[i] = groove_at(surface, u, v);
  });
  return depths;
}

float step_between(const ObjectSurface& surface, std::size_t a, std::size_t b) {
  const double za = surface.depth.z[a], zb = surface.depth.z[b];
  const double step = std::abs(za - zb);
  if (step < kSteepest * std::min(za, zb) / surface.focal_length()) return 0.0F;
  return static_cast<float>(step / std::hypot(step, 2.0 * kStepReach));
}

}  // namespace stonestack::detection
