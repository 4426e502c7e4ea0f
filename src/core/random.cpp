#include "stonestack/core/random.hpp"

#include <cmath>

#include "core/constants.hpp"

namespace stonestack::core {
namespace {

std::uint64_t splitmix(std::uint64_t& state) {
  std::uint64_t z = (state += 0x9e3779b97f4a7c15ULL);
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

std::uint64_t rotate_left(std::uint64_t x, int k) {
  return (x << k) | (x >> (64 - k));
}

}  // namespace

Random::Random(std::uint64_t seed) {
  for (auto& word : state_) word = splitmix(seed);
}

Random Random::stream(std::uint64_t seed, std::uint64_t task) {
  std::uint64_t a = seed;
  std::uint64_t b = task ^ 0x6a09e667f3bcc909ULL;
  return Random(splitmix(a) ^ rotate_left(splitmix(b), 23));
}

Random Random::stream(std::uint64_t seed, std::string_view task) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;  // FNV-1a
  for (const char c : task) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  return stream(seed, hash);
}

std::uint64_t Random::bits() {
  const std::uint64_t result = rotate_left(state_[1] * 5, 7) * 9;
  const std::uint64_t t = state_[1] << 17;
  state_[2] ^= state_[0];
  state_[3] ^= state_[1];
  state_[1] ^= state_[2];
  state_[0] ^= state_[3];
  state_[2] ^= t;
  state_[3] = rotate_left(state_[3], 45);
  return result;
}

double Random::uniform() {
  return static_cast<double>(bits() >> 11) * 0x1.0p-53;
}

double Random::uniform(double low, double high) {
  return low + (high - low) * uniform();
}

std::size_t Random::index(std::size_t count) {
  return static_cast<std::size_t>(uniform() * static_cast<double>(count)) % count;
}

double Random::normal() {
  const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform()));
  return radius * std::cos(kTwoPi * uniform());
}

double Random::normal(double mean, double sigma) {
  return mean + sigma * normal();
}

Eigen::Vector3d Random::unit_vector() {
  const double z = uniform(-1.0, 1.0);
  const double angle = uniform(0.0, kTwoPi);
  const double r = std::sqrt(1.0 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

Eigen::Quaterniond Random::rotation() {
  const double u = uniform();
  const double a = kTwoPi * uniform();
  const double b = kTwoPi * uniform();
  const double s = std::sqrt(1.0 - u);
  const double c = std::sqrt(u);
  return {c * std::cos(b), s * std::sin(a), s * std::cos(a), c * std::sin(b)};
}

}  // namespace stonestack::core
