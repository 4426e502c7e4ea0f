#include "stone/possible_stone.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::stone {
namespace {

constexpr double kErrorLength = 0.015;  // m, over which errors of a surface are alike: design choice
constexpr double kTouches = 1e-4;       // m
constexpr double kMaxField = 2.5;       // standard deviations: more would fold thin parts

/// A smooth random field of the variance 1, Gaussian with a Gaussian covariance, as a sum of waves (random
/// Fourier features; Rahimi and Recht 2007).
class SmoothField {
 public:
  explicit SmoothField(Random random) {
    for (Wave& wave : waves_) {
      for (int axis = 0; axis < 3; ++axis) wave.number[axis] = random.normal(0.0, 1.0 / kErrorLength);
      wave.phase = random.uniform(0.0, 2.0 * M_PI);
    }
  }
  [[nodiscard]] double at(const Eigen::Vector3d& p) const {
    double sum = 0.0;
    for (const Wave& wave : waves_) sum += std::cos(wave.number.dot(p) + wave.phase);
    return std::clamp(sum * std::sqrt(2.0 / static_cast<double>(waves_.size())), -kMaxField, kMaxField);
  }

 private:
  struct Wave {
    Eigen::Vector3d number = Eigen::Vector3d::Zero();
    double phase = 0.0;
  };
  std::array<Wave, 40> waves_;
};

/// Raises what was displaced into a table that the stone lay on, and keeps on it what touches it by the
/// model: whatever its shape is, the stone lay there like that.
void keep_on_tables(const Mesh& scan, const std::vector<Eigen::Vector3d>& up_O_at_rest, Mesh& displaced) {
  for (const Eigen::Vector3d& up : up_O_at_rest) {
    double table = std::numeric_limits<double>::infinity();
    for (const Eigen::Vector3d& p : scan.vertices) table = std::min(table, up.dot(p));
    for (std::size_t v = 0; v < scan.vertices.size(); ++v) {
      const double below = table - up.dot(displaced.vertices[v]);
      if (below > 0.0 || up.dot(scan.vertices[v]) < table + kTouches) displaced.vertices[v] += below * up;
    }
  }
}

}  // namespace

Stone possible_stone(Stone stone, int draw) {
  if (!stone.surface) return stone;
  const std::vector<double>& sigma = stone.surface->sigma;
  require(sigma.size() == stone.scan.vertices.size(), "stone ", stone.name, ": its scan has ",
          stone.scan.vertices.size(), " vertices, ", sigma.size(), " with a standard deviation");
  const SmoothField field(Random::stream(static_cast<std::uint64_t>(draw), "surface of " + stone.name));
  const std::vector<Eigen::Vector3d> normals = vertex_normals(stone.scan);
  Mesh displaced = stone.scan;
  for (std::size_t v = 0; v < sigma.size(); ++v)
    displaced.vertices[v] += sigma[v] * field.at(stone.scan.vertices[v]) * normals[v];
  keep_on_tables(stone.scan, stone.surface->up_O_at_rest, displaced);
  const double solid = volume(displaced);
  if (!(solid > 0.0)) return stone;
  MassProperties mass = mass_properties(displaced, stone.mass.mass / solid);
  mass.p_O_M += stone.mass.p_O_M - mass_properties(stone.scan, 1.0).p_O_M;  // as far as it was measured
  if (!check(mass).empty()) return stone;
  stone.scan = std::move(displaced);
  stone.mass = mass;
  return stone;
}

}  // namespace stonestack::stone
