#pragma once
#include <memory>
#include <optional>

#include "hardware/robotiq/modbus_frame.hpp"
#include "stonestack/core/byte_stream.hpp"
#include "stonestack/hardware/robotiq/modbus.hpp"

namespace stonestack::hardware::modbus {

/// How one attempt ended.
struct Attempt {
  std::optional<Reply> reply;
  std::string problem;  ///< when there is none: what came instead, for a person
  std::string remedy;
};

/// One way to carry requests. `exchange` throws DeviceError only when no link can be made.
class Transport {
 public:
  virtual ~Transport() = default;
  [[nodiscard]] virtual Attempt exchange(const Request& request) = 0;
  /// Makes the link ready to be used again after a failed attempt.
  virtual void recover() = 0;
};
[[nodiscard]] std::unique_ptr<Transport> make_tcp_transport(const ModbusOptions& options);
[[nodiscard]] std::unique_ptr<Transport> make_rtu_transport(const ModbusOptions& options);

}  // namespace stonestack::hardware::modbus
