#include "emulators/ur/rtde_access.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <unordered_map>

#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::emulators {
namespace {

using C = const UrController&;

constexpr double kMainVoltage = 48.0, kIdleCurrent = 0.3, kWarm = 25.0;
constexpr std::int32_t kJointRunning = 253, kJointIdle = 255, kJointOff = 239;
constexpr int kElbowLink = 3;

std::array<double, 6> six(const Six& v) {
  return {v[0], v[1], v[2], v[3], v[4], v[5]};
}
std::array<double, 3> three(const Eigen::Vector3d& v) {
  return {v.x(), v.y(), v.z()};
}

Eigen::Vector3d elbow(C c, const Joints& q) {
  const auto& robot = c.motion.geometry().robot();
  return robot.T_R_D.inverse() * link_poses(robot, q)[kElbowLink].translation();
}

std::array<std::int32_t, 6> joint_modes(C c) {
  std::array<std::int32_t, 6> modes;
  modes.fill(c.robot_mode == RobotMode::kRunning ? kJointRunning
             : c.robot_mode == RobotMode::kIdle  ? kJointIdle
                                                 : kJointOff);
  return modes;
}

std::uint32_t bits_from(const std::array<bool, 128>& bits, std::size_t first) {
  std::uint32_t word = 0;
  for (std::size_t i = 0; i < 32; ++i) word |= (bits[first + i] ? 1U : 0U) << i;
  return word;
}

bool powered(C c) {
  return c.robot_mode >= RobotMode::kIdle;
}

using Table = std::unordered_map<std::string, RtdeReader>;

void add_motion(Table& t) {
  t["timestamp"] = [](C c) { return c.timestamp(); };
  t["control_step"] = [](C c) { return std::uint64_t{c.steps()}; };
  t["target_q"] = [](C c) { return six(c.motion.q()); };
  t["target_qd"] = [](C c) { return six(c.motion.qd() * c.scaling()); };
  t["target_qdd"] = [](C c) { return six(c.motion.qdd()); };
  t["actual_q"] = [](C c) { return six(c.plant().q); };
  t["actual_qd"] = [](C c) { return six(c.plant().qd); };
  t["actual_TCP_pose"] = [](C c) { return six(urscript::to_vector(c.motion.geometry().T_B_P(c.plant().q))); };
  t["target_TCP_pose"] = [](C c) {
    return six(urscript::to_vector(c.motion.geometry().T_B_P(c.motion.q())));
  };
  t["actual_TCP_speed"] = [](C c) { return six(c.motion.geometry().twist(c.plant().q, c.plant().qd)); };
  t["target_TCP_speed"] = [](C c) {
    return six(c.motion.geometry().twist(c.motion.q(), c.motion.qd() * c.scaling()));
  };
  t["actual_TCP_force"] = [](C c) { return six(c.wrench()); };
  t["ft_raw_wrench"] = [](C c) { return six(c.raw_wrench()); };
  t["tcp_force_scalar"] = [](C c) { return c.wrench().head<3>().norm(); };
  t["tcp_offset"] = [](C c) { return six(urscript::to_vector(c.motion.geometry().T_F_P)); };
  t["payload"] = [](C c) { return c.payload; };
  t["payload_cog"] = [](C c) { return three(c.payload_cog); };
  t["payload_inertia"] = [](C c) { return six(c.payload_inertia); };
  t["elbow_position"] = [](C c) { return three(elbow(c, c.plant().q)); };
  t["elbow_velocity"] = [](C c) {
    constexpr double kStep = 1e-4;
    return three((elbow(c, c.plant().q + kStep * c.plant().qd) - elbow(c, c.plant().q)) / kStep);
  };
  t["target_gravity"] = [](C) { return std::array<double, 3>{0, 0, 9.82}; };
  t["actual_tool_accelerometer"] = [](C c) {
    return three(c.motion.geometry().T_B_F(c.plant().q).rotation().transpose() *
                 Eigen::Vector3d(0, 0, -9.82));
  };
}

void add_modes(Table& t) {
  t["robot_mode"] = [](C c) { return static_cast<std::int32_t>(c.robot_mode); };
  t["safety_mode"] = [](C c) { return static_cast<std::int32_t>(c.safety_mode); };
  t["safety_status"] = [](C c) { return static_cast<std::int32_t>(c.safety_mode); };
  t["joint_mode"] = [](C c) { return joint_modes(c); };
  t["runtime_state"] = [](C c) { return static_cast<std::uint32_t>(c.runtime()); };
  t["robot_status_bits"] = [](C c) { return c.robot_status_bits(); };
  t["safety_status_bits"] = [](C c) { return c.safety_status_bits(); };
  t["script_control_line"] = [](C c) { return static_cast<std::uint32_t>(c.program_line()); };
  t["speed_scaling"] = [](C c) { return c.limiter(); };
  t["target_speed_fraction"] = [](C c) { return c.speed_slider; };
  t["actual_execution_time"] = t["target_execution_time"] = [](C c) { return c.period(); };
}

void add_electrics(Table& t) {
  t["actual_main_voltage"] = [](C) { return kMainVoltage; };
  t["actual_robot_voltage"] = [](C c) { return powered(c) ? kMainVoltage : 0.0; };
  t["actual_robot_current"] = [](C c) { return powered(c) ? kIdleCurrent : 0.0; };
  t["actual_joint_voltage"] = [](C c) {
    std::array<double, 6> volts;
    volts.fill(powered(c) ? kMainVoltage : 0.0);
    return volts;
  };
  t["joint_temperatures"] = [](C) { return std::array<double, 6>{kWarm, kWarm, kWarm, kWarm, kWarm, kWarm}; };
  t["tool_temperature"] = [](C) { return kWarm; };
  t["actual_digital_input_bits"] = [](C c) { return c.io.digital_in; };
  t["actual_digital_output_bits"] = [](C c) { return c.io.digital_out; };
  t["actual_configurable_digital_input_bits"] = [](C c) { return (c.io.digital_in >> 8) & 0xFFU; };
  t["actual_configurable_digital_output_bits"] = [](C c) { return (c.io.digital_out >> 8) & 0xFFU; };
  // Volts of 0 to 10, or milliamperes of 4 to 20 as amperes.
  t["standard_analog_output0"] = [](C c) {
    return c.io.analog_out_types & 1U ? 10.0 * c.io.analog_out[0] : 0.004 + 0.016 * c.io.analog_out[0];
  };
  t["standard_analog_output1"] = [](C c) {
    return c.io.analog_out_types & 2U ? 10.0 * c.io.analog_out[1] : 0.004 + 0.016 * c.io.analog_out[1];
  };
  t["analog_io_types"] = [](C c) { return 3U | c.io.analog_out_types << 2; };
  t["tool_output_voltage"] = [](C c) { return std::int32_t{c.io.tool_voltage}; };
}

const Table& readers() {
  static const Table table = [] {
    Table t;
    add_motion(t);
    add_modes(t);
    add_electrics(t);
    for (const bool in : {true, false}) {
      const std::string side = in ? "input" : "output";
      const auto bits = in ? &Registers::in_bit : &Registers::out_bit;
      for (std::size_t i = 0; i < 128; ++i)
        t[side + "_bit_register_" + std::to_string(i)] = [=](C c) { return (c.registers.*bits)[i]; };
      for (const std::size_t first : {0U, 32U})
        t[side + "_bit_registers" + std::to_string(first) + "_to_" + std::to_string(first + 31)] = [=](C c) {
          return bits_from(c.registers.*bits, first);
        };
      const auto doubles = in ? &Registers::in_double : &Registers::out_double;
      for (std::size_t i = 0; i < 48; ++i) {
        t[side + "_int_register_" + std::to_string(i)] = [=](C c) {
          return in ? c.registers.in_int[i] : c.registers.seen_int(i, c.steps());
        };
        t[side + "_double_register_" + std::to_string(i)] = [=](C c) { return (c.registers.*doubles)[i]; };
      }
    }
    return t;
  }();
  return table;
}

// The number at the end of a register's name.
std::size_t number_of(const std::string& name) {
  std::size_t number = 0;
  const auto start = name.find_last_not_of("0123456789") + 1;
  std::from_chars(name.data() + start, name.data() + name.size(), number);
  return number;
}

void set_masked(std::uint64_t& bits, unsigned mask, unsigned values, int first, unsigned pins) {
  const std::uint64_t chosen = static_cast<std::uint64_t>(mask & pins) << first;
  bits = (bits & ~chosen) | ((static_cast<std::uint64_t>(values) << first) & chosen);
}

}  // namespace

