#pragma once
#include <Eigen/Core>
#include <cstdint>

#include "stonestack/core/rooms.hpp"

namespace stonestack::stone {

/// Seeded gradient noise in space (Perlin 1985, with the quintic fade of 2002): smooth, about in [-1, 1],
/// zero at whole-number points, features of size 1. Gradients come from a hash of the lattice point, so
/// nothing is stored and any point may be asked.
class GradientNoise {
 public:
  explicit GradientNoise(std::uint64_t seed) : seed_(seed) {}
  [[nodiscard]] double operator()(const Eigen::Vector3d& p) const;
  /// Sum of `count` octaves, each half as wide and `gain` times as high as the one before.
  [[nodiscard]] double octaves(const Eigen::Vector3d& p, int count, double gain = 0.5) const;

 private:
  std::uint64_t seed_;
};

}  // namespace stonestack::stone
