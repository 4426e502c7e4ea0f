#include "hardware/ur/ur_force_torque.hpp"

#include <array>

#include "hardware/constants.hpp"
#include "hardware/ur/ur_status.hpp"
#include "hardware/wrench_readings.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::hardware {
namespace {

constexpr const char* kRawWrench = "ft_raw_wrench";
constexpr std::uint32_t kFirstWithSensor = 5;      // PolyScope of the e-Series
constexpr UrVersion kFirstWithWrench{5, 9, 0, 0};  // RTDE guide
constexpr UrVersion kNeverOnCb{kFirstWithSensor, 0, 0, 0};

RtdeOptions rtde_options(RtdeOptions options, const FtSensorOptions& sensor) {
  options.frequency = kOwnSensorRate;
  options.stale_after = sensor.stale;
  return options;
}

Wrench raw_wrench(const RtdeSample& sample) {
  const auto six = sample.get<std::array<double, 6>>(kRawWrench);
  Wrench wrench;
  wrench.force = Eigen::Vector3d(six.data());
  wrench.torque = Eigen::Vector3d(six.data() + 3);
  wrench.device_time = sample.device_time();
  wrench.host_time = sample.host_time();
  return wrench;
}

}  // namespace

RtdeRecipeFor own_sensor_recipe(const std::string& address) {
  return [address](const UrVersion& version) {
    const std::string name = "UR controller at " + address;
    static_cast<void>(served_recipe(address)(version));  // refuses PolyScope X
    if (version.major < kFirstWithSensor)
      throw DeviceError(
          name,
          concat("PolyScope ", to_string(version),
                 " drives a CB-series arm, which has no force sensor: its force is estimated from "
                 "motor currents"),
          "mount a Robotiq FT150 or FT300 and write force_torque.link: ur_cap or serial");
    if (!version.has(kNeverOnCb, kFirstWithWrench))
      throw DeviceError(name,
                        concat("PolyScope ", to_string(version), " has no ", kRawWrench,
                               ", and its actual_TCP_force is zeroed with every program and payload"),
                        "update the controller to PolyScope 5.9 or later");
    return RtdeRecipe{{kRawWrench}, {}, {}};
  };
}

UrForceTorque::UrForceTorque(const UrArmOptions& arm, const FtSensorOptions& sensor)
    : options_(sensor),
      name_("force sensor of the UR arm at " + arm.address),
      rtde_({arm.address, arm.rtde_port}, own_sensor_recipe(arm.address), rtde_options(arm.rtde, sensor)) {
  const auto first = rtde_.wait_for_next(Deadline::in(arm.rtde.reply_timeout));
  if (!first)
    throw DeviceError(name_, concat("no reading within ", arm.rtde.reply_timeout, " s"),
                      "look at the controller's state");
  zero_ = raw_wrench(*first);
}

RtdeSample UrForceTorque::next_sample() {
  try {
    if (RtdeSample held = rtde_.sample(); held.device_time() != last_time_) return held;
  } catch (const DeviceError&) {  // too old; what comes now counts
  }
  if (auto next = rtde_.wait_for_next(Deadline::in(options_.stale))) return *next;
  static_cast<void>(rtde_.sample());  // throws with the reason
  throw DeviceError(name_, concat("no new reading for ", options_.stale, " s"),
                    "stop the motion; check the network to the controller");
}

Wrench UrForceTorque::read() {
  const Wrench raw = raw_wrench(next_sample());
  equal_ = last_time_ >= 0 && raw.force == last_.force && raw.torque == last_.torque ? equal_ + 1 : 0;
  last_ = raw;
  last_time_ = raw.device_time;
  if (options_.stuck_samples > 0 && equal_ >= options_.stuck_samples)
    throw DeviceError(name_, concat("repeats one reading, ", equal_, " times running"),
                      "switch the arm off and on; the sensor no longer measures");
  Wrench wrench = raw;
  wrench.force -= zero_.force;
  wrench.torque -= zero_.torque;
  require_in_range(name_, wrench, options_.max_force, options_.max_torque);
  return wrench;
}

void UrForceTorque::zero() {
  const Wrench mean = mean_at_rest(name_, [this] { return read(); });
  zero_.force += mean.force;
  zero_.torque += mean.torque;
}

}  // namespace stonestack::hardware
