#include "simulation/foreign_object.hpp"

#include <cmath>

#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::simulation {
namespace {

constexpr double kNarrowest = 0.04, kWidest = 0.09;  // m, of any side or diameter: a carton, a can
constexpr double kDensity = 600.0;                   // kg/m^3
constexpr int kSectors = 32;

/// Upright, its centre at the origin.
Mesh make_cylinder(double diameter, double height) {
  Mesh mesh;
  for (const double z : {-0.5 * height, 0.5 * height}) {
    mesh.vertices.emplace_back(0, 0, z);
    for (int k = 0; k < kSectors; ++k) {
      const double angle = 6.283185307179586 * k / kSectors;
      mesh.vertices.emplace_back(0.5 * diameter * std::cos(angle), 0.5 * diameter * std::sin(angle), z);
    }
  }
  constexpr int kTop = kSectors + 1;
  for (int k = 0; k < kSectors; ++k) {
    const int a = 1 + k, b = 1 + (k + 1) % kSectors;
    mesh.faces.emplace_back(0, b, a);
    mesh.faces.emplace_back(kTop, kTop + a, kTop + b);
    mesh.faces.emplace_back(a, b, kTop + b);
    mesh.faces.emplace_back(a, kTop + b, kTop + a);
  }
  return mesh;
}

}  // namespace

std::vector<Stone> make_foreign_objects(const SimulationOptions& options) {
  std::vector<Stone> objects;
  for (int k = 0; k < options.foreign_objects; ++k) {
    Random random = Random::stream(static_cast<std::uint64_t>(options.seed), concat("foreign object ", k));
    const auto size = [&] { return random.uniform(kNarrowest, kWidest); };
    const double x = size(), y = size(), z = size();
    Stone object;
    object.name = concat("foreign_", k + 1);
    object.scan = object.mesh = k % 2 == 0 ? make_box({x, y, z}) : make_cylinder(x, z);
    object.density = kDensity;
    object.mass = mass_properties(object.scan, kDensity);
    object.source = "foreign object";
    objects.push_back(object);
  }
  return objects;
}

}  // namespace stonestack::simulation
