#include "detection/judge/contour.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "detection/scene/seen_normal.hpp"

namespace stonestack::detection {
namespace {

constexpr int kOutlineOff = 2;          // px: the outline of 500 faces is a pixel or two off
constexpr double kSameSurface = 0.004;  // m from the tangent plane, at up to 1 m; grows with z^2
constexpr double kSameNormal = 0.94;    // cosine: less is a crease

struct Direction {
  int x, y;
};
constexpr std::array<Direction, 4> kContourDirections = {{{1, 0}, {-1, 0}, {0, 1}, {0, -1}}};

/// Whether the surface goes on from one pixel to the other; neither known to be one surface without a normal.
bool one_surface(const DepthImage& depth, int u, int v, int to_u, int to_v) {
  const Eigen::Vector3d a = seen_normal(depth, u, v), b = seen_normal(depth, to_u, to_v);
  if (a.isZero() || b.isZero() || a.dot(b) < kSameNormal) return false;
  const double z = depth.at(u, v);
  const Eigen::Vector3d step =
      depth.at(to_u, to_v) * deproject(depth.camera, to_u, to_v) - z * deproject(depth.camera, u, v);
  const double max = kSameSurface * std::max(1.0, z * z);
  return std::abs(a.dot(step)) < max && std::abs(b.dot(step)) < max;
}

}  // namespace

ContourTally compare_contour(const SeenView& view, const DrawnModel& drawn, double reach,
                             std::span<const double> weights) {
  ContourTally tally;
  const CameraIntrinsics& camera = view.depth.camera;
  const auto in_image = [&](int u, int v) {
    return u >= 0 && v >= 0 && u < camera.width && v < camera.height;
  };
  const auto known = [&](int u, int v) {
    return !view.explained.empty() && view.explained[static_cast<std::size_t>(v * camera.width + u)] != 0;
  };
  const auto shows_model = [&](int x, int y, Direction d, int beside) {
    const int within = std::max(1, beside / drawn.step);
    const float inner = drawn.depth(x - within * d.x, y - within * d.y);
    const float z = inner > 0 ? inner : drawn.depth(x, y);
    const int u = drawn.u0 + x * drawn.step - beside * d.x, v = drawn.v0 + y * drawn.step - beside * d.y;
    return std::abs(view.depth.at(u, v) - z) < reach;
  };
  for (int y = 0; y < drawn.height; ++y)
    for (int x = 0; x < drawn.width; ++x) {
      if (!(drawn.depth(x, y) > 0)) continue;
      for (const Direction d : kContourDirections) {
        if (drawn.depth(x + d.x, y + d.y) > 0) continue;
        const auto face = static_cast<std::size_t>(drawn.face[static_cast<std::size_t>(y * drawn.width + x)]);
        const double weight = weights.empty() ? 1.0 : weights[face];
        tally.all += weight;
        const int u = drawn.u0 + x * drawn.step, v = drawn.v0 + y * drawn.step;
        const int beside = normal_span(camera, drawn.depth(x, y)) + kOutlineOff;  // px to each side
        const int in_u = u - beside * d.x, in_v = v - beside * d.y;
        const int out_u = u + beside * d.x, out_v = v + beside * d.y;
        if (!in_image(in_u, in_v) || !in_image(out_u, out_v)) continue;
        if (known(in_u, in_v) || known(out_u, out_v)) continue;
        if (!(view.depth.at(in_u, in_v) > 0) || !(view.depth.at(out_u, out_v) > 0)) continue;
        if (!shows_model(x, y, d, beside)) continue;
        tally.seen += weight;
        tally.goes_on += one_surface(view.depth, in_u, in_v, out_u, out_v) ? weight : 0.0;
      }
    }
  return tally;
}

}  // namespace stonestack::detection