RtdeReader rtde_reader(const RtdeField& field) {
  const auto it = readers().find(field.name);
  if (it != readers().end()) return it->second;
  return [zero = rtde_zero(field.type)](const UrController&) { return zero; };
}

RtdeWriter rtde_writer(const RtdeField& field) {
  const std::string& name = field.name;
  const auto starts = [&](const char* prefix) { return name.rfind(prefix, 0) == 0; };
  if (starts("input_int_register_"))
    return [i = number_of(name)](UrController& c, const RtdeValue& v) {
      c.registers.in_int[i] = std::get<std::int32_t>(v);
    };
  if (starts("input_double_register_"))
    return [i = number_of(name)](UrController& c, const RtdeValue& v) {
      c.registers.in_double[i] = std::get<double>(v);
    };
  if (starts("input_bit_register_"))
    return [i = number_of(name)](UrController& c, const RtdeValue& v) {
      c.registers.in_bit[i] = std::get<bool>(v);
    };
  if (starts("input_bit_registers"))
    return [first = name == "input_bit_registers0_to_31" ? 0U : 32U](UrController& c, const RtdeValue& v) {
      for (std::size_t i = 0; i < 32; ++i)
        c.registers.in_bit[first + i] = (std::get<std::uint32_t>(v) >> i & 1U) != 0;
    };
  if (name == "external_force_torque")
    return [](UrController& c, const RtdeValue& v) {
      c.external_wrench = Six(std::get<std::array<double, 6>>(v).data());
    };
  return [name](UrController& c, const RtdeValue& v) { c.masked_inputs[name] = v; };
}

