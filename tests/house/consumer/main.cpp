// What a user's program does: a library call from an installed stonestack.
#include <stonestack/core/random.hpp>
#include <stonestack/geometry/mesh.hpp>

int main() {
  const auto box = stonestack::geometry::make_box({0.1, 0.1, 0.1});
  const double mass = stonestack::geometry::mass_properties(box, 2600.0).mass;
  return mass > 2.59 && mass < 2.61 && stonestack::core::Random(1).uniform() < 1.0 ? 0 : 1;
}
