#include "stone/rubble.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "stone/geodesic.hpp"

namespace stonestack::stone {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

/// Minimum with corners rounded over a width of `k` (log-sum-exp).
double smooth_minimum(const std::vector<double>& values, double k) {
  const double min = *std::min_element(values.begin(), values.end());
  double sum = 0.0;
  for (const double value : values) sum += std::exp((min - value) / k);
  return min - k * std::log(sum);
}

/// Where the ray from the origin along the unit vector `u` meets the plane.
double radius_of_cut(const Rubble::Cut& cut, const Eigen::Vector3d& u) {
  const double slope = cut.normal.dot(u);
  return slope > 0.05 ? cut.offset / slope : kNever;
}

/// Where the ray enters a ball whose nearest point lies at `reach` from the origin.
double radius_of_ball(const Eigen::Vector3d& direction, double reach, double radius,
                      const Eigen::Vector3d& u) {
  const double along = (reach + radius) * direction.dot(u);
  const double square = along * along - reach * (reach + 2.0 * radius);
  return along > 0.0 && square > 0.0 ? along - std::sqrt(square) : kNever;
}

/// How far a ball may eat in before rays from the origin graze it above the surface, where the radius would
/// jump (for a surface that is a ball of radius `reach`, with a margin for flatter ones).
double deepest(double reach, double radius) {
  return 0.7 * reach * radius / (reach + radius);
}

/// Radius before dents: the noisy ball cut by planes, edges broken over 1 to 3 mm.
double body_radius(const Rubble& rubble, const Eigen::Vector3d& u, double concavity) {
  const GradientNoise noise(rubble.seed);
  const Eigen::Vector3d p = rubble.half.cwiseProduct(u);  // m, so that features have a size in millimetres
  const double size = rubble.half.maxCoeff();
  const double ball = 1.12 + 0.2 * noise.octaves(p / (0.7 * size), 3, 0.5);
  std::vector<double> radii = {ball};
  for (std::size_t c = 0; c < rubble.cuts.size(); ++c) {
    const double flat = radius_of_cut(rubble.cuts[c], u);
    if (flat > 1.3 * ball) continue;  // too far out to show, whatever its warp
    const Eigen::Vector3d own = Eigen::Vector3d::Constant(7.7 * static_cast<double>(c + 1));
    const double warp =
        0.04 * concavity * noise.octaves(p / 0.045 + own, 3, 0.4);  // cleavage is never quite flat
    radii.push_back(flat * (1.0 + warp));
  }
  const double breakage = 0.5 + 0.5 * noise(p / 0.02 - Eigen::Vector3d::Constant(3.3));
  const double bend =
      0.15 * concavity * noise.octaves(p / (0.8 * size) + Eigen::Vector3d::Constant(41.9), 2, 0.4);
  return (1.0 + bend) * smooth_minimum(radii, (0.0006 + 0.0018 * breakage) / size);
}

void add_cleavage(Rubble& rubble, Random& random) {
  for (const double side : {1.0, -1.0}) {  // bedding: two faces nearly parallel
    Eigen::Vector3d normal(0.16 * random.normal(), 0.16 * random.normal(), side);
    rubble.cuts.push_back({normal.normalized(), random.uniform(0.72, 0.88)});
  }
  const std::size_t more = 4 + random.index(7);
  for (std::size_t n = 0; n < more; ++n) {
    Eigen::Vector3d normal = random.unit_vector();
    normal.z() *= 0.6;  // joints stand steeply on the bedding
    rubble.cuts.push_back({normal.normalized(), random.uniform(0.70, 0.97)});
  }
}

/// Knocks off corners and stretches of edge: cuts a little below the furthest point in a direction.
void add_chips(Rubble& rubble, Random& random) {
  const Mesh coarse = make_geodesic(8);
  const std::size_t chips = 4 + random.index(5);
  for (std::size_t n = 0; n < chips; ++n) {
    const Eigen::Vector3d normal = random.unit_vector();
    double furthest = 0.0;
    for (const Eigen::Vector3d& u : coarse.vertices)
      furthest = std::max(furthest, body_radius(rubble, u, 1.0) * normal.dot(u));
    rubble.cuts.push_back({normal, furthest - random.uniform(0.03, 0.12)});
  }
}

/// Halfway to the mean of the neighbours: breaks edges that are narrower than a face, which would come out as
/// saw-teeth. On radii, so that the surface stays star-shaped.
std::vector<double> evened(const std::vector<double>& radii, const Mesh& sphere) {
  std::vector<double> sum(radii.size(), 0.0);
  std::vector<int> count(radii.size(), 0);
  for (const Eigen::Vector3i& face : sphere.faces)
    for (int k = 0; k < 3; ++k) {
      sum[face[k]] += radii[face[(k + 1) % 3]] + radii[face[(k + 2) % 3]];
      count[face[k]] += 2;
    }
  std::vector<double> result;
  for (std::size_t v = 0; v < radii.size(); ++v) result.push_back(0.5 * radii[v] + 0.5 * sum[v] / count[v]);
  return result;
}

/// Metres per unit along each axis, so that the extents become those asked for.
Eigen::Vector3d fit(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& half) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3d& p : points) box.extend(p);
  return (2.0 * half).cwiseQuotient(box.sizes());
}

}  // namespace

Rubble draw_rubble(Random& random, const Eigen::Vector3d& extents) {
  Rubble rubble;
  rubble.half = extents / 2.0;
  rubble.seed = random.bits();
  rubble.roughness = random.uniform(0.0003, 0.0005);
  add_cleavage(rubble, random);
  add_chips(rubble, random);
  const std::size_t dents = 1 + random.index(3);
  for (std::size_t n = 0; n < dents; ++n) {
    const Eigen::Vector3d side = random.unit_vector().cwiseProduct(Eigen::Vector3d(1.0, 1.0, 0.5));
    rubble.dents.push_back({side.normalized(), random.uniform(0.4, 1.1), random.uniform(0.18, 0.30)});
  }
  return rubble;
}

Mesh surface(const Rubble& rubble, const Mesh& sphere, double concavity) {
  std::vector<double> reach;  // from the origin to each dent's deepest point
  for (const Rubble::Dent& dent : rubble.dents) {
    const double skin = body_radius(rubble, dent.direction, concavity);
    reach.push_back(skin - std::min(concavity * dent.depth, deepest(skin, dent.radius)));
  }
  std::vector<double> radii;
  for (const Eigen::Vector3d& u : sphere.vertices) {
    std::vector<double> candidates = {body_radius(rubble, u, concavity)};
    for (std::size_t d = 0; d < reach.size(); ++d)
      candidates.push_back(radius_of_ball(rubble.dents[d].direction, reach[d], rubble.dents[d].radius, u));
    radii.push_back(smooth_minimum(candidates, 0.01));
  }
  radii = evened(radii, sphere);
  Mesh mesh = sphere;
  for (std::size_t v = 0; v < radii.size(); ++v) mesh.vertices[v] *= radii[v];
  const Eigen::Vector3d metres = fit(mesh.vertices, rubble.half);
  const GradientNoise grain(rubble.seed + 1);
  for (Eigen::Vector3d& p : mesh.vertices) {
    p = p.cwiseProduct(metres);
    // Features of 8 and 4 mm; gradient noise of two octaves has an RMS near 0.3.
    p += p.normalized() * rubble.roughness / 0.3 * grain.octaves(p / 0.008, 2);
  }
  return mesh;
}

}  // namespace stonestack::stone
