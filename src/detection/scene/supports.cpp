#include "detection/scene/supports.hpp"

#include <algorithm>
#include <cmath>

#include "detection/constants.hpp"
#include "detection/scene/fit_plane.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::detection {
namespace {

constexpr double kLonger = 1.2;   // times the longest model: a plane of one model and a bit of its neighbour
constexpr double kFilled = 0.4;   // of the outline's area seen: less is things that happen to be as high
constexpr double kMinArea = 0.1;  // of the longest model squared: a strip is the rim of a thing
constexpr double kNoiseReach = 3.0;    // times the noise: so near the plane counts as plane
constexpr double kSameFacing = 0.8;    // cosine between a point's normal and the plane's
constexpr double kLevel = 0.985;       // cosine to the table's normal: 10 deg
constexpr double kPlaneGap = 0.008;    // m between the points of one plane: slabs side by side are none
constexpr double kTornGap = 0.10;      // m beside the outline: as far as things on a table throw shadows
constexpr int kTrials = 200;           // misses a plane of a quarter of the points with p < 0.05
constexpr std::size_t kLooked = 1500;  // points of a cluster that are counted in a trial
constexpr int kPlanesOfCluster = 4;

/// Points of one cluster, in C.
struct ClusterPoints {
  std::vector<int> index;
  std::vector<Eigen::Vector3d> points;
};

ClusterPoints points_of(const DetectionScene& scene, int cluster) {
  ClusterPoints out;
  for (std::size_t i = 0; i < scene.cluster.size(); ++i) {
    if (scene.cluster[i] != cluster) continue;
    out.index.push_back(static_cast<int>(i));
    out.points.push_back(scene.surface.points[i].cast<double>());
  }
  return out;
}

double diagonal(const ClusterPoints& cluster) {
  Eigen::AlignedBox3d box;
  for (const auto& p : cluster.points) box.extend(p);
  return cluster.points.empty() ? 0.0 : box.diagonal().norm();
}

/// Whether a point belongs to a plane by place and by normal.
class OnPlane {
 public:
  OnPlane(const DetectionScene& scene, const Plane& plane) : scene_(scene), plane_(plane) {}
  /// Of a point of the scene's surface.
  bool operator()(std::size_t i) const {
    const Eigen::Vector3d p = scene_.surface.points[i].cast<double>();
    const double reach = std::max(kTableTolerance, kNoiseReach * noise_at(scene_, p.z()));
    if (std::abs(plane_.distance(p)) > reach) return false;
    return scene_.surface.normals[i].cast<double>().dot(plane_.normal) > kSameFacing;
  }

 private:
  const DetectionScene& scene_;
  const Plane& plane_;
};

/// The plane with the most points of a cluster (RANSAC).
std::optional<Plane> best_plane(const DetectionScene& scene, const ClusterPoints& cluster, Random& random) {
  const std::size_t stride = std::max<std::size_t>(1, cluster.points.size() / kLooked);
  std::optional<Plane> best;
  int most = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    const auto any = [&] { return cluster.points[random.index(cluster.points.size())]; };
    const Eigen::Vector3d a = any(), b = any(), c = any();
    const auto plane = plane_through(a, b, c);
    if (!plane) continue;
    const OnPlane on(scene, *plane);
    int count = 0;
    for (std::size_t k = 0; k < cluster.points.size(); k += stride)
      count += on(static_cast<std::size_t>(cluster.index[k])) ? 1 : 0;
    if (count > most) most = count, best = plane;
  }
  if (best) best = fit_plane(cluster.points, *best, kTableTolerance);
  return best;
}

