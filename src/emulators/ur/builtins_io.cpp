#include <cmath>

#include "emulators/ur/builtins.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::emulators {
namespace {

// Numbers above 23 (bits above 63) came with 3.9 and 5.3.
std::size_t place(const BuiltinCall& call, std::size_t count) {
  const long long index = integer(arg(call, 0));
  const bool upper = controller(call).version().has({3, 9, 0, 0}, {5, 3, 0, 0});
  if (index < 0 || static_cast<std::size_t>(index) >= (upper ? count : count / 2))
    throw ScriptError{concat("Value error: there is no register ", index)};
  return static_cast<std::size_t>(index);
}

std::int32_t to_int32(const Value& value) {
  return static_cast<std::int32_t>(integer(value));
}

std::uint64_t pin(long long index, int first, int count) {
  if (index < 0 || index >= count) throw ScriptError{concat("Value error: there is no pin ", index)};
  return std::uint64_t{1} << (first + index);
}

std::uint64_t bit(const BuiltinCall& call, int first, int count) {
  return pin(integer(arg(call, 0)), first, count);
}

void set_bit(std::uint64_t& bits, std::uint64_t mask, bool on) {
  bits = on ? bits | mask : bits & ~mask;
}

template <int kFirst, int kCount>
void add_pins(std::vector<Builtin>& list, const char* out, const char* in, const char* read_back) {
  list.push_back({out, {"n", "b"}, 2, [](BuiltinCall& c) {
                    set_bit(controller(c).io.digital_out, bit(c, kFirst, kCount), truth(arg(c, 1)));
                    return Outcome(Value());
                  }});
  list.push_back({in, {"n"}, 1, [](BuiltinCall& c) {
                    return Outcome(Value((controller(c).io.digital_in & bit(c, kFirst, kCount)) != 0));
                  }});
  list.push_back({read_back, {"n"}, 1, [](BuiltinCall& c) {
                    return Outcome(Value((controller(c).io.digital_out & bit(c, kFirst, kCount)) != 0));
                  }});
}

void add_registers(std::vector<Builtin>& list) {
  list.push_back({"read_input_integer_register", {"address"}, 1, [](BuiltinCall& c) {
                    return Outcome(
                        Value(static_cast<long long>(controller(c).registers.in_int[place(c, 48)])));
                  }});
  list.push_back({"read_input_float_register", {"address"}, 1, [](BuiltinCall& c) {
                    return Outcome(Value(controller(c).registers.in_double[place(c, 48)]));
                  }});
  list.push_back({"read_input_boolean_register", {"address"}, 1, [](BuiltinCall& c) {
                    return Outcome(Value(controller(c).registers.in_bit[place(c, 128)]));
                  }});
  list.push_back({"read_output_integer_register", {"address"}, 1, [](BuiltinCall& c) {
                    return Outcome(
                        Value(static_cast<long long>(controller(c).registers.out_int[place(c, 48)])));
                  }});
  list.push_back({"read_output_float_register", {"address"}, 1, [](BuiltinCall& c) {
                    return Outcome(Value(controller(c).registers.out_double[place(c, 48)]));
                  }});
  list.push_back({"read_output_boolean_register", {"address"}, 1, [](BuiltinCall& c) {
                    return Outcome(Value(controller(c).registers.out_bit[place(c, 128)]));
                  }});
  list.push_back({"write_output_integer_register", {"address", "value"}, 2, [](BuiltinCall& c) {
                    controller(c).registers.write_int(place(c, 48), to_int32(arg(c, 1)),
                                                      controller(c).steps());
                    return Outcome(Value());
                  }});
  list.push_back({"write_output_float_register", {"address", "value"}, 2, [](BuiltinCall& c) {
                    controller(c).registers.out_double[place(c, 48)] = finite(arg(c, 1));
                    return Outcome(Value());
                  }});
  list.push_back({"write_output_boolean_register", {"address", "value"}, 2, [](BuiltinCall& c) {
                    controller(c).registers.out_bit[place(c, 128)] = truth(arg(c, 1));
                    return Outcome(Value());
                  }});
}

// Number of an analog port, 0 to `count` - 1.
std::uint32_t analog_port(const BuiltinCall& call, long long count) {
  const long long port = integer(arg(call, 0));
  if (port < 0 || port >= count) throw ScriptError{concat("Value error: there is no analog port ", port)};
  return static_cast<std::uint32_t>(port);
}

// Inputs are volts here, and outputs do not follow the program.
void add_domains(std::vector<Builtin>& list) {
  list.push_back({"set_analog_inputrange", {"port", "range"}, 2, [](BuiltinCall& c) {
                    const bool tool = analog_port(c, 4) >= 2;
                    const long long range = integer(arg(c, 1));
                    if (range < 0 || range > 2 || (range == 1 && !tool))
                      throw ScriptError{
                          concat("Value error: there is no range ", range, " of an analog ",
                                 tool ? "input: 0, 1 or 2" : "input of the controller: 0 or 2")};
                    return Outcome(Value());
                  }});
  list.push_back({"set_analog_outputdomain", {"port", "domain"}, 2, [](BuiltinCall& c) {
                    const std::uint32_t port = analog_port(c, 2);
                    const long long domain = integer(arg(c, 1));
                    if (domain != 0 && domain != 1)
                      throw ScriptError{"Value error: an analog output's domain is 0 (mA) or 1 (V)"};
                    auto& types = controller(c).io.analog_out_types;
                    types = domain == 1 ? types | 1U << port : types & ~(1U << port);
                    return Outcome(Value());
                  }});
  list.push_back({"set_runstate_outputs", {"outputs"}, 1, [](BuiltinCall& c) {
                    const auto* outputs = std::get_if<List>(&arg(c, 0).is);
                    if (outputs == nullptr) throw ScriptError{"Type error: outputs are given as a list"};
                    for (const Value& output : *outputs) static_cast<void>(pin(integer(output), 0, 18));
                    return Outcome(Value());
                  }});
}

}  // namespace

void add_io(std::vector<Builtin>& list) {
  add_registers(list);
  add_pins<0, 8>(list, "set_standard_digital_out", "get_standard_digital_in", "get_standard_digital_out");
  add_pins<8, 8>(list, "set_configurable_digital_out", "get_configurable_digital_in",
                 "get_configurable_digital_out");
  add_pins<16, 2>(list, "set_tool_digital_out", "get_tool_digital_in", "get_tool_digital_out");
  add_pins<0, 18>(list, "set_digital_out", "get_digital_in", "get_digital_out");
  const auto analog = [](BuiltinCall& c) {
    const double share = finite(arg(c, 1));
    if (share < 0 || share > 1) throw ScriptError{"Value error: an analog output goes from 0 to 1"};
    controller(c).io.analog_out[bit(c, 0, 2) == 1 ? 0 : 1] = share;
    return Outcome(Value());
  };
  list.push_back({"set_standard_analog_out", {"n", "f"}, 2, analog});
  list.push_back({"set_analog_out", {"n", "f"}, 2, analog});
  list.push_back({"get_standard_analog_in", {"n"}, 1, [](BuiltinCall&) { return Outcome(Value(0.0)); }});
  add_domains(list);
  list.push_back({"set_tool_voltage", {"voltage"}, 1, [](BuiltinCall& c) {
                    const long long volts = integer(arg(c, 0));
                    if (volts != 0 && volts != 12 && volts != 24)
                      throw ScriptError{"Value error: the tool's voltage is 0, 12 or 24"};
                    controller(c).io.tool_voltage = static_cast<int>(volts);
                    return Outcome(Value());
                  }});
}

}  // namespace stonestack::emulators
