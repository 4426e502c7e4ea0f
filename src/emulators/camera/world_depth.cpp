#include "simulation/shared_world.hpp"
#include "simulation/true_view.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/emulators/camera/camera_simulator.hpp"

namespace stonestack::emulators {
namespace {

constexpr double kFramePeriod = 1.0 / 30.0;  // s
constexpr double kPatience = 10.0;           // s of the host that the world may stand still

class WorldDepth final : public DepthPlant {
 public:
  explicit WorldDepth(SharedWorld& world)
      : world_(&world),
        sensor_(choose_sensor(world.options())),
        random_(Random::stream(static_cast<std::uint64_t>(world.options().seed), "camera noise")) {
    sensor_.bias_seed =
        Random::stream(static_cast<std::uint64_t>(world.options().seed), "camera bias").bits();
  }

  DepthFrame frame() override {
    if (!world_->wait_until(world_->time() + kFramePeriod, kPatience))
      throw DeviceError("simulated camera", concat("the simulated world stood still for ", kPatience, " s"),
                        "let its time pass");
    DepthFrame frame;
    SeenWorld seen;
    Pose T_W_C;
    {
      const auto access = world_->lock();
      seen = what_is_seen(access.world);
      T_W_C = access.world.gripper_pose().T_W_T * world_->mounting().T_T_C;
      frame.device_time = access.world.time();
    }
    frame.image = true_view(seen, world_->stones(), T_W_C, sensor_, random_);
    frame.number = ++number_;
    return frame;
  }

 private:
  SharedWorld* world_;
  SensorModel sensor_;
  Random random_;
  long number_ = 0;
};

}  // namespace

std::unique_ptr<DepthPlant> make_world_depth(SharedWorld& world) {
  return std::make_unique<WorldDepth>(world);
}

}  // namespace stonestack::emulators
