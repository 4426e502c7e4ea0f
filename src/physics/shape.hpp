#pragma once
#include <memory>
#include <vector>

#include "geometry/signed_distance.hpp"
#include "stonestack/geometry/mesh.hpp"
#include "stonestack/physics/stack.hpp"
#include "stonestack/stone/stone.hpp"

namespace stonestack::physics {

/// How finely a contact shape follows the scan.
struct ShapeOptions {
  double cell = 0.0015;    ///< grid of the signed distance [m]
  double band = 0.012;     ///< distance known around the surface [m]
  double spacing = 0.003;  ///< between surface samples [m]
};

struct SurfaceFeatures;  // private: vertices, convex edges and faces, arranged for contact

/// Physical model of a stone: the full scan's surface and mass. Contact is between the features of the
/// scans (vertex on face, edge on edge), so concave stones touch exactly as they are (no convex pieces, no
/// margin); signed distance and samples serve where nearness is asked for. Immutable; shared between worlds
/// and threads.
struct ContactShape {
  std::string name;
  SignedDistance distance;
  std::vector<SurfaceSample> samples;               ///< in O
  MassProperties mass;                              ///< in O
  double radius = 0.0;                              ///< of the bounding sphere about the centre of mass [m]
  Mesh scan;                                        ///< full resolution, in O: what heightmaps are made from
  std::shared_ptr<const SurfaceFeatures> features;  ///< of `scan`
};
/// Throws InvalidArgument if the scan is not closed or the mass is not possible.
[[nodiscard]] std::shared_ptr<const ContactShape> make_contact_shape(const Mesh& scan,
                                                                     const MassProperties& mass,
                                                                     const std::string& name,
                                                                     const ShapeOptions& options = {});
/// Contact shapes of the stones' scans, as finely as `options` say; in parallel over the list.
[[nodiscard]] ShapeList make_contact_shapes(const std::vector<Stone>& stones, const ShapeOptions& options);

}  // namespace stonestack::physics
