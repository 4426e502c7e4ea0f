#include "simulation/true_shape.hpp"

#include <cmath>

#include "core/constants.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::simulation {
namespace {

constexpr int kWaves = 64;        // that add up to the error
constexpr double kWidth = 0.020;  // m, over which neighbours err alike: of views that were joined askew

/// A smooth random function of place, like a Gaussian process of width kWidth.
struct SmoothError {
  std::vector<Eigen::Vector3d> wave;  // rad/m
  std::vector<double> phase;          // rad

  explicit SmoothError(Random random) {
    for (int k = 0; k < kWaves; ++k) {
      const double x = random.normal(), y = random.normal(), z = random.normal();
      wave.emplace_back(Eigen::Vector3d(x, y, z) / kWidth);
      phase.push_back(random.uniform(0.0, kTwoPi));
    }
  }
  [[nodiscard]] double at(const Eigen::Vector3d& p) const {
    double sum = 0.0;
    for (std::size_t k = 0; k < wave.size(); ++k) sum += std::cos(wave[k].dot(p) + phase[k]);
    return sum;
  }
};

void displace(Mesh& mesh, double size, const Random& random) {
  const SmoothError error(random);
  const auto normals = vertex_normals(mesh);
  std::vector<double> off;
  double squares = 0.0;
  for (const auto& p : mesh.vertices) {
    off.push_back(error.at(p));
    squares += off.back() * off.back();
  }
  const double scale = size / std::sqrt(squares / static_cast<double>(off.size()));
  for (std::size_t i = 0; i < off.size(); ++i) mesh.vertices[i] += scale * off[i] * normals[i];
}

}  // namespace

std::vector<Stone> as_they_are(const std::vector<Stone>& scanned, const SimulationOptions& options) {
  std::vector<Stone> stones = scanned;
  if (options.scan_error <= 0.0) return stones;
  const auto seed = static_cast<std::uint64_t>(options.seed);
  for (Stone& stone : stones)
    displace(stone.scan, options.scan_error, Random::stream(seed, "true surface " + stone.name));
  return stones;
}

}  // namespace stonestack::simulation
