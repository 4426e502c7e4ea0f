#include "stone/gradient_noise.hpp"

#include <cmath>

namespace stonestack::stone {
namespace {

using Lattice = Eigen::Matrix<std::int64_t, 3, 1>;

std::uint64_t mix(std::uint64_t z) {  // finaliser of splitmix64 (Steele, Lea and Flood 2014)
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

/// One of the twelve edge directions of a cube, by a hash of the lattice point.
Eigen::Vector3d gradient(const Lattice& node, std::uint64_t seed) {
  std::uint64_t hash = seed;
  for (int axis = 0; axis < 3; ++axis)
    hash = mix(hash + 0x9e3779b97f4a7c15ULL * static_cast<std::uint64_t>(node[axis] + axis));
  const auto choice = static_cast<int>(hash % 12);
  const double a = (choice & 1) != 0 ? -1.0 : 1.0;
  const double b = (choice & 2) != 0 ? -1.0 : 1.0;
  if (choice < 4) return {a, b, 0.0};
  if (choice < 8) return {a, 0.0, b};
  return {0.0, a, b};
}

double fade(double t) {
  return t * t * t * (t * (t * 6.0 - 15.0) + 10.0);
}

}  // namespace

double GradientNoise::operator()(const Eigen::Vector3d& p) const {
  const Eigen::Vector3d corner = p.array().floor();
  const Lattice base = corner.cast<std::int64_t>();
  const Eigen::Vector3d inside = p - corner;
  double sum = 0.0;
  for (int c = 0; c < 8; ++c) {
    const Eigen::Vector3i step(c & 1, (c >> 1) & 1, (c >> 2) & 1);
    double weight = 1.0;
    for (int axis = 0; axis < 3; ++axis)
      weight *= step[axis] == 1 ? fade(inside[axis]) : 1.0 - fade(inside[axis]);
    const Eigen::Vector3d away = inside - step.cast<double>();
    sum += weight * gradient(base + step.cast<std::int64_t>(), seed_).dot(away);
  }
  return sum;
}

double GradientNoise::octaves(const Eigen::Vector3d& p, int count, double gain) const {
  double sum = 0.0;
  double height = 1.0;
  double frequency = 1.0;
  for (int octave = 0; octave < count; ++octave) {
    // An offset of its own for each octave, or all would be zero at the same points.
    const Eigen::Vector3d shift = Eigen::Vector3d(17.31, 5.77, 29.13) * octave;
    sum += height * (*this)(frequency * p + shift);
    height *= gain;
    frequency *= 2.0;
  }
  return sum;
}

}  // namespace stonestack::stone
