#include <algorithm>
#include <cmath>
#include <queue>

#include "detection/segment/object_surface.hpp"
#include "modelling/constants.hpp"
#include "modelling/distance_volume.hpp"
#include "modelling/surface_of_volume.hpp"
#include "modelling/usable_options.hpp"
#include "modelling/view_normals.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/modelling/model_objects.hpp"

namespace stonestack::modelling {
namespace {

constexpr double kSeenWeight = 0.15;  // of the views at a vertex, from which on it was seen
// Of a view alone, where no other shows the same surface: noise and smooth error of a depth camera at half a
// metre, and the error of an aligned pose.
constexpr double kSigmaOfOne = 0.0008;  // m
// Measured (bench modelling, cell lab): with these the errors of what was not seen have the size they say.
constexpr double kSigmaUnseen = 0.001;  // m where the seen surface ends, ...
constexpr double kUnseenSlope = 0.07;   // ... and more by this share of the distance from there

/// Views of all poses that show the object, prepared.
struct Prepared {
  std::vector<FusedView> views;
  std::vector<std::vector<Eigen::Vector3f>> normals;  ///< owned here, a view each
  Eigen::AlignedBox3d box_O;
};

/// True where the views show the object.
std::vector<char> mask_of(const std::vector<int>& labels, int label) {
  std::vector<char> shows(labels.size());
  std::transform(labels.begin(), labels.end(), shows.begin(), [&](int l) { return l == label ? 1 : 0; });
  return shows;
}

void add_views(const LyingObject& lying, const DetectionOptions& options, Prepared& all) {
  require(lying.scene != nullptr, "a lying object needs its scene");
  const auto& scene = *lying.scene;
  require(lying.object >= 0 && lying.object < static_cast<int>(scene.segmentation.objects.size()),
          "the scene has ", scene.segmentation.objects.size(), " objects, none is number ", lying.object);
  const Pose T_O_W = lying.T_W_O.inverse();
  for (std::size_t k = 0; k < scene.views.size(); ++k) {
    const DepthView& view = scene.views[k];
    FusedView fused;
    fused.depth = &view.image;
    fused.shows = mask_of(scene.segmentation.labels[k], lying.object + 1);
    fused.seen_to = seen_to(view.image);
    fused.T_C_O = view.T_W_C.inverse() * lying.T_W_O;
    all.normals.push_back(normals_where(fused.shows, view.image, options));
    all.views.push_back(std::move(fused));
  }
  const Cloud& cloud = scene.segmentation.objects[static_cast<std::size_t>(lying.object)].cloud_C;
  const Pose T_O_C = T_O_W * scene.views.front().T_W_C;
  for (const auto& p : cloud.points) {
    const Eigen::Vector3d p_O = T_O_C * p.cast<double>();
    all.box_O.extend(p_O);
    Eigen::Vector3d p_W = lying.T_W_O * p_O;  // down to the table
    p_W.z() = 0.0;
    all.box_O.extend(T_O_W * p_W);
  }
}

/// Distance along the surface from each vertex to the nearest one that was seen.
std::vector<double> distance_to_seen(const Mesh& mesh, const std::vector<char>& seen) {
  std::vector<std::vector<int>> beside(mesh.vertices.size());
  for (const auto& face : mesh.faces)
    for (int k = 0; k < 3; ++k) {
      beside[static_cast<std::size_t>(face[k])].push_back(face[(k + 1) % 3]);
      beside[static_cast<std::size_t>(face[(k + 1) % 3])].push_back(face[k]);
    }
  std::vector<double> distance(mesh.vertices.size(), 1e9);
  using Entry = std::pair<double, int>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
  for (std::size_t v = 0; v < seen.size(); ++v)
    if (seen[v] != 0) open.emplace(distance[v] = 0.0, static_cast<int>(v));
  while (!open.empty()) {
    const auto [d, v] = open.top();
    open.pop();
    if (d > distance[static_cast<std::size_t>(v)]) continue;
    for (const int next : beside[static_cast<std::size_t>(v)]) {
      const double to =
          d +
          (mesh.vertices[static_cast<std::size_t>(v)] - mesh.vertices[static_cast<std::size_t>(next)]).norm();
      if (to < distance[static_cast<std::size_t>(next)])
        open.emplace(distance[static_cast<std::size_t>(next)] = to, next);
    }
  }
  return distance;
}

/// Standard deviation of a single view's distances, from how views of the object differ; else from how those
/// of its scenes do [m].
double sigma_of_one(const DistanceVolume& volume, std::span<const LyingObject> lying) {
  constexpr double kOfMedian = 1.4826;  // standard deviation over the median of absolute values, of a normal
  if (const auto spread = volume.spread()) return *spread;
  double apart = 0.0;
  for (const LyingObject& one : lying) apart = std::max(apart, one.scene->apart_after);
  return apart > 0.0 ? kOfMedian * apart / std::sqrt(2.0) : kSigmaOfOne;
}

double seen_area_share(const Mesh& mesh, const std::vector<char>& seen) {
  double all = 0.0, of_seen = 0.0;
  for (const auto& face : mesh.faces) {
    const auto& a = mesh.vertices[static_cast<std::size_t>(face[0])];
    const double area = (mesh.vertices[static_cast<std::size_t>(face[1])] - a)
                            .cross(mesh.vertices[static_cast<std::size_t>(face[2])] - a)
                            .norm();
    int count = 0;
    for (int k = 0; k < 3; ++k) count += seen[static_cast<std::size_t>(face[k])];
    all += area;
    of_seen += area * count / 3.0;
  }
  return all > 0 ? of_seen / all : 0.0;
}

}  // namespace

FieldList fields(ModellingOptions& o) {
  return {field("voxel", o.voxel, {0.0003, 0.02}, "m", "measured: bench modelling"),
          field("truncation", o.truncation, {0.001, 0.1}, "m", "design choice: four voxels"),
          field("facet", o.facet, {0.0005, 0.05}, "m", "design choice: about 4000 triangles a stone"),
          field("refine_poses", o.refine_poses, "design choice")};
}

std::optional<ObjectModel> model_object(std::span<const LyingObject> lying, const ModellingOptions& options) {
  require(!lying.empty(), "a model needs an object in a scene");
  require_usable(options);
  Prepared all;
  std::vector<Pose> T_W_O;
  for (const LyingObject& one : lying) {
    add_views(one, detection::detection_options(options.segment), all);
    T_W_O.push_back(one.T_W_O);
  }
  ObjectModel model;
  for (std::size_t k = 0; k < all.views.size(); ++k) {
    all.views[k].normal_C = &all.normals[k];
    const auto& shows = all.views[k].shows;
    if (std::find(shows.begin(), shows.end(), 1) != shows.end()) ++model.views;
  }
  require(model.views > 0 && !all.box_O.isEmpty(), "no view shows the object");
  const Eigen::Vector3d margin = Eigen::Vector3d::Constant(kMargin);
  const Eigen::AlignedBox3d box_O(all.box_O.min() - margin, all.box_O.max() + margin);
  if (!DistanceVolume::fits(box_O, options.voxel)) {
    log_info(concat("an object of ", all.box_O.sizes().transpose(), " m is too large for cells of ",
                    options.voxel, " m: give larger cells (modelling.voxel)"));
    return std::nullopt;
  }
  DistanceVolume volume(box_O, options.voxel, options.truncation);
  volume.fuse(all.views, T_W_O);
  volume.complete();
  volume.keep_largest_part();
  model.mesh = surface_of(volume, options.facet);
  if (model.mesh.faces.empty()) {
    log_info("views see through all of an object: it has no model");
    return std::nullopt;
  }
  const double of_one = sigma_of_one(volume, lying);
  for (const auto& p : model.mesh.vertices) {
    model.seen.push_back(volume.weight(p) >= kSeenWeight ? 1 : 0);
    const double views = std::max(1.0, volume.effective_views(p));
    model.sigma.push_back(std::hypot(kSharedSigma, of_one / std::sqrt(views)));
  }
  const std::vector<double> away = distance_to_seen(model.mesh, model.seen);
  for (std::size_t v = 0; v < away.size(); ++v)
    if (model.seen[v] == 0) model.sigma[v] = kSigmaUnseen + kUnseenSlope * std::min(away[v], 0.5);
  model.seen_share = seen_area_share(model.mesh, model.seen);
  return model;
}

std::vector<std::optional<ObjectModel>> model_objects(const AlignedScene& scene,
                                                      const ModellingOptions& options) {
  std::vector<std::optional<ObjectModel>> models;
  for (int object = 0; object < static_cast<int>(scene.segmentation.objects.size()); ++object) {
    throw_if_interrupted();
    const LyingObject lying{&scene, object};
    models.push_back(model_object({&lying, 1}, options));
  }
  return models;
}

}  // namespace stonestack::modelling
