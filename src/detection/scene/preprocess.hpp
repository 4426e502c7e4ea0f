#pragma once
#include <optional>
#include <string>
#include <vector>

#include "detection/scene/depth_error.hpp"
#include "detection/scene/plane_outline.hpp"
#include "stonestack/detection/detect_stones.hpp"
#include "stonestack/geometry/depth_image.hpp"
#include "stonestack/geometry/pose.hpp"

namespace stonestack::detection {

/// One point a voxel of what may be a stone, in C.
struct SurfacePoints {
  std::vector<Eigen::Vector3f> points;
  std::vector<Eigen::Vector3f> normals;  ///< unit, towards the camera (scene) or outwards (model)
  std::vector<float> areas;              ///< seen across the line of sight (scene), of surface (model) [m^2]
};

/// One view of a scene; V is its camera.
struct SeenView {
  Pose T_C_V = Pose::Identity();
  DepthImage depth;             ///< smoothed; 0 where unknown or out of range
  std::vector<char> explained;  ///< a flag a pixel: it shows a stone whose pose is known; empty if none does
  std::vector<int> explained_before;  ///< flags above and left of each pixel (integral image); empty as above
  Pose T_C_V_reported = Pose::Identity();  ///< before the views were aligned
  std::optional<Plane> table_V;            ///< as this view sees it
  DepthError error;                        ///< what the table shows of the depth's smooth error
};

/// A ball that holds a stone which was taken out of a scene, and all points that went with it.
struct TakenBall {
  Eigen::Vector3d centre_C;
  double radius;  ///< [m]
};

/// Depth images made ready: smoothed, cropped, the table found, the rest in voxels and clusters. C is the
/// camera of the first view.
struct DetectionScene {
  std::vector<SeenView> views;
  std::optional<Plane> table_C;  ///< normal towards the camera
  double noise = 0.0006;     ///< deviation of the smoothed depth from the table plane, along its normal [m]
  double noise_depth = 0.0;  ///< median depth of the table's points that showed it [m]; 0: assumed
  std::vector<PlaneOutline> supports;  ///< level planes above the table that carry things, too, in C
  SurfacePoints surface;     ///< above the table, `voxel` apart in each view, without what is explained
  std::vector<int> view_of;  ///< the view that saw each point
  std::vector<int> cluster;  ///< of each point: 0.., or -1 for specks
  int clusters = 0;
  std::vector<TakenBall> taken;  ///< stones that the scene was freed from, in the order in which they went
  std::string note;              ///< why there is nothing to see; empty otherwise
};

/// Edge-aware mean over 5 x 5 pixels, at rims the plane fitted to them: takes neighbours within a depth step
/// that grows with z (noise of a depth camera does), and drops a pixel with too few of them (flying pixels).
/// Depths out of range vanish.
[[nodiscard]] DepthImage smooth_depth(const DepthImage& raw, const DetectionOptions& options);

/// `view_of_table` of an image that is smoothed already.
[[nodiscard]] TableView view_of_smooth_table(const DepthImage& depth, const Plane& table_C,
                                             const Pose& T_W_C);

/// Why hardly any depth of an image lies within `nearest` and `farthest`, and what unit it may be in; empty
/// if enough do.
[[nodiscard]] std::string out_of_range(const DepthImage& image, const DetectionOptions& options);

/// The largest plane that may be a table: seen from above, nothing substantial below. If `expected` is given,
/// only planes near it. Seeded.
[[nodiscard]] std::optional<Plane> find_table(const DepthImage& depth, const std::optional<Plane>& expected,
                                              const DetectionOptions& options);

/// Noise of a depth image, as its points about a plane show it.
struct NoiseAbout {
  double deviation = 0.0006;  ///< robust standard deviation along the plane's normal [m]
  double depth = 0.0;         ///< median depth of these points [m]; 0 where they are too few
};
[[nodiscard]] NoiseAbout noise_about(const Plane& plane_C, const DepthImage& depth, double tolerance);

/// Noise [m] of the depths about `z` [m]: that about the table for what stands there, from 0.7 to 1.15 times
/// its depth; beyond, it changes with the square of the depth, as that of depth cameras does (Khoshelham and
/// Elberink 2012).
[[nodiscard]] double noise_at(const DetectionScene& scene, double z);

/// Means of points that share a cube of `voxel`; normals by local planes within `radius`, towards the origin
/// (the camera). Points without a local plane vanish.
[[nodiscard]] SurfacePoints surface_points(const std::vector<Eigen::Vector3f>& points,
                                           const std::vector<float>& areas, float voxel, float radius);

/// Groups points that are linked by steps of at most `gap`, largest group first; groups below `fewest` get
/// -1.
[[nodiscard]] std::vector<int> cluster_points(const std::vector<Eigen::Vector3f>& points, float gap,
                                              int fewest);

/// Sets the clusters of the scene's surface.
void find_clusters(DetectionScene& scene, double gap);

/// Leaves the points of the surface for which `keep(index)` holds. Clusters are not found anew.
template <class Keep>
void keep_surface(DetectionScene& scene, Keep&& keep) {
  SurfacePoints rest;
  std::vector<int> view_of;
  for (std::size_t i = 0; i < scene.surface.points.size(); ++i) {
    if (!keep(i)) continue;
    rest.points.push_back(scene.surface.points[i]);
    rest.normals.push_back(scene.surface.normals[i]);
    rest.areas.push_back(scene.surface.areas[i]);
    view_of.push_back(scene.view_of[i]);
  }
  scene.surface = std::move(rest);
  scene.view_of = std::move(view_of);
}

/// Returns the surface that one view saw.
[[nodiscard]] SurfacePoints surface_of_view(const DetectionScene& scene, int view);

/// Appends points that a view saw, in C.
void append_points(DetectionScene& scene, const SurfacePoints& more, int view);

/// Preprocesses one view. `find_table` without an expected table searches for one.
[[nodiscard]] DetectionScene preprocess(const DepthImage& image, const std::optional<Plane>& expected_table,
                                        bool find_table, const DetectionOptions& options);

/// All of it, for several views of one scene, aligned to each other.
[[nodiscard]] DetectionScene preprocess(std::span<const DepthView> views,
                                        const std::optional<Plane>& expected_table, bool find_table,
                                        const DetectionOptions& options);

}  // namespace stonestack::detection
