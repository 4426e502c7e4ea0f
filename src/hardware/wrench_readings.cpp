#include "hardware/wrench_readings.hpp"

#include "core/byte_stream.hpp"
#include "hardware/constants.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::hardware {

void require_in_range(const std::string& sensor, const Wrench& wrench, double max_force, double max_torque) {
  const double force = wrench.force.cwiseAbs().maxCoeff(), torque = wrench.torque.cwiseAbs().maxCoeff();
  if (force >= max_force || torque >= max_torque)
    throw DeviceError(sensor,
                      concat("is beyond its range: ", force, " N of ", max_force, " N, ", torque, " Nm of ",
                             max_torque, " Nm"),
                      "stop; if nothing touches the tool, the sensor is damaged or the wrong model is set");
}

Wrench mean_at_rest(const std::string& sensor, const std::function<Wrench()>& next) {
  const Deadline deadline = Deadline::in(kZeroTimeout);
  Wrench mean;
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e9), high = -low;
  for (int i = 0; i < kZeroSamples; ++i) {
    throw_if_interrupted();
    if (deadline.over())
      throw DeviceError(
          sensor, concat("gave ", i, " of ", kZeroSamples, " readings for its zero in ", kZeroTimeout, " s"),
          "check the sensor's rate");
    const Wrench wrench = next();
    mean.force += wrench.force / kZeroSamples;
    mean.torque += wrench.torque / kZeroSamples;
    low = low.cwiseMin(wrench.force);
    high = high.cwiseMax(wrench.force);
  }
  if ((high - low).maxCoeff() > kZeroSpread)
    throw DeviceError(sensor,
                      concat("is not at rest: readings spread over ", (high - low).maxCoeff(), " N (allowed ",
                             kZeroSpread, " N)"),
                      "let the arm come to rest before zeroing");
  return mean;
}

}  // namespace stonestack::hardware
