#include "protocol/rtde_fields.hpp"

#include <algorithm>
#include <unordered_map>

#include "stonestack/core/error.hpp"

namespace stonestack::protocol {
namespace {

using Type = RtdeType;

constexpr std::array<std::string_view, 10> kTypeNames = {
    "BOOL",   "UINT8",    "UINT32",   "UINT64",       "INT32",
    "DOUBLE", "VECTOR3D", "VECTOR6D", "VECTOR6INT32", "VECTOR6UINT32"};
constexpr std::array<std::size_t, 10> kSizes = {1, 1, 4, 8, 4, 8, 24, 48, 24, 24};

constexpr UrVersion kUpperRegisters3{3, 9, 0, 0}, kUpperRegisters5{5, 3, 0, 0};
constexpr UrVersion kPayload3{3, 11, 0, 0}, kPayload5{5, 5, 1, 0};
constexpr UrVersion kNever{4, 0, 0, 0};        // of PolyScope 3
constexpr UrVersion kAfterGuide{5, 12, 0, 0};  // not among the fields of the guide for 3.15 and 5.11
constexpr int kFirstUpperRegister = 24;        // below: shared with fieldbuses, in every version
constexpr int kRegisters = 48;
constexpr int kFirstSingleBit = 64, kBits = 128;

void add(std::vector<RtdeField>& fields, Type type, std::initializer_list<const char*> names,
         UrVersion cb3 = {}, UrVersion e_series = {}) {
  for (const char* name : names) fields.push_back({name, type, cb3, e_series});
}

/// `prefix` is "input" or "output".
void add_registers(std::vector<RtdeField>& fields, const std::string& prefix) {
  for (const char* range : {"0_to_31", "32_to_63"})
    fields.push_back({prefix + "_bit_registers" + range, Type::kUint32, {}, {}});
  for (int i = kFirstSingleBit; i < kBits; ++i)
    fields.push_back({concat(prefix, "_bit_register_", i), Type::kBool, kUpperRegisters3, kUpperRegisters5});
  for (const auto& [kind, type] :
       {std::pair{"_int_register_", Type::kInt32}, std::pair{"_double_register_", Type::kDouble}})
    for (int i = 0; i < kRegisters; ++i) {
      const bool upper = i >= kFirstUpperRegister;
      fields.push_back({concat(prefix, kind, i), type, upper ? kUpperRegisters3 : UrVersion{},
                        upper ? kUpperRegisters5 : UrVersion{}});
    }
}

void add_motion(std::vector<RtdeField>& f) {
  add(f, Type::kDouble,
      {"timestamp", "actual_execution_time", "target_execution_time", "speed_scaling",
       "target_speed_fraction", "actual_momentum", "tcp_force_scalar"});
  add(f, Type::kVector6d,
      {"target_q", "target_qd", "target_qdd", "target_current", "target_moment", "actual_q", "actual_qd",
       "actual_current", "actual_current_window", "joint_control_output", "actual_TCP_pose",
       "actual_TCP_speed", "actual_TCP_force", "target_TCP_pose", "target_TCP_speed", "joint_temperatures",
       "actual_joint_voltage"});
  add(f, Type::kVector6d, {"payload_inertia"}, {3, 15, 0, 0}, {5, 11, 0, 0});
  add(f, Type::kVector6d, {"ft_raw_wrench"}, kNever, {5, 9, 0, 0});
  add(f, Type::kVector6d, {"wrench_calc_from_currents", "target_base_acceleration", "target_base_wrench"},
      kNever, kAfterGuide);
  add(f, Type::kVector6d, {"actual_current_as_torque", "actual_TCP_acceleration", "target_TCP_acceleration"},
      kNever, {5, 23, 0, 0});
  add(f, Type::kVector6d, {"tcp_offset"}, {3, 12, 3, 0}, {5, 5, 1, 0});
  add(f, Type::kVector3d, {"actual_tool_accelerometer"});
  add(f, Type::kVector3d, {"payload_cog"}, kPayload3, kPayload5);
  add(f, Type::kVector3d, {"target_gravity"}, kNever, kAfterGuide);
  add(f, Type::kVector3d, {"elbow_position", "elbow_velocity"}, {3, 5, 0, 0}, {5, 0, 0, 0});
  add(f, Type::kDouble, {"payload"}, kPayload3, kPayload5);
  // Not in that guide either; but UR's recording example asks every controller for it, whatever its version.
  add(f, Type::kDouble, {"joint_position_deviation_ratio"}, {3, 15, 0, 0}, {5, 11, 0, 0});
  add(f, Type::kDouble, {"collision_detection_ratio"}, kNever, kAfterGuide);
}

void add_modes(std::vector<RtdeField>& f) {
  add(f, Type::kInt32, {"robot_mode", "safety_mode"});
  add(f, Type::kInt32, {"time_scale_source"}, kNever, kAfterGuide);
  add(f, Type::kInt32, {"safety_status"}, {3, 10, 0, 0}, {5, 4, 0, 0});
  add(f, Type::kVector6Int32, {"joint_mode"});
  add(f, Type::kUint32, {"runtime_state", "robot_status_bits", "safety_status_bits"});
  add(f, Type::kUint32, {"script_control_line"}, {3, 14, 0, 0}, {5, 9, 0, 0});
  add(f, Type::kUint64, {"control_step"}, kNever, kAfterGuide);
}

void add_electrics(std::vector<RtdeField>& f) {
  add(f, Type::kDouble,
      {"actual_main_voltage", "actual_robot_voltage", "actual_robot_current", "standard_analog_input0",
       "standard_analog_input1", "standard_analog_output0", "standard_analog_output1", "io_current",
       "tool_analog_input0", "tool_analog_input1", "tool_output_current", "tool_temperature",
       "euromap67_24V_voltage", "euromap67_24V_current", "actual_robot_energy_consumed",
       "actual_robot_braking_energy_dissipated"});
  add(f, Type::kUint32,
      {"analog_io_types", "tool_mode", "tool_analog_input_types", "euromap67_input_bits",
       "euromap67_output_bits"});
  add(f, Type::kInt32, {"tool_output_voltage", "encoder0_raw", "encoder1_raw"});
  add(f, Type::kUint8, {"tool_output_mode", "tool_digital_output0_mode", "tool_digital_output1_mode"});
  add(f, Type::kUint64,
      {"actual_digital_input_bits", "actual_digital_output_bits", "actual_configurable_digital_input_bits",
       "actual_configurable_digital_output_bits"});
}

std::vector<RtdeField> make_outputs() {
  std::vector<RtdeField> fields;
  add_motion(fields);
  add_modes(fields);
  add_electrics(fields);
  add_registers(fields, "output");
  add_registers(fields, "input");
  return fields;
}

std::vector<RtdeField> make_inputs() {
  std::vector<RtdeField> fields;
  add(fields, Type::kUint32, {"speed_slider_mask"});
  add(fields, Type::kDouble,
      {"speed_slider_fraction", "standard_analog_output_0", "standard_analog_output_1"});
  add(fields, Type::kUint8,
      {"standard_digital_output_mask", "standard_digital_output", "configurable_digital_output_mask",
       "configurable_digital_output", "tool_digital_output_mask", "tool_digital_output",
       "standard_analog_output_mask", "standard_analog_output_type"});
  add(fields, Type::kVector6d, {"external_force_torque"}, {3, 3, 0, 0}, {5, 0, 0, 0});
  add_registers(fields, "input");
  return fields;
}

using Index = std::unordered_map<std::string_view, const RtdeField*>;

Index make_index(const std::vector<RtdeField>& fields) {
  Index index;
  for (const RtdeField& field : fields) index.emplace(field.name, &field);
  return index;
}

const RtdeField* look_up(const Index& index, std::string_view name) {
  const auto it = index.find(name);
  return it == index.end() ? nullptr : it->second;
}

template <std::size_t... I>
RtdeValue zero_of(std::size_t type, std::index_sequence<I...>) {
  RtdeValue value;
  ((I == type ? void(value.emplace<I>()) : void()), ...);
  return value;
}

}  // namespace

std::string to_string(const UrVersion& version) {
  return concat(version.major, '.', version.minor, '.', version.bugfix, '.', version.build);
}

std::string_view rtde_type_name(RtdeType type) {
  return kTypeNames.at(static_cast<std::size_t>(type));
}

std::optional<RtdeType> rtde_type(std::string_view name) {
  const auto it = std::find(kTypeNames.begin(), kTypeNames.end(), name);
  if (it == kTypeNames.end()) return std::nullopt;
  return static_cast<RtdeType>(it - kTypeNames.begin());
}

std::size_t rtde_size(RtdeType type) {
  return kSizes.at(static_cast<std::size_t>(type));
}

RtdeValue rtde_zero(RtdeType type) {
  return zero_of(static_cast<std::size_t>(type), std::make_index_sequence<std::variant_size_v<RtdeValue>>{});
}

const std::vector<RtdeField>& rtde_outputs() {
  static const std::vector<RtdeField> fields = make_outputs();
  return fields;
}

const std::vector<RtdeField>& rtde_inputs() {
  static const std::vector<RtdeField> fields = make_inputs();
  return fields;
}

const RtdeField* find_rtde_output(std::string_view name) {
  static const Index index = make_index(rtde_outputs());
  return look_up(index, name);
}

const RtdeField* find_rtde_input(std::string_view name) {
  static const Index index = make_index(rtde_inputs());
  return look_up(index, name);
}

}  // namespace stonestack::protocol
