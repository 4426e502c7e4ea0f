#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "stonestack/core/options.hpp"

namespace stonestack::hardware {

/// How to reach a Modbus device, and how patiently.
struct ModbusOptions {
  std::string link = "tcp";           ///< tcp or rtu
  std::string address = "127.0.0.1";  ///< tcp: of the device, or its name in the network
  int port = 502;                     ///< tcp
  std::string device;                 ///< rtu: path of the serial line
  int unit = 2;                       ///< unit (slave) id; a reply by another one is refused
  double reply_timeout = 0.3;         ///< each attempt [s]
  int attempts = 3;                   ///< per call, the first one included
  double quiet = 0.02;                ///< time [s] of silence on a serial line before an attempt is repeated
};
[[nodiscard]] FieldList fields(ModbusOptions& options);

/// A Modbus master for one device. Every call ends within `attempts` x (2 s + `reply_timeout` +
/// 10 `quiet`), and throws DeviceError that names device, address and unit: no connection, no reply, a bad
/// reply with its bytes, a reply by another unit, an exception reply with its code.
///
/// Late replies (an older transaction id) are skipped; a bad CRC or lost framing costs an attempt and, over
/// TCP, the connection, which is then opened again. "Acknowledge" and "busy" are repeated, other exceptions
/// are not. Not for use by two threads at once.
class ModbusClient {
 public:
  /// Connects. `name` is the device's ("Robotiq gripper").
  ModbusClient(std::string name, const ModbusOptions& options);
  ~ModbusClient();
  ModbusClient(ModbusClient&&) noexcept;

  using Registers = std::vector<std::uint16_t>;
  [[nodiscard]] Registers read_holding(int address, int count);  ///< function 3, count 1..125
  [[nodiscard]] Registers read_input(int address, int count);    ///< function 4
  void write_one(int address, std::uint16_t value);              ///< function 6
  void write_many(int address, const Registers& values);         ///< function 16, 1..123 values
  /// "Robotiq gripper at 127.0.0.1:502 unit 2".
  [[nodiscard]] const std::string& name() const;
  /// Attempts that failed and were repeated, since the start.
  [[nodiscard]] long repeated() const;

 private:
  struct Link;
  std::unique_ptr<Link> link_;
};

}  // namespace stonestack::hardware
