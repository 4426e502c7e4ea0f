#include "detection/judge/draw_model.hpp"

#include <algorithm>
#include <cmath>

#include "detection/scene/seen_normal.hpp"

namespace stonestack::detection {
namespace {

constexpr double kNearest = 0.02;    // m: a mesh nearer than this cannot be drawn
constexpr double kDrawnStep = 0.02;  // m of depth between the pixels of a normal: more is an edge

/// A vertex in drawn pixels, and its inverse depth, which is affine in them.
struct Corner {
  double x, y, w;
};

/// Draws a face that the camera sees from outside.
void draw_face(DrawnModel& out, const Corner& a, const Corner& b, const Corner& c, int face) {
  const double area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
  if (!(area < -1e-12)) return;  // x right, y down: faces seen from outside run clockwise
  const double y_min = std::min({a.y, b.y, c.y}), y_max = std::max({a.y, b.y, c.y});
  const double x_min = std::min({a.x, b.x, c.x}), x_max = std::max({a.x, b.x, c.x});
  const int y0 = std::max(0, static_cast<int>(std::ceil(y_min)));
  const int y1 = std::min(out.height - 1, static_cast<int>(std::floor(y_max)));
  const int x0 = std::max(0, static_cast<int>(std::ceil(x_min)));
  const int x1 = std::min(out.width - 1, static_cast<int>(std::floor(x_max)));
  if (y0 > y1 || x0 > x1) return;  // between the pixels
  const double inverse = 1.0 / area;
  for (int y = y0; y <= y1; ++y)
    for (int x = x0; x <= x1; ++x) {
      const double l1 = ((x - a.x) * (c.y - a.y) - (c.x - a.x) * (y - a.y)) * inverse;
      const double l2 = ((b.x - a.x) * (y - a.y) - (x - a.x) * (b.y - a.y)) * inverse;
      if (l1 < -1e-9 || l2 < -1e-9 || l1 + l2 > 1.0 + 1e-9) continue;
      const auto z = static_cast<float>(1.0 / (a.w + l1 * (b.w - a.w) + l2 * (c.w - a.w)));
      const auto i = static_cast<std::size_t>(y * out.width + x);
      if (out.z[i] == 0.0F || z < out.z[i]) out.z[i] = z, out.face[i] = face;
    }
}

}  // namespace

DrawnModel draw_model(const Mesh& mesh_O, const std::vector<Eigen::Vector3d>& normals_O, const Pose& T_C_O,
                      const CameraIntrinsics& camera, int step) {
  DrawnModel out;
  out.step = step;
  std::vector<Corner> corners;
  corners.reserve(mesh_O.vertices.size());
  Eigen::AlignedBox2d box;
  for (const auto& p_O : mesh_O.vertices) {
    const Eigen::Vector3d p = T_C_O * p_O;
    if (!(p.z() > kNearest)) return out;
    const Eigen::Vector2d pixel = project(camera, p);
    if (!pixel.allFinite()) return out;
    box.extend(pixel);
    corners.push_back({pixel.x(), pixel.y(), 1.0 / p.z()});
  }
  const Eigen::Vector2d low = box.min().cwiseMax(0.0);
  const Eigen::Vector2d high = box.max().cwiseMin(Eigen::Vector2d(camera.width - 1, camera.height - 1));
  if (corners.empty() || (high - low).minCoeff() < 0) return out;
  out.u0 = static_cast<int>(low.x()) / step * step;
  out.v0 = static_cast<int>(low.y()) / step * step;
  out.width = (static_cast<int>(high.x()) - out.u0) / step + 1;
  out.height = (static_cast<int>(high.y()) - out.v0) / step + 1;
  out.z.assign(static_cast<std::size_t>(out.width * out.height), 0.0F);
  out.face.assign(out.z.size(), -1);
  for (auto& c : corners) c = {(c.x - out.u0) / step, (c.y - out.v0) / step, c.w};
  for (std::size_t f = 0; f < mesh_O.faces.size(); ++f) {
    const Eigen::Vector3i& face = mesh_O.faces[f];
    draw_face(out, corners[static_cast<std::size_t>(face[0])], corners[static_cast<std::size_t>(face[1])],
              corners[static_cast<std::size_t>(face[2])], static_cast<int>(f));
  }
  out.normals_C.resize(normals_O.size());
  for (const int f : out.face)
    if (f >= 0)
      out.normals_C[static_cast<std::size_t>(f)] = T_C_O.linear() * normals_O[static_cast<std::size_t>(f)];
  return out;
}

Eigen::Vector3d drawn_normal(const DrawnModel& drawn, const CameraIntrinsics& camera, int x, int y) {
  const auto at = static_cast<std::size_t>(y * drawn.width + x);
  const Eigen::Vector3d& of_face = drawn.normals_C[static_cast<std::size_t>(drawn.face[at])];
  const int span = std::max(1, (normal_span(camera, drawn.z[at]) + drawn.step / 2) / drawn.step);
  const double here = drawn.z[at];
  bool edge = false;
  const auto point = [&](int dx, int dy) -> Eigen::Vector3d {
    const double z = drawn.depth(x + dx, y + dy);
    edge = edge || std::abs(z - here) > kDrawnStep;
    return z * deproject(camera, drawn.u0 + (x + dx) * drawn.step, drawn.v0 + (y + dy) * drawn.step);
  };
  const Eigen::Vector3d across = point(span, 0) - point(-span, 0);
  const Eigen::Vector3d down = point(0, span) - point(0, -span);
  const Eigen::Vector3d normal = down.cross(across);
  return edge || normal.norm() < 1e-12 ? of_face : Eigen::Vector3d(normal.normalized());
}

}  // namespace stonestack::detection
