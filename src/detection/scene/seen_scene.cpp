#include <algorithm>

#include "detection/constants.hpp"
#include "detection/scene/align_views.hpp"
#include "detection/scene/preprocess.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::detection {
namespace {

constexpr int kSceneFewestPixels = 200;  // of depth in the whole image: less is no scene
constexpr float kSurelyNotMetres = 50.0F;
constexpr float kSurelyNotSoNear = 0.02F;  // m; no depth camera sees that

/// Why an image cannot be a scene; empty if it can.
std::string unusable(const DepthImage& image) {
  const auto pixels =
      static_cast<std::size_t>(image.camera.width) * static_cast<std::size_t>(image.camera.height);
  if (image.camera.width <= 0 || image.camera.height <= 0 || image.z.empty()) return "the image is empty";
  if (image.z.size() != pixels)
    return concat("the image has ", image.z.size(), " depths for ", image.camera.width, " x ",
                  image.camera.height, " pixels");
  if (!(image.camera.fx > 0 && image.camera.fy > 0)) return "the camera has no focal length";
  return {};
}

/// Describes what is odd about an image that shows no surface.
std::string no_surface(const DepthImage& image, const DetectionOptions& options) {
  if (std::string problem = out_of_range(image, options); !problem.empty()) return problem;
  return concat("depths within ", options.nearest, " to ", options.farthest, " m are there, but fewer than ",
                kSceneFewestPixels, " lie on a surface: they are too far apart, or noise");
}

/// The plane in V of a plane in C.
Plane in_view(const Plane& plane_C, const Pose& T_C_V) {
  return {T_C_V.linear().transpose() * plane_C.normal,
          plane_C.offset - plane_C.normal.dot(T_C_V.translation())};
}

Plane in_scene(const Plane& plane_V, const Pose& T_C_V) {
  const Eigen::Vector3d normal = T_C_V.linear() * plane_V.normal;
  return {normal, plane_V.offset + normal.dot(T_C_V.translation())};
}

/// Returns the points above the table, in V.
SurfacePoints above_table(const DepthImage& depth, const std::optional<Plane>& table_V) {
  std::vector<Eigen::Vector3f> points;
  std::vector<float> areas;
  const double pixel = 1.0 / (depth.camera.fx * depth.camera.fy);
  for (int v = 0; v < depth.camera.height; ++v)
    for (int u = 0; u < depth.camera.width; ++u) {
      const double z = depth.at(u, v);
      if (z <= 0) continue;
      const Eigen::Vector3d p = z * deproject(depth.camera, u, v);
      const double height = table_V ? table_V->distance(p) : kMinHeight;
      if (height < kMinHeight || height > kMaxHeight) continue;
      points.emplace_back(p.cast<float>());
      areas.push_back(static_cast<float>(z * z * pixel));
    }
  return surface_points(points, areas, static_cast<float>(kVoxel), static_cast<float>(kNormalRadius));
}

SurfacePoints moved(SurfacePoints points, const Pose& T_C_V) {
  const Eigen::Isometry3f T = T_C_V.cast<float>();
  for (auto& p : points.points) p = T * p;
  for (auto& n : points.normals) n = T.linear() * n;
  return points;
}

/// Adds a view to the scene; what is wrong with it, if it shows nothing.
std::string add_view(DetectionScene& scene, const DepthImage& image, const Pose& T_C_V,
                     const std::optional<Plane>& expected_table, bool look_for_table,
                     const DetectionOptions& options) {
  std::string problem = unusable(image);
  if (!problem.empty()) return problem;
  SeenView view;
  view.T_C_V = view.T_C_V_reported = T_C_V;
  view.depth = smooth_depth(image, options);
  const auto valid = std::count_if(view.depth.z.begin(), view.depth.z.end(), [](float z) { return z > 0; });
  if (valid < kSceneFewestPixels) return no_surface(image, options);
  std::optional<Plane> expected_V;
  if (expected_table) expected_V = in_view(*expected_table, T_C_V);
  if (expected_table || look_for_table) view.table_V = find_table(view.depth, expected_V, options);
  view.error = assumed_depth_error(view.depth.camera, options);
  if (view.table_V) {
    view.error = measure_depth_error(view.depth, *view.table_V, options);
    const NoiseAbout noise = noise_about(*view.table_V, view.depth, kTableTolerance);
    if (scene.views.empty() || noise.deviation > scene.noise)
      scene.noise = noise.deviation, scene.noise_depth = noise.depth;
    if (scene.views.empty() || !scene.table_C) scene.table_C = in_scene(*view.table_V, T_C_V);
    if (!scene.views.empty()) view.T_C_V = aligned_view(seen_table(scene), view);
  }
  const SurfacePoints points = moved(above_table(view.depth, view.table_V), view.T_C_V);
  append_points(scene, points, static_cast<int>(scene.views.size()));
  scene.views.push_back(std::move(view));
  return {};
}

}  // namespace

