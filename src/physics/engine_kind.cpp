#include "physics/ode_world.hpp"
#include "physics/world.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::physics {

EngineKind engine_named(const std::string& name) {
  require(name == "bullet" || name == "ode", "no physics engine is called '", name,
          "'; there are bullet and ode");
  return name == "ode" ? EngineKind::kOde : EngineKind::kBullet;
}

std::string to_text(EngineKind engine) {
  return engine == EngineKind::kOde ? "ode" : "bullet";
}

std::unique_ptr<RigidWorld> make_rigid_world(EngineKind engine, const WorldOptions& options) {
  if (engine == EngineKind::kOde) return std::make_unique<OdeWorld>(options);
  return std::make_unique<World>(options);
}

}  // namespace stonestack::physics