void apply_masked_inputs(UrController& controller, const std::vector<std::string>& names) {
  auto& inputs = controller.masked_inputs;
  const auto byte = [&](const char* name) -> unsigned {
    const auto it = inputs.find(name);
    return it == inputs.end() ? 0U : std::get<std::uint8_t>(it->second);
  };
  const auto mask = [&](const char* name) {
    return std::find(names.begin(), names.end(), name) == names.end() ? 0U : byte(name);
  };
  auto& io = controller.io;
  set_masked(io.digital_out, mask("standard_digital_output_mask"), byte("standard_digital_output"), 0, 0xFF);
  set_masked(io.digital_out, mask("configurable_digital_output_mask"), byte("configurable_digital_output"), 8,
             0xFF);
  set_masked(io.digital_out, mask("tool_digital_output_mask"), byte("tool_digital_output"), 16, 0x3);
  const unsigned analog = mask("standard_analog_output_mask"), types = byte("standard_analog_output_type");
  for (unsigned i = 0; i < 2; ++i) {
    if (!(analog >> i & 1U)) continue;
    io.analog_out_types = (io.analog_out_types & ~(1U << i)) | (types & (1U << i));
    const auto it = inputs.find("standard_analog_output_" + std::to_string(i));
    const double wanted = it == inputs.end() ? NAN : std::get<double>(it->second);
    if (!std::isnan(wanted)) io.analog_out[i] = std::clamp(wanted, 0.0, 1.0);
  }
  const auto slider = inputs.find("speed_slider_mask"), fraction = inputs.find("speed_slider_fraction");
  if (slider == inputs.end() || fraction == inputs.end()) return;
  if (std::find(names.begin(), names.end(), "speed_slider_mask") == names.end()) return;
  const double wanted = std::get<double>(fraction->second);
  if (std::get<std::uint32_t>(slider->second) == 1U && wanted >= 0.0 && wanted <= 1.0)
    controller.speed_slider = wanted;
}

}  // namespace stonestack::emulators