/// The largest connected part of a plane in a cluster: indices into the scene's surface.
std::vector<int> connected_part(const DetectionScene& scene, const ClusterPoints& cluster,
                                const Plane& plane) {
  std::vector<int> on;
  std::vector<Eigen::Vector3f> points;
  const OnPlane belongs(scene, plane);
  for (std::size_t k = 0; k < cluster.points.size(); ++k)
    if (belongs(static_cast<std::size_t>(cluster.index[k]))) {
      on.push_back(cluster.index[k]);
      points.push_back(cluster.points[k].cast<float>());
    }
  const auto part = cluster_points(points, static_cast<float>(kPlaneGap), kClusterPoints);
  std::vector<int> first;
  for (std::size_t k = 0; k < on.size(); ++k)
    if (part[k] == 0) first.push_back(on[k]);
  return first;
}

/// The outline of a plane's part if no model can have it.
std::optional<PlaneOutline> large_outline(const DetectionScene& scene, const Plane& plane,
                                          const std::vector<int>& part, double longest) {
  std::vector<Eigen::Vector3d> points;
  for (const int i : part) points.push_back(scene.surface.points[static_cast<std::size_t>(i)].cast<double>());
  PlaneOutline outline(plane, points);
  const double seen = static_cast<double>(part.size()) * kVoxel * kVoxel;
  const bool large = outline.length() > kLonger * longest && seen > kFilled * outline.area() &&
                     seen > kMinArea * longest * longest;
  return large ? std::optional(std::move(outline)) : std::nullopt;
}

/// Takes the large planes of one cluster: flags of points taken, and the outlines.
void take_planes(const DetectionScene& scene, ClusterPoints cluster, double longest, Random& random,
                 std::vector<char>& taken, std::vector<PlaneOutline>& outlines) {
  for (int turn = 0; turn < kPlanesOfCluster && diagonal(cluster) > kLonger * longest; ++turn) {
    const auto plane = best_plane(scene, cluster, random);
    if (!plane) return;
    const auto part = connected_part(scene, cluster, *plane);
    auto outline = large_outline(scene, *plane, part, longest);
    if (!outline) return;
    for (const int i : part) taken[static_cast<std::size_t>(i)] = 1;
    outlines.push_back(std::move(*outline));
    ClusterPoints rest;
    for (std::size_t k = 0; k < cluster.index.size(); ++k)
      if (taken[static_cast<std::size_t>(cluster.index[k])] == 0) {
        rest.index.push_back(cluster.index[k]);
        rest.points.push_back(cluster.points[k]);
      }
    cluster = std::move(rest);
  }
}

/// Takes what else lies on the planes and beside their outlines: things in front tear planes apart.
void take_torn_parts(const DetectionScene& scene, const std::vector<PlaneOutline>& outlines,
                     std::vector<char>& taken) {
  for (const PlaneOutline& outline : outlines) {
    const OnPlane on(scene, outline.plane());
    for (std::size_t i = 0; i < taken.size(); ++i)
      if (taken[i] == 0 && on(i) && outline.margin(scene.surface.points[i].cast<double>()) > -kTornGap)
        taken[i] = 1;
  }
}

}  // namespace

DetectionScene without_large_planes(DetectionScene scene, double longest, int seed) {
  Random random = Random::stream(static_cast<std::uint64_t>(seed), "detection supports");
  std::vector<char> taken(scene.surface.points.size(), 0);
  std::vector<PlaneOutline> outlines;
  for (int c = 0; c < scene.clusters; ++c)
    take_planes(scene, points_of(scene, c), longest, random, taken, outlines);
  if (outlines.empty()) return scene;
  take_torn_parts(scene, outlines, taken);
  for (auto& outline : outlines)
    if (scene.table_C && outline.plane().normal.dot(scene.table_C->normal) > kLevel)
      scene.supports.push_back(std::move(outline));
  keep_surface(scene, [&](std::size_t i) { return taken[i] == 0; });
  find_clusters(scene, kClusterGap);
  return scene;
}

std::vector<Plane> planes_below(const DetectionScene& scene, const Eigen::Vector3d& centre) {
  std::vector<Plane> planes;
  if (scene.table_C) planes.push_back(*scene.table_C);
  for (const auto& support : scene.supports)
    if (support.plane().distance(centre) > 0 && support.margin(centre) > 0) planes.push_back(support.plane());
  return planes;
}

}  // namespace stonestack::detection
