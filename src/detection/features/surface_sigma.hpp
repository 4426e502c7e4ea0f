#pragma once
#include <cmath>
#include <vector>

#include "detection/scene/preprocess.hpp"
#include "stonestack/stone/stone.hpp"

namespace stonestack::detection {

/// How well a model's surface is known: standard deviations of its distance from the stone's [m]; 0 where the
/// model is a scan. What no view showed when the model was made is known the least.
struct SurfaceSigma {
  std::vector<float> samples;  ///< a sample of the surface each
  std::vector<float> mesh;     ///< a vertex of the mesh each
  std::vector<float> drawn;    ///< a vertex of the mesh that is drawn each
};

/// Standard deviations at the samples and at the vertices of two meshes that stand for the stone's scan.
/// @throws InvalidArgument for a stone whose list has not one entry a vertex of its scan.
[[nodiscard]] SurfaceSigma surface_sigma(const Stone& stone, const SurfacePoints& samples, const Mesh& mesh,
                                         const Mesh& drawn);

/// Mean over the corners of a face [m].
[[nodiscard]] inline double sigma_of_face(const std::vector<float>& vertices, const Eigen::Vector3i& face) {
  double sum = 0.0;
  for (int k = 0; k < 3; ++k) sum += vertices[static_cast<std::size_t>(face[k])];
  return sum / 3.0;
}

/// Seen points of a stone, of some 800, that share one error of the model: it is alike over 15 mm.
inline constexpr double kAlikePoints = 30.0;

/// How far [m] a seen surface may lie off the stone's and be the same, where the model errs by `sigma`, too:
/// two standard deviations. Without an error, `tolerance`.
[[nodiscard]] inline double widened(double tolerance, double sigma) {
  return sigma == 0.0 ? tolerance : std::hypot(tolerance, 2.0 * sigma);
}

/// Weight of a place as evidence: 1 where the model has no error, the less the further the tolerance is
/// widened.
[[nodiscard]] inline double evidence_weight(double tolerance, double sigma) {
  if (sigma == 0.0) return 1.0;
  const double share = tolerance / widened(tolerance, sigma);
  return share * share;
}

}  // namespace stonestack::detection
