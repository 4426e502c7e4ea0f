#include "physics/features.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numeric>

#include "stonestack/core/error.hpp"

namespace stonestack::physics {
namespace {

constexpr double kFlat = 0.005;  // rad: an edge bent less than this cannot be felt (0.02 mm over 13 mm)
constexpr double kBall = 0.007;  // m
constexpr int kBallsAcross = 4;  // balls along a group's side
constexpr int kMaxGrid = 160;

using Vector = Eigen::Vector3d;

FaceFeature face_feature(const Mesh& mesh, const Eigen::Vector3i& f) {
  FaceFeature out;
  const Vector& a = mesh.vertices[static_cast<std::size_t>(f[0])];
  const Vector& b = mesh.vertices[static_cast<std::size_t>(f[1])];
  const Vector& c = mesh.vertices[static_cast<std::size_t>(f[2])];
  out.n = (b - a).cross(c - a).normalized();
  out.offset = out.n.dot(a);
  const std::array<const Vector*, 4> corner{&a, &b, &c, &a};
  for (std::size_t i = 0; i < 3; ++i) {
    out.side[i] = out.n.cross(*corner[i + 1] - *corner[i]).normalized();
    out.side_offset[i] = out.side[i].dot(*corner[i]);
  }
  return out;
}

/// Face on each side of an edge, by directed vertex pair.
using Sides = std::map<std::pair<int, int>, int>;

Sides sides_of(const Mesh& mesh) {
  Sides sides;
  for (std::size_t f = 0; f < mesh.faces.size(); ++f)
    for (int i = 0; i < 3; ++i) sides[{mesh.faces[f][i], mesh.faces[f][(i + 1) % 3]}] = static_cast<int>(f);
  return sides;
}

/// Convex edges, and the fan of every vertex, which takes all edges.
void add_edges(const Mesh& mesh, const Sides& sides, SurfaceFeatures& out) {
  std::vector<std::vector<Vector>> fans(mesh.vertices.size());
  for (const auto& [ends, left] : sides) {
    const auto twin = sides.find({ends.second, ends.first});
    require(twin != sides.end(), "contact needs a closed mesh; the edge between vertices ", ends.first,
            " and ", ends.second, " has one face");
    const Vector& p0 = mesh.vertices[static_cast<std::size_t>(ends.first)];
    const Vector& p1 = mesh.vertices[static_cast<std::size_t>(ends.second)];
    const double length = (p1 - p0).norm();
    if (length < 1e-9) continue;
    const Vector d = (p1 - p0) / length;
    fans[static_cast<std::size_t>(ends.first)].push_back(d);
    if (ends.first > ends.second) continue;
    const Vector& n0 = out.faces[static_cast<std::size_t>(left)].n;
    const Vector& n1 = out.faces[static_cast<std::size_t>(twin->second)].n;
    const Vector into0 = n0.cross(d);
    const Vector into1 = -n1.cross(d);
    if (n0.dot(into1) > -std::sin(kFlat)) continue;  // flat or concave
    out.edges.push_back({p0, p1, d, into0, into1, (n0 + n1).normalized(), length});
  }
  out.fan_begin.assign(1, 0);
  for (const auto& fan : fans) {
    out.fan.insert(out.fan.end(), fan.begin(), fan.end());
    out.fan_begin.push_back(static_cast<int>(out.fan.size()));
  }
}

std::vector<FeatureSample> samples_of(const SurfaceFeatures& features) {
  std::vector<FeatureSample> samples;
  for (std::size_t v = 0; v < features.vertices.size(); ++v)
    if (features.fan_begin[v] < features.fan_begin[v + 1])
      samples.push_back({features.vertices[v], static_cast<int>(v), -1});
  for (std::size_t e = 0; e < features.edges.size(); ++e) {
    const EdgeFeature& edge = features.edges[e];
    const int count = std::max(1, static_cast<int>(std::ceil(edge.length / kEdgeSpacing)));
    for (int i = 0; i < count; ++i)
      samples.push_back({edge.p0 + edge.d * (edge.length * (i + 0.5) / count), -1, static_cast<int>(e)});
  }
  return samples;
}

/// Balls around runs of equal keys; `centre_of` and `radius_of` describe the items.
std::vector<SampleBall> balls_over(std::size_t count,
                                   const std::function<std::array<long, 3>(std::size_t)>& key,
                                   const std::function<Vector(std::size_t)>& centre_of,
                                   const std::function<double(std::size_t)>& radius_of) {
  std::vector<SampleBall> balls;
  for (std::size_t begin = 0, end = 0; begin < count; begin = end) {
    SampleBall ball;
    Eigen::AlignedBox3d box;
    for (end = begin; end < count && key(end) == key(begin); ++end) box.extend(centre_of(end));
    ball.centre = box.center();
    for (std::size_t i = begin; i < end; ++i)
      ball.radius = std::max(ball.radius, (centre_of(i) - ball.centre).norm() + radius_of(i));
    ball.begin = static_cast<int>(begin);
    ball.end = static_cast<int>(end);
    balls.push_back(ball);
  }
  return balls;
}

void group_samples(SurfaceFeatures& out) {
  const auto key = [&](const Vector& p, double width) {
    const Vector q = (p - out.box.min()) / width;
    return std::array<long, 3>{std::lround(std::floor(q.x())), std::lround(std::floor(q.y())),
                               std::lround(std::floor(q.z()))};
  };
  const auto full_key = [&](const FeatureSample& s) {
    return std::pair(key(s.p, kBall * kBallsAcross), key(s.p, kBall));
  };
  auto& samples = out.samples;
  std::stable_sort(samples.begin(), samples.end(),
                   [&](const auto& a, const auto& b) { return full_key(a) < full_key(b); });
  out.balls = balls_over(
      samples.size(), [&](std::size_t i) { return key(samples[i].p, kBall); },
      [&](std::size_t i) { return samples[i].p; }, [](std::size_t) { return 0.0; });
  const auto first = [&](std::size_t i) { return samples[static_cast<std::size_t>(out.balls[i].begin)].p; };
  out.groups = balls_over(
      out.balls.size(), [&](std::size_t i) { return key(first(i), kBall * kBallsAcross); },
      [&](std::size_t i) { return out.balls[i].centre; }, [&](std::size_t i) { return out.balls[i].radius; });
}

double distance_to_segment(const Vector& p, const Vector& a, const Vector& b) {
  const Vector ab = b - a;
  const double s = std::clamp((p - a).dot(ab) / std::max(ab.squaredNorm(), 1e-18), 0.0, 1.0);
  return (p - a - s * ab).norm();
}

/// Lists per grid cell: `touches(item, centre)` says whether an item concerns the cell about that point.
void fill_grid(const SurfaceFeatures& out, const std::vector<Eigen::AlignedBox3d>& boxes,
               const std::function<bool(std::size_t, const Vector&)>& touches, std::vector<int>& start,
               std::vector<int>& list) {
  const auto cells = static_cast<std::size_t>(out.size.prod());
  std::vector<std::vector<int>> lists(cells);
  for (std::size_t item = 0; item < boxes.size(); ++item) {
    const Vector reach = Vector::Constant(kLookup);
    const Eigen::Vector3i low =
        ((boxes[item].min() - reach - out.origin) / out.cell).array().floor().cast<int>();
    const Eigen::Vector3i high =
        ((boxes[item].max() + reach - out.origin) / out.cell).array().floor().cast<int>();
    for (int z = std::max(low.z(), 0); z <= std::min(high.z(), out.size.z() - 1); ++z)
      for (int y = std::max(low.y(), 0); y <= std::min(high.y(), out.size.y() - 1); ++y)
        for (int x = std::max(low.x(), 0); x <= std::min(high.x(), out.size.x() - 1); ++x)
          if (touches(item, out.origin + out.cell * Vector(x + 0.5, y + 0.5, z + 0.5)))
            lists[static_cast<std::size_t>((z * out.size.y() + y) * out.size.x() + x)].push_back(
                static_cast<int>(item));
  }
  start.assign(1, 0);
  for (const auto& cell : lists) {
    list.insert(list.end(), cell.begin(), cell.end());
    start.push_back(static_cast<int>(list.size()));
  }
}

void build_grid(const Mesh& mesh, SurfaceFeatures& out) {
  const double margin = kLookup + 1e-4;
  const Vector extent = out.box.sizes().array() + 2 * margin;
  out.cell = std::max(0.005, extent.maxCoeff() / kMaxGrid);
  out.origin = out.box.min().array() - margin;
  out.size = (extent / out.cell).array().ceil().cast<int>().max(1);
  const double reach = kLookup + 0.5 * std::sqrt(3.0) * out.cell;

  std::vector<Eigen::AlignedBox3d> boxes;
  for (const auto& f : mesh.faces) {
    Eigen::AlignedBox3d box;
    for (int i = 0; i < 3; ++i) box.extend(mesh.vertices[static_cast<std::size_t>(f[i])]);
    boxes.push_back(box);
  }
  fill_grid(
      out, boxes,
      [&](std::size_t i, const Vector& centre) {
        const FaceFeature& face = out.faces[i];
        bool near = face.n.squaredNorm() > 0.5 && std::abs(face.n.dot(centre) - face.offset) <= reach;
        for (int s = 0; s < 3; ++s) near = near && face.side[s].dot(centre) >= face.side_offset[s] - reach;
        return near;
      },
      out.face_start, out.face_list);
  boxes.clear();
  for (const auto& edge : out.edges) {
    Eigen::AlignedBox3d box(edge.p0);
    boxes.push_back(box.extend(edge.p1));
  }
  fill_grid(
      out, boxes,
      [&](std::size_t i, const Vector& centre) {
        return distance_to_segment(centre, out.edges[i].p0, out.edges[i].p1) <= reach;
      },
      out.edge_start, out.edge_list);
}

}  // namespace

SurfaceFeatures::Cell SurfaceFeatures::near(const Eigen::Vector3d& p) const {
  const Eigen::Vector3d q = (p - origin) / cell;
  if (!(q.minCoeff() >= 0.0) || q.x() >= size.x() || q.y() >= size.y() || q.z() >= size.z()) return {};
  const Eigen::Vector3i i = q.cast<int>();
  const auto at = static_cast<std::size_t>((i.z() * size.y() + i.y()) * size.x() + i.x());
  return {face_list.data() + face_start[at], face_list.data() + face_start[at + 1],
          edge_list.data() + edge_start[at], edge_list.data() + edge_start[at + 1]};
}

SurfaceFeatures surface_features(const Mesh& mesh) {
  SurfaceFeatures out;
  out.vertices = mesh.vertices;
  for (const auto& v : mesh.vertices) out.box.extend(v);
  for (const auto& f : mesh.faces) out.faces.push_back(face_feature(mesh, f));
  add_edges(mesh, sides_of(mesh), out);
  out.samples = samples_of(out);
  group_samples(out);
  build_grid(mesh, out);
  return out;
}

}  // namespace stonestack::physics
