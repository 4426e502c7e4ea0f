// ROBOT_STATE of the primary and secondary port, and the realtime port's package.
#include <numbers>

#include "emulators/ur/primary_messages.hpp"
#include "protocol/big_endian.hpp"
#include "protocol/primary_wire.hpp"

namespace stonestack::emulators {
namespace {

constexpr std::uint8_t kRobotState = 16;
constexpr float kVolts = 48.0F, kStateWarm = 25.0F;
constexpr std::uint8_t kStateJointRunning = 253, kStateJointIdle = 255, kStateJointOff = 239;
constexpr std::size_t kSafetyData = 38;      // bytes of part 10, in a state of URSim 5.8
constexpr double kJointAcceleration = 40.0;  // rad/s^2, as in the configuration

void put_float(std::string& out, float value) {
  put(out, std::bit_cast<std::uint32_t>(value));
}

void put_six(std::string& out, const Six& values) {
  for (int i = 0; i < 6; ++i) put(out, values[i]);
}

void put_zeros(std::string& out, int count) {
  for (int i = 0; i < count; ++i) put(out, 0.0);
}

std::uint8_t joint_mode(const UrController& c) {
  return c.robot_mode == RobotMode::kRunning ? kStateJointRunning
         : c.robot_mode == RobotMode::kIdle  ? kStateJointIdle
                                             : kStateJointOff;
}

// Sub-package: length with itself, type, data.
void add(std::string& state, std::uint8_t type, const std::string& data) {
  put(state, static_cast<std::uint32_t>(data.size() + 5));
  put(state, type);
  state += data;
}

std::string robot_mode_data(const UrController& c) {
  std::string data;
  const bool powered = c.robot_mode >= RobotMode::kIdle;
  put(data, static_cast<std::uint64_t>(c.timestamp() * 1e9));
  put(data, true);  // real robot connected
  put(data, true);  // enabled
  put(data, powered);
  put(data, c.safety_mode == SafetyMode::kRobotEmergencyStop);
  put(data, c.safety_mode == SafetyMode::kProtectiveStop);
  put(data, c.program_running());
  put(data, c.program_held());
  put(data, static_cast<std::uint8_t>(c.robot_mode));
  put(data, std::uint8_t{0});  // position control
  put(data, c.speed_slider);
  put(data, c.limiter());
  put(data, 1.0);
  if (c.version().has({3, 10, 0, 0}, {5, 4, 0, 0})) put(data, std::uint8_t{0});
  return data;
}

std::string joint_data(const UrController& c) {
  std::string data;
  for (int j = 0; j < 6; ++j) {
    put(data, c.plant().q[j]);
    put(data, c.motion.q()[j]);
    put(data, c.plant().qd[j]);
    put_float(data, 0.0F);
    put_float(data, c.robot_mode >= RobotMode::kIdle ? kVolts : 0.0F);
    put_float(data, kStateWarm);
    put_float(data, 0.0F);
    put(data, joint_mode(c));
  }
  return data;
}

std::string tool_data() {
  std::string data;
  put(data, std::uint8_t{1});
  put(data, std::uint8_t{1});
  put_zeros(data, 2);
  put_float(data, kVolts);
  put(data, std::uint8_t{0});
  put_float(data, 0.0F);
  put_float(data, kStateWarm);
  put(data, kStateJointRunning);
  return data;
}

std::string masterboard_data(const UrController& c) {
  std::string data;
  put(data, static_cast<std::uint32_t>(c.io.digital_in));
  put(data, static_cast<std::uint32_t>(c.io.digital_out));
  put(data, std::uint8_t{1});
  put(data, std::uint8_t{1});
  put_zeros(data, 2);
  for (unsigned i = 0; i < 2; ++i) put(data, static_cast<std::uint8_t>(c.io.analog_out_types >> i & 1U));
  for (const double share : c.io.analog_out) put(data, share);
  put_float(data, kStateWarm);
  put_float(data, kVolts);
  put_float(data, 0.3F);
  put_float(data, 0.0F);
  put(data, static_cast<std::uint8_t>(c.safety_mode));
  put(data, std::uint8_t{0});  // not in reduced mode
  put(data, std::uint8_t{0});  // no Euromap 67
  // UR's own; in a state of URSim 5.8 it is the checksum of the safety configuration once more.
  put(data, parse_checksum(c.options().safety_checksum).value_or(0));
  put(data, std::uint8_t{0});
  put(data, std::uint8_t{0});
  if (c.version().has({3, 10, 0, 0}, {5, 4, 0, 0})) put(data, std::uint8_t{0});
  return data;
}

void put_dh(std::string& data, const RobotModel& robot, bool theta_first) {
  const double quarter = std::numbers::pi / 2;
  Six theta = Six::Zero(), a, d, alpha;
  a << 0, robot.a2, robot.a3, 0, 0, 0;
  d << robot.d1, 0, 0, robot.d4, robot.d5, robot.d6;
  alpha << quarter, 0, 0, quarter, -quarter, 0;
  if (theta_first) put_six(data, theta);
  put_six(data, a);
  put_six(data, d);
  put_six(data, alpha);
  if (!theta_first) put_six(data, theta);
}

std::string kinematics_info(const UrController& c) {
  std::string data;
  for (int i = 0; i < 6; ++i) put(data, std::uint32_t{0xFFFFFFFF});  // checksums of an uncalibrated arm
  put_dh(data, c.motion.geometry().robot(), true);
  put(data, std::uint32_t{0});
  return data;
}

// 1 UR5, 2 UR10, 3 UR3, 4 UR16; by the model's first digits.
std::int32_t robot_type(const std::string& model) {
  if (model.find("16") != std::string::npos) return 4;
  if (model.find("10") != std::string::npos) return 2;
  return model.find('3') != std::string::npos ? 3 : 1;
}

std::string configuration_data(const UrController& c) {
  const auto& robot = c.motion.geometry().robot();
  std::string data;
  for (int j = 0; j < 6; ++j) {
    put(data, robot.lower[j]);
    put(data, robot.upper[j]);
  }
  for (int j = 0; j < 6; ++j) {
    put(data, robot.velocity[j]);
    put(data, kJointAcceleration);
  }
  for (const double preset : {1.047, 1.396, 0.25, 1.2, 0.25}) put(data, preset);  // v, a, tool v, a, radius
  put_dh(data, robot, false);
  put(data, static_cast<std::int32_t>(c.version().is_cb3() ? 4 : 6));
  put(data, static_cast<std::int32_t>(c.version().is_cb3() ? 3 : 4));
  put(data, robot_type(c.options().model));
  put(data, static_cast<std::int32_t>(c.version().is_cb3() ? 1 : 3));
  return data;
}

}  // namespace

std::string encode_robot_state(const UrController& c) {
  const auto& geometry = c.motion.geometry();
  std::string state;
  put(state, kRobotState);
  add(state, 0, robot_mode_data(c));
  add(state, 1, joint_data(c));
  std::string data;
  put_six(data, urscript::to_vector(geometry.T_B_P(c.plant().q)));
  put_six(data, urscript::to_vector(geometry.T_F_P));
  add(state, 4, data);
  add(state, 5, kinematics_info(c));
  add(state, 9, std::string(48, '\0'));
  add(state, 3, masterboard_data(c));
  add(state, 2, tool_data());
  add(state, 6, configuration_data(c));
  data.clear();
  put_six(data, c.wrench());
  put(data, 0.0);  // dexterity
  add(state, 7, data);
  add(state, 8, std::string("\0\1\0\1", 4));
  if (const auto checksum = parse_checksum(c.options().safety_checksum)) {
    data.clear();
    put(data, *checksum);
    data.resize(kSafetyData, '\0');
    add(state, 10, data);
  }
  std::string whole;
  put(whole, static_cast<std::uint32_t>(state.size() + 4));
  return whole + state;
}

std::string encode_realtime(const UrController& c) {
  const auto& geometry = c.motion.geometry();
  const auto& v = c.version();
  std::string data;
  put(data, c.timestamp());
  put_six(data, c.motion.q());
  put_six(data, c.motion.qd() * c.scaling());
  put_six(data, c.motion.qdd());
  put_zeros(data, 12);  // target currents and moments
  put_six(data, c.plant().q);
  put_six(data, c.plant().qd);
  put_zeros(data, 12);  // actual currents, joint control currents
  put_six(data, urscript::to_vector(geometry.T_B_P(c.plant().q)));
  put_six(data, geometry.twist(c.plant().q, c.plant().qd));
  put_six(data, c.wrench());
  put_six(data, urscript::to_vector(geometry.T_B_P(c.motion.q())));
  put_six(data, geometry.twist(c.motion.q(), c.motion.qd() * c.scaling()));
  put(data, static_cast<double>(c.io.digital_in));
  put_six(data, Six::Constant(kStateWarm));
  put(data, c.period());
  put(data, 0.0);  // UR's own
  put(data, static_cast<double>(c.robot_mode));
  put_six(data, Six::Constant(joint_mode(c)));
  put(data, static_cast<double>(c.safety_mode));
  put_zeros(data, 6);
  put_zeros(data, 3);  // tool accelerometer
  put_zeros(data, 6);
  put(data, c.limiter());
  put(data, 0.0);  // momentum
  put_zeros(data, 2);
  put(data, static_cast<double>(kVolts));
  put(data, static_cast<double>(kVolts));
  put(data, 0.3);
  put_six(data, Six::Constant(kVolts));
  put(data, static_cast<double>(c.io.digital_out));
  put(data, static_cast<double>(c.runtime()));
  if (v.has({3, 5, 0, 0}, {5, 0, 0, 0})) put_zeros(data, 6);  // elbow position and speed
  if (v.has({3, 10, 0, 0}, {5, 4, 0, 0})) put(data, static_cast<double>(c.safety_mode));
  if (v.has({3, 14, 0, 0}, {5, 9, 0, 0})) put_zeros(data, 3);
  if (v.has({3, 15, 0, 0}, {5, 10, 0, 0})) {
    put(data, c.payload);
    for (int i = 0; i < 3; ++i) put(data, c.payload_cog[i]);
    put_zeros(data, 6);  // inertia
  }
  std::string whole;
  put(whole, static_cast<std::uint32_t>(data.size() + 4));
  return whole + data;
}

}  // namespace stonestack::emulators
