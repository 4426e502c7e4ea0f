#include "physics/shake.hpp"

#include <cmath>
#include <numbers>

namespace stonestack::physics {
namespace {

constexpr double kRest = 0.5;  ///< after a shake [s]

}  // namespace

void shake_world(RigidWorld& world, const Shake& shake, const Eigen::Vector3d& direction, double step) {
  const Eigen::Vector3d g(0, 0, -WorldOptions{}.gravity);
  for (double t = 0; t < shake.seconds; t += step) {
    const double swing = std::sin(2 * std::numbers::pi * shake.frequency * t);
    world.set_gravity(g - shake.acceleration * swing * direction);
    world.step(step);
  }
  world.set_gravity(g);
  const long steps = std::max(1L, std::lround(kRest / step));
  for (long i = 0; i < steps; ++i) world.step(step);
}

}  // namespace stonestack::physics
