#include "simulation/true_shape.hpp"

#include <cmath>

#include "core/constants.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::simulation {
namespace {

constexpr int kWaves = 64;             // that add up to an error
constexpr double kWaveSpread = 0.25;   // of the wave lengths about their mean, as a share
constexpr double kScanWaves = 0.020;   // m: of views that were joined askew
constexpr double kRoughWaves = 0.003;  // m: finer than what a scanner resolves

/// A smooth random function of place: plane waves of about one length in random directions.
struct SmoothError {
  std::vector<Eigen::Vector3d> wave;  // rad/m
  std::vector<double> phase;          // rad

  SmoothError(double length, Random random) {
    for (int k = 0; k < kWaves; ++k) {
      const double number = kTwoPi / length * random.uniform(1 - kWaveSpread, 1 + kWaveSpread);
      wave.emplace_back(number * random.unit_vector());
      phase.push_back(random.uniform(0.0, kTwoPi));
    }
  }
  [[nodiscard]] double at(const Eigen::Vector3d& p) const {
    double sum = 0.0;
    for (std::size_t k = 0; k < wave.size(); ++k) sum += std::cos(wave[k].dot(p) + phase[k]);
    return sum;
  }
};

/// Adds an error of `size` (root of the mean square over the vertices) to each vertex's offset.
void add_error(std::vector<double>& offset, const Mesh& mesh, double size, const SmoothError& error) {
  if (size <= 0.0) return;
  std::vector<double> off;
  double squares = 0.0;
  for (const auto& p : mesh.vertices) {
    off.push_back(error.at(p));
    squares += off.back() * off.back();
  }
  const double scale = size / std::sqrt(squares / static_cast<double>(off.size()));
  for (std::size_t i = 0; i < off.size(); ++i) offset[i] += scale * off[i];
}

}  // namespace

bool differs_from_scan(const SimulationOptions& options) {
  return options.scan_error > 0.0 || options.scan_roughness > 0.0;
}

std::vector<Stone> as_they_are(const std::vector<Stone>& scanned, const SimulationOptions& options) {
  std::vector<Stone> stones = scanned;
  if (!differs_from_scan(options)) return stones;
  const auto seed = static_cast<std::uint64_t>(options.seed);
  for (Stone& stone : stones) {
    Mesh& mesh = stone.scan;
    std::vector<double> offset(mesh.vertices.size(), 0.0);
    add_error(offset, mesh, options.scan_error,
              SmoothError(kScanWaves, Random::stream(seed, "true surface " + stone.name)));
    add_error(offset, mesh, options.scan_roughness,
              SmoothError(kRoughWaves, Random::stream(seed, "true roughness " + stone.name)));
    const auto normals = vertex_normals(mesh);
    for (std::size_t i = 0; i < offset.size(); ++i) mesh.vertices[i] += offset[i] * normals[i];
  }
  return stones;
}

}  // namespace stonestack::simulation
