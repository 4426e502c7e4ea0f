#include "detection/features/triangulate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>

#include "stonestack/core/error.hpp"

namespace stonestack::detection {
namespace {

constexpr float kLongestLink = 4.0F;  // spacings: further apart in depth is another surface
constexpr int kMaxSplits = 12;        // rounds: edges shrink by half in each

/// Normals of the triangles around each point, towards `eye` if given; points without a triangle keep zero.
void add_normals(TriangulatedSurface& out, const std::optional<Eigen::Vector3f>& eye) {
  auto& s = out.surface;
  s.normals.assign(s.points.size(), Eigen::Vector3f::Zero());
  for (auto& t : out.triangles) {
    const auto p = [&](int k) -> const Eigen::Vector3f& { return s.points[static_cast<std::size_t>(t[k])]; };
    const Eigen::Vector3f n = (p(1) - p(0)).cross(p(2) - p(0));
    for (int k = 0; k < 3; ++k) s.normals[static_cast<std::size_t>(t[k])] += n;
  }
  for (std::size_t i = 0; i < s.points.size(); ++i) {
    if (eye && s.normals[i].dot(s.points[i] - *eye) > 0) s.normals[i] *= -1.0F;
    if (s.normals[i].norm() > 0) s.normals[i].normalize();
  }
}

/// The pixels that count, row by row; -1 elsewhere, else the index of the point.
std::vector<int> lay_points(const DetectionScene& scene, const SeenView& view, int step, double height_low,
                            double height_high, SurfacePoints& surface) {
  const CameraIntrinsics& camera = view.depth.camera;
  std::vector<int> index;
  for (int v = 0; v < camera.height; v += step)
    for (int u = 0; u < camera.width; u += step) {
      const double z = view.depth.at(u, v);
      const Eigen::Vector3d p = view.T_C_V * (z * deproject(camera, u, v));
      const double height = scene.table_C ? scene.table_C->distance(p) : height_low;
      const auto pixel = static_cast<std::size_t>(v * camera.width + u);
      const bool known = !view.explained.empty() && view.explained[pixel] != 0;
      const bool counts = z > 0 && height >= height_low && height <= height_high && !known;
      index.push_back(counts ? static_cast<int>(surface.points.size()) : -1);
      if (counts) surface.points.emplace_back(p.cast<float>()), surface.areas.push_back(0.0F);
    }
  return index;
}

}  // namespace

TriangulatedSurface triangulate(const DetectionScene& scene, int which, double spacing, double height_low,
                                double height_high) {
  TriangulatedSurface out;
  const SeenView& view = scene.views[static_cast<std::size_t>(which)];
  const Pose T_V_C = view.T_C_V.inverse();
  std::vector<float> depths;
  for (std::size_t i = 0; i < scene.surface.points.size(); ++i)
    if (scene.view_of[i] == which)
      depths.push_back(static_cast<float>((T_V_C * scene.surface.points[i].cast<double>()).z()));
  if (depths.empty()) return out;
  const auto middle = depths.begin() + static_cast<std::ptrdiff_t>(depths.size() / 2);
  std::nth_element(depths.begin(), middle, depths.end());
  const CameraIntrinsics& camera = view.depth.camera;
  const int step = std::max(1, static_cast<int>(std::lround(spacing * camera.fx / *middle)));
  const auto index = lay_points(scene, view, step, height_low, height_high, out.surface);
  const int columns = (camera.width + step - 1) / step, rows = (camera.height + step - 1) / step;
  const float longest = kLongestLink * static_cast<float>(spacing);
  const auto link = [&](int a, int b, int c) {
    if (a < 0 || b < 0 || c < 0) return;
    const auto p = [&](int i) -> const Eigen::Vector3f& {
      return out.surface.points[static_cast<std::size_t>(i)];
    };
    if ((p(a) - p(b)).norm() < longest && (p(b) - p(c)).norm() < longest && (p(c) - p(a)).norm() < longest)
      out.triangles.emplace_back(a, b, c);
  };
  for (int y = 0; y + 1 < rows; ++y)
    for (int x = 0; x + 1 < columns; ++x) {
      const auto at = [&](int dx, int dy) {
        return index[static_cast<std::size_t>((y + dy) * columns + x + dx)];
      };
      link(at(0, 0), at(0, 1), at(1, 0));
      link(at(1, 0), at(0, 1), at(1, 1));
    }
  add_normals(out, view.T_C_V.translation().cast<float>().eval());
  return out;
}

TriangulatedSurface subdivide(const Mesh& mesh, double spacing) {
  TriangulatedSurface out;
  auto& points = out.surface.points;
  for (const auto& p : mesh.vertices) points.emplace_back(p.cast<float>());
  out.triangles = mesh.faces;
  for (int round = 0; round < kMaxSplits; ++round) {
    std::map<std::pair<int, int>, int> middle;  // of a split edge
    const auto split = [&](int a, int b) {      // -1: short enough
      const Eigen::Vector3f pa = points[static_cast<std::size_t>(a)],
                            pb = points[static_cast<std::size_t>(b)];
      if ((pa - pb).norm() <= static_cast<float>(spacing)) return -1;
      const auto [at, fresh] =
          middle.try_emplace({std::min(a, b), std::max(a, b)}, static_cast<int>(points.size()));
      if (fresh) points.emplace_back(0.5F * (pa + pb));
      return at->second;
    };
    std::vector<Eigen::Vector3i> next;
    for (const auto& t : out.triangles) {
      const std::array<int, 3> m{split(t[0], t[1]), split(t[1], t[2]), split(t[2], t[0])};
      const auto count = std::count_if(m.begin(), m.end(), [](int i) { return i >= 0; });
      if (count == 0) {
        next.push_back(t);
      } else if (count == 3) {
        next.insert(next.end(),
                    {{t[0], m[0], m[2]}, {m[0], t[1], m[1]}, {m[2], m[1], t[2]}, {m[0], m[1], m[2]}});
      } else {  // fan around the first split edge's middle, through whatever lies on the way
        std::vector<int> ring;
        for (std::size_t k = 0; k < 3; ++k) {
          ring.push_back(t[static_cast<int>(k)]);
          if (m[k] >= 0) ring.push_back(m[k]);
        }
        const auto start = static_cast<std::size_t>(
            std::find(ring.begin(), ring.end(),
                      *std::find_if(m.begin(), m.end(), [](int i) { return i >= 0; })) -
            ring.begin());
        for (std::size_t k = 1; k + 1 < ring.size(); ++k)
          next.emplace_back(ring[start], ring[(start + k) % ring.size()],
                            ring[(start + k + 1) % ring.size()]);
      }
    }
    out.triangles = std::move(next);
    if (middle.empty()) break;
  }
  out.surface.areas.assign(points.size(), 0.0F);
  add_normals(out, std::nullopt);
  return out;
}

}  // namespace stonestack::detection
