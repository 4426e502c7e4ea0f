#pragma once
#include <Eigen/Geometry>
#include <cstdint>
#include <string_view>

#include "stonestack/core/rooms.hpp"

#pragma GCC visibility push(default)

namespace stonestack::core {

/// Seeded random numbers with distributions of our own, so that a seed means the same on every
/// platform. Streams are independent: `stream(seed, task)` for task i never depends on how many
/// numbers task j drew, nor on threads. Generator: xoshiro256** (Blackman and Vigna 2018), seeded
/// by splitmix64.
class Random {
 public:
  /// Stream that a seed begins; the same seed gives the same draws.
  explicit Random(std::uint64_t seed);
  /// The stream of one task of a seeded job.
  [[nodiscard]] static Random stream(std::uint64_t seed, std::uint64_t task);
  /// The stream of a named task, e.g. `stream(seed, "sensor noise")`.
  [[nodiscard]] static Random stream(std::uint64_t seed, std::string_view task);

  /// 64 random bits.
  std::uint64_t bits();
  /// Uniform in [0, 1).
  double uniform();
  /// Uniform in [low, high).
  double uniform(double low, double high);
  /// Uniform integer in [0, count); `count` >= 1.
  std::size_t index(std::size_t count);
  /// Standard normal (Box and Muller, no value kept back).
  double normal();
  /// Normal with the given mean and standard deviation.
  double normal(double mean, double sigma);
  /// Uniform on the unit sphere.
  Eigen::Vector3d unit_vector();
  /// Uniform over rotations (Shoemake 1992).
  Eigen::Quaterniond rotation();

  /// Shuffles [first, last) (Fisher and Yates).
  template <class Iterator>
  void shuffle(Iterator first, Iterator last) {
    for (auto n = static_cast<std::size_t>(last - first); n > 1; --n)
      std::swap(first[static_cast<std::ptrdiff_t>(n - 1)], first[static_cast<std::ptrdiff_t>(index(n))]);
  }

 private:
  std::uint64_t state_[4];
};

}  // namespace stonestack::core

#pragma GCC visibility pop
