#include "stonestack/detection/segment.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "detection/constants.hpp"
#include "detection/scene/seen_normal.hpp"
#include "detection/segment/complete_parts.hpp"
#include "detection/segment/part_tree.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::detection {
namespace {

constexpr int kFewestPixels = 60;         // of a part, however large its pixels are
constexpr int kBorder = 4;                // px: so far from the border the smoothed image is empty, and a bit
constexpr int kGrowth = 3;                // px that parts grow into what smoothing left out
constexpr float kGrowthStep = 0.010F;     // m of depth between neighbours of one part
constexpr double kSameSurface = 0.008;    // m along the line of sight: one surface in two views
constexpr double kOverlap = 0.4;          // of the smaller part's shared surface: the same object
constexpr int kFewestShared = 30;         // pixels of it
constexpr double kOversizeFactor = 0.15;  // confidence that is left to an object twice the usual size
// Logistic fit of the confidence to 682 parts, 24 of them wrong (docs/measurements.md, Segmentation): small
// parts are wrong most often. How long a part stays the same over the cost of merging tells nothing beside.
constexpr double kConfidenceBase = -5.0, kConfidenceSize = 13.0;
constexpr double kMaxConfidence = 0.99;  // large parts, too, are wrong in about one of a hundred cases
constexpr double kSureSize = 60.0;       // px, square root of the pixels from which on size adds nothing

std::string unusable_image(const DepthImage& image) {
  const auto pixels = static_cast<std::size_t>(std::max(0, image.camera.width)) *
                      static_cast<std::size_t>(std::max(0, image.camera.height));
  if (pixels == 0 || image.z.size() != pixels) return "the image is empty or lacks depths";
  if (!(image.camera.fx > 0 && image.camera.fy > 0)) return "the camera has no focal length";
  return {};
}

/// Parts of one view, and where it was taken from.
struct ViewParts {
  Pose T_C_V = Pose::Identity();
  ObjectSurface surface;
  SurfaceParts parts;
};

int fewest_pixels(const ObjectSurface& surface, const SegmentOptions& options) {
  double sum = 0.0;
  int count = 0;
  for (std::size_t i = 0; i < surface.shown.size(); ++i)
    if (surface.shown[i] != 0) sum += surface.depth.z[i], ++count;
  if (count == 0) return kFewestPixels;
  const double pixel = sum / count / surface.focal_length();
  return std::max(kFewestPixels, static_cast<int>(std::lround(std::pow(options.min_width / pixel, 2))));
}

/// Gives pixels at the rims of parts, which smoothing left out, to the part beside them.
void grow(const DepthImage& raw, const ObjectSurface& surface, const Plane& table_V,
          std::vector<int>& label) {
  const CameraIntrinsics& camera = raw.camera;
  for (int turn = 0; turn < kGrowth; ++turn) {
    const std::vector<int> before = label;
    for (int v = 1; v + 1 < camera.height; ++v)
      for (int u = 1; u + 1 < camera.width; ++u) {
        const auto i = static_cast<std::size_t>(v * camera.width + u);
        const float z = raw.z[i];
        if (before[i] >= 0 || !(z > 0) || surface.depth.z[i] > 0) continue;
        if (table_V.distance(z * deproject(camera, u, v)) < surface.lowest) continue;
        const auto w = static_cast<std::size_t>(camera.width);
        for (const std::size_t k : {i - 1, i + 1, i - w, i + w})
          if (before[k] >= 0 && std::abs(raw.z[k] - z) < kGrowthStep) label[i] = before[k];
      }
  }
}

Plane in_first_camera(const Plane& plane_V, const Pose& T_C_V) {
  const Eigen::Vector3d n_C = T_C_V.linear() * plane_V.normal;
  return {n_C, plane_V.offset + n_C.dot(T_C_V.translation())};
}

/// Surface of a view that shows no object.
ObjectSurface blank_surface(const DepthImage& image) {
  ObjectSurface surface;
  surface.depth.camera = image.camera;
  surface.depth.z.assign(image.z.size(), 0.0F);
  return surface;
}

/// Adds the parts of a usable view; none, with the reason, where the view shows no table.
std::string add_view(std::vector<ViewParts>& views, const DepthView& view, const Pose& T_C_V,
                     const std::optional<Plane>& table_C, const SegmentOptions& options) {
  ViewParts& added = views.emplace_back();
  added.T_C_V = T_C_V;
  added.parts.label.assign(view.image.z.size(), -1);
  std::optional<Plane> expected;
  if (table_C)
    expected = Plane{T_C_V.linear().transpose() * table_C->normal,
                     table_C->offset - table_C->normal.dot(T_C_V.translation())};
  DepthImage finite = view.image;
  for (float& z : finite.z)
    if (!std::isfinite(z)) z = 0.0F;
  added.surface = object_surface(finite, expected, options);
  if (!added.surface.note.empty()) return std::exchange(added.surface, blank_surface(view.image)).note;
  added.parts = split_surface(added.surface, fewest_pixels(added.surface, options));
  complete_parts(added.surface, added.parts);
  grow(finite, added.surface, *added.surface.table_V, added.parts.label);
  return {};
}

/// Pixels of part a in one view that fall on part b in another, at the same depth.
using Shared = std::map<std::pair<int, int>, int>;

Shared shared_surface(const ViewParts& from, const ViewParts& to) {
  Shared shared;
  const Pose T_to_from = to.T_C_V.inverse() * from.T_C_V;
  const CameraIntrinsics& camera = to.surface.depth.camera;
  for (std::size_t i = 0; i < from.surface.shown.size(); ++i) {
    if (from.parts.label[i] < 0 || from.surface.depth.z[i] <= 0) continue;
    const Eigen::Vector3d p = T_to_from * from.surface.points[i].cast<double>();
    if (p.z() <= 0) continue;
    const Eigen::Vector2d pixel = (project(camera, p).array() + 0.5).floor();
    if (!((pixel.array() >= 0).all() && pixel.x() < camera.width && pixel.y() < camera.height)) continue;
    const auto k =
        static_cast<std::size_t>(static_cast<int>(pixel.y()) * camera.width + static_cast<int>(pixel.x()));
    if (to.parts.label[k] >= 0 && std::abs(to.surface.depth.z[k] - p.z()) < kSameSurface)
      ++shared[{from.parts.label[i], to.parts.label[k]}];
  }
  return shared;
}

/// Parts of two views that show mostly the same surface.
struct Link {
  double overlap;  ///< share of it, times its pixels
  std::size_t view_a, view_b;
  int a, b;
};

/// Names of the parts of each view.
using Names = std::vector<std::vector<int>>;

bool is_in(const std::vector<int>& names, int name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

/// True if fewer views show two objects as one part than show them apart.
bool are_apart(const Names& names, const std::vector<Link>& links, int a, int b) {
  const auto apart = std::count_if(names.begin(), names.end(), [&](const std::vector<int>& in_view) {
    return is_in(in_view, a) && is_in(in_view, b);
  });
  if (apart == 0) return false;
  std::vector<char> together(names.size(), 0);
  for (const Link& link : links) {
    const int of_a = names[link.view_a][static_cast<std::size_t>(link.a)];
    const int of_b = names[link.view_b][static_cast<std::size_t>(link.b)];
    if (!((of_a == a && of_b == b) || (of_a == b && of_b == a))) continue;
    for (const std::size_t view : {link.view_a, link.view_b})
      if (!(is_in(names[view], a) && is_in(names[view], b))) together[view] = 1;
  }
  return std::count(together.begin(), together.end(), 1) <= apart;
}

/// Object of each part of each view: parts that share most of what both views see are one, unless at least as
/// many views show them apart.
Names objects_of(const std::vector<ViewParts>& views) {
  Names name;
  int count = 0;
  for (const ViewParts& view : views) {
    name.emplace_back(view.parts.pixels.size());
    for (int& n : name.back()) n = count++;
  }
  std::vector<Link> links;
  for (std::size_t j = 0; j < views.size(); ++j)
    for (std::size_t k = j + 1; k < views.size(); ++k) {
      const Shared shared = shared_surface(views[j], views[k]);
      std::map<int, int> of_a, of_b;
      for (const auto& [pair, pixels] : shared) of_a[pair.first] += pixels, of_b[pair.second] += pixels;
      for (const auto& [pair, pixels] : shared) {
        const double overlap = static_cast<double>(pixels) / std::min(of_a[pair.first], of_b[pair.second]);
        if (pixels >= kFewestShared && overlap > kOverlap)
          links.push_back({overlap * pixels, j, k, pair.first, pair.second});
      }
    }
  std::stable_sort(links.begin(), links.end(),
                   [](const Link& a, const Link& b) { return a.overlap > b.overlap; });
  for (const Link& link : links) {
    const int a = name[link.view_a][static_cast<std::size_t>(link.a)];
    const int b = name[link.view_b][static_cast<std::size_t>(link.b)];
    if (a == b) continue;
    if (are_apart(name, links, a, b)) continue;
    for (auto& in_view : name)
      for (int& n : in_view)
        if (n == b) n = a;
  }
  return name;
}

/// Extents of points along a plane (longest and across it) and up from it.
Eigen::Vector3d extents_on(const Plane& table_C, const std::vector<Eigen::Vector3f>& points) {
  const Eigen::Vector3d x = table_C.normal.unitOrthogonal(), y = table_C.normal.cross(x);
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Matrix2d outer = Eigen::Matrix2d::Zero();
  std::vector<Eigen::Vector2d> flat;
  double top = 0.0;
  for (const auto& p : points) {
    const Eigen::Vector3d p_C = p.cast<double>();
    flat.emplace_back(x.dot(p_C), y.dot(p_C));
    mean += flat.back();
    top = std::max(top, table_C.distance(p_C));
  }
  mean /= static_cast<double>(flat.size());
  for (const auto& q : flat) outer += (q - mean) * (q - mean).transpose();
  const double angle = 0.5 * std::atan2(2.0 * outer(0, 1), outer(0, 0) - outer(1, 1));
  Eigen::AlignedBox2d box;
  for (const auto& q : flat) box.extend(Eigen::Rotation2Dd(-angle) * q);
  return {box.sizes().maxCoeff(), box.sizes().minCoeff(), top};
}

double confidence_of(const SegmentedObject& object, const SegmentOptions& options) {
  const double width = std::sqrt(static_cast<double>(object.pixels) / object.views);
  const double logit = kConfidenceBase + kConfidenceSize * std::min(1.0, width / kSureSize);
  const double oversize = std::max(0.0, object.size.maxCoeff() / options.usual_size - 1.0);
  return kMaxConfidence * std::pow(kOversizeFactor, oversize) / (1.0 + std::exp(-logit));
}

/// Objects with their clouds, the one with most pixels first; sets the labels.
void describe_objects(const std::vector<ViewParts>& views, const SegmentOptions& options,
                      Segmentation& result) {
  const auto name = objects_of(views);
  struct Gathered {
    SegmentedObject object;
    int name = 0;
  };
  std::map<int, Gathered> found;
  for (std::size_t k = 0; k < views.size(); ++k) {
    const ViewParts& view = views[k];
    const CameraIntrinsics& camera = view.surface.depth.camera;
    std::map<int, bool> in_view;
    for (int v = 0; v < camera.height; ++v)
      for (int u = 0; u < camera.width; ++u) {
        const auto i = static_cast<std::size_t>(v * camera.width + u);
        const int part = view.parts.label[i];
        if (part < 0) continue;
        const int object_name = name[k][static_cast<std::size_t>(part)];
        Gathered& object = found[object_name];
        object.name = object_name;
        ++object.object.pixels;
        in_view[object_name] = true;
        object.object.cut_off |= std::min({u, v, camera.width - 1 - u, camera.height - 1 - v}) < kBorder;
        const Eigen::Vector3d n = seen_normal(view.surface.depth, u, v);
        if (view.surface.depth.z[i] <= 0 || n.isZero()) continue;
        object.object.cloud_C.points.emplace_back(
            (view.T_C_V * view.surface.points[i].cast<double>()).cast<float>());
        object.object.cloud_C.normals.emplace_back((view.T_C_V.linear() * n).cast<float>());
      }
    for (const auto& [object_name, seen] : in_view) ++found[object_name].object.views;
  }
  std::vector<Gathered> sorted;
  for (auto& [object_name, gathered] : found)
    if (!gathered.object.cloud_C.points.empty()) sorted.push_back(std::move(gathered));
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const Gathered& a, const Gathered& b) { return a.object.pixels > b.object.pixels; });
  std::map<int, int> index;
  for (Gathered& gathered : sorted) {
    SegmentedObject& object = gathered.object;
    index[gathered.name] = static_cast<int>(result.objects.size()) + 1;
    Cloud& cloud = object.cloud_C;
    cloud.width = static_cast<int>(cloud.points.size());
    cloud.height = 1;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (const auto& p : cloud.points) sum += p.cast<double>();
    object.p_C_middle = sum / static_cast<double>(cloud.points.size());
    object.size = extents_on(*result.table_C, cloud.points);
    object.confidence = confidence_of(object, options);
    result.objects.push_back(std::move(object));
  }
  for (std::size_t k = 0; k < views.size(); ++k) {
    std::vector<int> label = views[k].parts.label;
    for (int& l : label) l = l < 0 ? 0 : index[name[k][static_cast<std::size_t>(l)]];
    result.labels.push_back(std::move(label));
  }
}

}  // namespace

