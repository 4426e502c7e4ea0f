#include "emulators/robotiq/ft_simulator.hpp"
#include "simulation/shared_world.hpp"

namespace stonestack::emulators {
namespace {

class WorldWrench final : public WrenchPlant {
 public:
  explicit WorldWrench(SharedWorld& world)
      : world_(&world), sensor_(world.lock().world, world.mounting(), world.options()) {}
  Wrench sample(double /*seconds*/) override {
    const auto access = world_->lock();
    return sensor_.measure();
  }

 private:
  SharedWorld* world_;
  SimulatedForceTorque sensor_;
};

}  // namespace

std::unique_ptr<WrenchPlant> make_world_wrench(SharedWorld& world) {
  return std::make_unique<WorldWrench>(world);
}

}  // namespace stonestack::emulators
