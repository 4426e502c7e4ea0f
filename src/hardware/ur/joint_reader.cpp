#include "hardware/ur/joint_reader.hpp"

#include <array>

namespace stonestack::hardware {
namespace {

constexpr double kNextReading = 0.1;  // s; a controller sends one every 2 to 8 ms

RtdeRecipe joint_recipe(const UrVersion& /*version*/) {
  return {{"actual_q"}, {}, {}};
}

}  // namespace

JointReader::JointReader(const UrArmOptions& options)
    : rtde_({options.address, options.rtde_port}, joint_recipe, options.rtde) {}

JointReading JointReader::read() const {
  const auto next = rtde_.wait_for_next(Deadline::in(kNextReading));
  const RtdeSample sample = next ? *next : rtde_.sample();
  return {Eigen::Map<const Joints>(sample.get<std::array<double, 6>>("actual_q").data()),
          sample.device_time()};
}

}  // namespace stonestack::hardware