Segmentation segment(const DepthImage& image, const SegmentOptions& options) {
  const std::array<DepthView, 1> views{DepthView{image, Pose::Identity()}};
  return segment(views, options);
}

Segmentation segment(std::span<const DepthView> views, const SegmentOptions& options) {
  require(!views.empty(), "a scene needs one view at least");
  require(options.nearest > 0 && options.farthest > options.nearest, "depths are looked at from ",
          options.nearest, " to ", options.farthest, " m: the second must be larger, both above 0");
  require(options.min_width > 0 && options.usual_size > 0, "sizes of objects must be above 0, got ",
          options.min_width, " and ", options.usual_size, " m");
  Segmentation result;
  std::vector<ViewParts> parts;
  double lowest = 0.0;  // height from which on surface is an object's, of the first view that shows a table
  for (std::size_t k = 0; k < views.size(); ++k) {
    const Pose T_C_V = k == 0 ? Pose::Identity() : views[0].T_W_C.inverse() * views[k].T_W_C;
    const std::string unusable = unusable_image(views[k].image);
    const std::string problem =
        unusable.empty() ? add_view(parts, views[k], T_C_V, result.table_C, options) : unusable;
    if (!problem.empty())
      result.note += views.size() == 1
                         ? problem
                         : concat(result.note.empty() ? "" : "; ", "view ", k + 1, ": ", problem);
    if (!unusable.empty()) return result;  // it has no pixels that could be labelled
    if (problem.empty() && !result.table_C) {
      result.table_C = in_first_camera(*parts[k].surface.table_V, T_C_V);
      lowest = parts[k].surface.lowest;
    }
  }
  if (!result.table_C) return result;
  describe_objects(parts, options, result);
  if (result.objects.empty())
    result.note += concat(result.note.empty() ? "" : "; ", "nothing stands on the table: no surface ",
                          options.min_width, " m wide lies more than ", lowest, " m above it");
  return result;
}

}  // namespace stonestack::detection