std::string out_of_range(const DepthImage& image, const DetectionOptions& options) {
  std::vector<float> seen;
  for (const float z : image.z)
    if (z > 0) seen.push_back(z);
  if (seen.empty()) return "no pixel has a depth";
  const auto within = std::count_if(seen.begin(), seen.end(),
                                    [&](float z) { return z >= options.nearest && z <= options.farthest; });
  if (within >= kSceneFewestPixels) return {};
  const auto middle = seen.begin() + static_cast<std::ptrdiff_t>(seen.size() / 2);
  std::nth_element(seen.begin(), middle, seen.end());
  const std::string range =
      concat("fewer than ", kSceneFewestPixels, " pixels have a depth within ", options.nearest, " to ",
             options.farthest, " m; of ", seen.size(), " the middle one is ", *middle, " m");
  return *middle > kSurelyNotMetres
             ? range + ": are these millimetres? (--units of a cloud, --depth-unit of pictures)"
         : *middle < kSurelyNotSoNear ? range + "; is --units right? (--depth-unit of pictures)"
                                      : range;
}

void append_points(DetectionScene& scene, const SurfacePoints& more, int view) {
  auto& s = scene.surface;
  s.points.insert(s.points.end(), more.points.begin(), more.points.end());
  s.normals.insert(s.normals.end(), more.normals.begin(), more.normals.end());
  s.areas.insert(s.areas.end(), more.areas.begin(), more.areas.end());
  scene.view_of.resize(s.points.size(), view);
}

SurfacePoints surface_of_view(const DetectionScene& scene, int view) {
  if (scene.views.size() == 1) return scene.surface;
  SurfacePoints out;
  for (std::size_t i = 0; i < scene.surface.points.size(); ++i) {
    if (scene.view_of[i] != view) continue;
    out.points.push_back(scene.surface.points[i]);
    out.normals.push_back(scene.surface.normals[i]);
    out.areas.push_back(scene.surface.areas[i]);
  }
  return out;
}

void find_clusters(DetectionScene& scene, double gap) {
  scene.cluster = cluster_points(scene.surface.points, static_cast<float>(gap), kClusterPoints);
  scene.clusters = 0;
  for (const int c : scene.cluster) scene.clusters = std::max(scene.clusters, c + 1);
  if (scene.clusters == 0)
    scene.note = scene.table_C ? "nothing unknown stands on the table" : "nothing but specks is in view";
}

DetectionScene preprocess(const DepthImage& image, const std::optional<Plane>& expected_table,
                          bool look_for_table, const DetectionOptions& options) {
  DetectionScene scene;
  scene.note = add_view(scene, image, Pose::Identity(), expected_table, look_for_table, options);
  if (scene.note.empty()) find_clusters(scene, kClusterGap);
  return scene;
}

DetectionScene preprocess(std::span<const DepthView> views, const std::optional<Plane>& expected_table,
                          bool look_for_table, const DetectionOptions& options) {
  require(!views.empty(), "a scene needs one view at least");
  DetectionScene scene;
  std::string problem;
  for (const auto& view : views) {
    const bool first = &view == &views.front();  // exactly C, not but for rounding
    const Pose T_C_V = first ? Pose::Identity() : views.front().T_W_C.inverse() * view.T_W_C;
    const auto table = expected_table ? expected_table : scene.table_C;
    const std::string one = add_view(scene, view.image, T_C_V, table, look_for_table, options);
    if (!one.empty()) problem = one;
  }
  scene.note = problem;
  if (scene.views.empty()) return scene;
  scene.note.clear();
  find_clusters(scene, kClusterGap);
  return scene;
}

}  // namespace stonestack::detection
