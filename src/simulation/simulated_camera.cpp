#include "simulation/simulated_devices.hpp"
#include "simulation/true_view.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::simulation {
namespace {

constexpr double kFramePeriod = 1.0 / 30.0;  // s

}  // namespace

SimulatedCamera::SimulatedCamera(TrueWorld& world, const std::vector<Stone>& stones,
                                 const TrueMounting& mounting, const SimulationOptions& options)
    : world_(&world),
      stones_(&stones),
      mounting_(mounting),
      sensor_(choose_sensor(options)),
      random_(Random::stream(static_cast<std::uint64_t>(options.seed), "camera noise")) {
  sensor_.bias_seed = Random::stream(static_cast<std::uint64_t>(options.seed), "camera bias").bits();
}

DepthFrame SimulatedCamera::capture() {
  const Progress progress = world_->wait(kFramePeriod);
  if (!progress.stopped.empty())
    throw DeviceError("simulated camera", progress.stopped, "move the arm away and look at the cell");
  const Pose T_W_C = world_->gripper_pose().T_W_T * mounting_.T_T_C;
  DepthFrame frame;
  frame.image = true_view(what_is_seen(*world_), *stones_, T_W_C, sensor_, random_);
  frame.number = ++number_;
  frame.device_time = frame.host_time = world_->time();
  return frame;
}

}  // namespace stonestack::simulation
