#include "physics/world.hpp"

namespace stonestack::physics {

FieldList fields(WorldOptions& o) {
  return {field("friction", o.friction, {1e-6, 10.0}, "", "paper §4.1"),
          field("step", o.step, {1e-5, 0.02}, "s", "measured: docs/measurements.md, Contact"),
          field("iterations", o.iterations, {1, 10000}, "", "measured: docs/measurements.md, Contact"),
          field("gravity", o.gravity, {0.0, 100.0}, "m/s^2", "standard"),
          field("contact_gap", o.contact_gap, {0.0, 0.001}, "m", "measured: docs/measurements.md, Contact"),
          field("linear_damping", o.linear_damping, {0.0, 1.0}, "1/s", "ours"),
          field("angular_damping", o.angular_damping, {0.0, 1.0}, "1/s", "ours")};
}

}  // namespace stonestack::physics
