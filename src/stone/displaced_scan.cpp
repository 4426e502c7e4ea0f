#include "stone/displaced_scan.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/convex_pieces.hpp"
#include "stone/gradient_noise.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::stone {
namespace {

constexpr double kFeature = 0.025;    // m: width of what is displaced together, as of lumps on scanned rocks
constexpr double kMaxSigmas = 2.5;    // a displacement is no larger
constexpr double kRestTilt = 0.15;    // rad between the attitude in which it lay and the displaced shape's
constexpr int kDrawsEach = 8;         // for a scan that rests
constexpr double kMinSigma = 0.0005;  // m: where all is known better, nothing is displaced

/// Noise of standard deviation 1 over the vertices.
std::vector<double> unit_noise(const Mesh& mesh, std::uint64_t seed) {
  const GradientNoise noise(seed);
  std::vector<double> values;
  values.reserve(mesh.vertices.size());
  double sum = 0.0, squares = 0.0;
  for (const Eigen::Vector3d& p : mesh.vertices) {
    values.push_back(noise.octaves(p / kFeature, 2));
    sum += values.back();
    squares += values.back() * values.back();
  }
  const auto count = static_cast<double>(values.size());
  const double mean = sum / count;
  const double deviation = std::sqrt(std::max(squares / count - mean * mean, 1e-12));
  for (double& value : values) value = (value - mean) / deviation;
  return values;
}

double lowest_along(const Mesh& mesh, const Eigen::Vector3d& up_O) {
  double lowest = std::numeric_limits<double>::max();
  for (const Eigen::Vector3d& p : mesh.vertices) lowest = std::min(lowest, up_O.dot(p));
  return lowest;
}

Mesh displaced(const Stone& stone, const std::vector<Eigen::Vector3d>& normals, std::uint64_t seed) {
  const SurfaceKnowledge& known = *stone.surface;
  const std::vector<double> noise = unit_noise(stone.scan, seed);
  Mesh mesh = stone.scan;
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
    mesh.vertices[v] += known.sigma[v] * std::clamp(noise[v], -kMaxSigmas, kMaxSigmas) * normals[v];
  for (const Eigen::Vector3d& up_O : known.up_O_at_rest) {
    const double table = lowest_along(stone.scan, up_O);
    for (Eigen::Vector3d& p : mesh.vertices) p += std::max(0.0, table - up_O.dot(p)) * up_O;
  }
  return mesh;
}

}  // namespace

bool rests_with(const Mesh& surface_O, const Eigen::Vector3d& p_O_M, const Eigen::Vector3d& up_O,
                double max_tilt) {
  const Mesh hull = convex_hull(surface_O);
  const std::vector<Eigen::Vector3d> normals = face_normals(hull);
  double nearest = std::numeric_limits<double>::max();
  double cosine = -1.0;
  for (std::size_t f = 0; f < hull.faces.size(); ++f) {
    const double inside = normals[f].dot(hull.vertices[static_cast<std::size_t>(hull.faces[f][0])] - p_O_M);
    if (inside < 0.0) return false;
    const double towards = -normals[f].dot(up_O);
    if (towards > 1e-9 && inside / towards < nearest) nearest = inside / towards, cosine = towards;
  }
  return cosine >= std::cos(max_tilt);
}

std::vector<Mesh> displaced_scans(const Stone& stone, int count, std::uint64_t seed) {
  std::vector<Mesh> scans;
  if (!stone.surface) return scans;
  const SurfaceKnowledge& known = *stone.surface;
  require(known.sigma.size() == stone.scan.vertices.size(), stone.name, ": ", known.sigma.size(),
          " standard deviations for ", stone.scan.vertices.size(), " vertices");
  if (*std::max_element(known.sigma.begin(), known.sigma.end()) < kMinSigma) return scans;
  const std::vector<Eigen::Vector3d> normals = vertex_normals(stone.scan);
  for (int k = 0; k < count; ++k)
    for (int draw = 0; draw < kDrawsEach; ++draw) {
      throw_if_interrupted();
      Mesh mesh = displaced(stone, normals, seed + static_cast<std::uint64_t>(kDrawsEach * k + draw));
      const auto rests = [&](const Eigen::Vector3d& up_O) {
        return rests_with(mesh, stone.mass.p_O_M, up_O, kRestTilt);
      };
      if (volume(mesh) <= 0.0 || !std::all_of(known.up_O_at_rest.begin(), known.up_O_at_rest.end(), rests))
        continue;
      scans.push_back(std::move(mesh));
      break;
    }
  return scans;
}

}  // namespace stonestack::stone
