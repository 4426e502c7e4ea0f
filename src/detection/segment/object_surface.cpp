#include "detection/segment/object_surface.hpp"

#include <algorithm>
#include <cmath>

#include "detection/constants.hpp"
#include "detection/scene/plane_outline.hpp"
#include "detection/scene/preprocess.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::detection {
namespace {

constexpr double kNoiseHeights = 4.0;  // times the noise about the table: lower may be the table
constexpr double kTableNoise = 3.0;    // times the noise: so near the plane counts as seen table
constexpr double kHighest = 0.7;       // m above the table: objects to be picked end below
constexpr double kBeyondTable = 0.03;  // m outside the outline of the seen table
constexpr int kOutlineStride = 4;      // px between the points that make the outline
constexpr int kFewestDepths = 200;     // of the whole image

/// Outline of the seen table.
PlaneOutline outline_of_table(const ObjectSurface& surface, double tolerance) {
  const CameraIntrinsics& camera = surface.depth.camera;
  std::vector<Eigen::Vector3d> seen;
  for (int v = 0; v < camera.height; v += kOutlineStride)
    for (int u = 0; u < camera.width; u += kOutlineStride) {
      const Eigen::Vector3d p = surface.points[static_cast<std::size_t>(v * camera.width + u)].cast<double>();
      if (p.z() > 0 && std::abs(surface.table_V->distance(p)) < tolerance) seen.push_back(p);
    }
  return {*surface.table_V, seen};
}

}  // namespace

DetectionOptions detection_options(const SegmentOptions& options) {
  DetectionOptions out;
  out.nearest = options.nearest;
  out.farthest = options.farthest;
  out.seed = options.seed;
  return out;
}

ObjectSurface object_surface(const DepthImage& image, const std::optional<Plane>& expected_V,
                             const SegmentOptions& options) {
  const DetectionOptions shared = detection_options(options);
  ObjectSurface surface;
  surface.depth = smooth_depth(image, shared);
  const auto depths =
      std::count_if(surface.depth.z.begin(), surface.depth.z.end(), [](float z) { return z > 0; });
  if (depths < kFewestDepths) {
    surface.note = out_of_range(image, shared);
    if (surface.note.empty())
      surface.note = concat("only ", depths, " pixels lie on a surface; it takes ", kFewestDepths,
                            ": take the picture again, nearer or without sun light");
    return surface;
  }
  surface.table_V = find_table(surface.depth, expected_V, shared);
  if (!surface.table_V) {
    surface.note =
        "no plane on which objects could stand: it must fill a twentieth of the depths and have hardly any "
        "below it; let the camera see more of the table";
    return surface;
  }
  const double noise = noise_about(*surface.table_V, surface.depth, kTableTolerance).deviation;
  surface.lowest = std::max(kMinHeight, kNoiseHeights * noise);
  const CameraIntrinsics& camera = surface.depth.camera;
  surface.points.assign(surface.depth.z.size(), Eigen::Vector3f::Zero());
  surface.shown.assign(surface.depth.z.size(), 0);
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u)
      if (const double z = surface.depth.at(u, v); z > 0)
        surface.points[static_cast<std::size_t>(v * camera.width + u)] =
            (z * deproject(camera, u, v)).cast<float>();
  const auto outline = outline_of_table(surface, std::max(kTableTolerance, kTableNoise * noise));
  for (std::size_t i = 0; i < surface.points.size(); ++i) {
    const Eigen::Vector3d p = surface.points[i].cast<double>();
    if (p.z() <= 0) continue;
    const double height = surface.table_V->distance(p);
    surface.shown[i] =
        height > surface.lowest && height < kHighest && outline.margin(p) > -kBeyondTable ? 1 : 0;
  }
  return surface;
}

}  // namespace stonestack::detection
