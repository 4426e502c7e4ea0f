#include "detection/features/surface_sigma.hpp"

#include "geometry/surface_tree.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::detection {

SurfaceSigma surface_sigma(const Stone& stone, const SurfacePoints& samples, const Mesh& mesh,
                           const Mesh& drawn) {
  SurfaceSigma out;
  out.samples.assign(samples.points.size(), 0.0F);
  out.mesh.assign(mesh.vertices.size(), 0.0F);
  out.drawn.assign(drawn.vertices.size(), 0.0F);
  if (!stone.surface) return out;
  const std::vector<double>& sigma = stone.surface->sigma;
  require(sigma.size() == stone.scan.vertices.size(), "stone ", stone.name, ": its scan has ",
          stone.scan.vertices.size(), " vertices, ", sigma.size(), " with a standard deviation");
  const std::vector<float> of_scan(sigma.begin(), sigma.end());
  const SurfaceTree scan(stone.scan);
  const auto at = [&](const Eigen::Vector3d& p) {
    const int face = scan.nearest(p).face;
    return face < 0
               ? 0.0F
               : static_cast<float>(sigma_of_face(of_scan, stone.scan.faces[static_cast<std::size_t>(face)]));
  };
  for (std::size_t i = 0; i < out.samples.size(); ++i) out.samples[i] = at(samples.points[i].cast<double>());
  for (std::size_t v = 0; v < out.mesh.size(); ++v) out.mesh[v] = at(mesh.vertices[v]);
  for (std::size_t v = 0; v < out.drawn.size(); ++v) out.drawn[v] = at(drawn.vertices[v]);
  return out;
}

}  // namespace stonestack::detection
