#pragma once
#include <memory>
#include <optional>

#include "core/byte_stream.hpp"
#include "hardware/robotiq/modbus.hpp"
#include "protocol/modbus_frame.hpp"

namespace stonestack::hardware {

/// How one attempt ended.
struct ModbusAttempt {
  std::optional<modbus::Reply> reply;
  std::string problem;  ///< when there is none: what came instead, for a person
  std::string remedy;
};

/// Transport of requests. `exchange` throws DeviceError only when no link can be made.
class ModbusTransport {
 public:
  virtual ~ModbusTransport() = default;
  [[nodiscard]] virtual ModbusAttempt exchange(const modbus::Request& request) = 0;
  /// Makes the link ready to be used again after a failed attempt.
  virtual void recover() = 0;
};
[[nodiscard]] std::unique_ptr<ModbusTransport> make_modbus_tcp(const ModbusOptions& options);
[[nodiscard]] std::unique_ptr<ModbusTransport> make_modbus_rtu(const ModbusOptions& options);

}  // namespace stonestack::hardware
