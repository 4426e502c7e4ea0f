#pragma once
#include <functional>
#include <memory>
#include <mutex>
#include <thread>

#include "core/serial.hpp"
#include "emulators/tcp_service.hpp"
#include "protocol/modbus_frame.hpp"
#include "stonestack/emulators/robotiq/modbus_faults.hpp"

namespace stonestack::emulators {

/// Carries out a request that is well formed: the registers read, or an exception. Thread-safe.
using ModbusHandler = std::function<std::variant<std::vector<std::uint16_t>, modbus::Exception>(
    const modbus::Request& request)>;

/// Armed faults, shared by the servers of one device. Thread-safe.
class ModbusFaultBox {
 public:
  void set(const ModbusFaults& faults);
  /// True if the counted fault is armed; uses one up.
  [[nodiscard]] bool take(int ModbusFaults::*fault);
  [[nodiscard]] ModbusFaults now();

 private:
  std::mutex mutex_;
  ModbusFaults faults_;
};

/// Answer of a server to a request: maybe nothing.
struct ModbusAnswer {
  modbus::Bytes pdu;
  bool silent = false;
  bool refused = false;  ///< an exception of the device's own making, which a serial gripper keeps to itself
};
/// The part that TCP and RTU have in common: parse, faults, handle.
[[nodiscard]] ModbusAnswer answer_modbus(modbus::View pdu, const ModbusHandler& handler,
                                         ModbusFaultBox& faults);

/// A Modbus/TCP server. Echoes transaction and unit id; every unit id is served.
class ModbusTcpServer {
 public:
  ModbusTcpServer(const ListenOptions& options, ModbusHandler handler, ModbusFaultBox& faults);
  [[nodiscard]] const Endpoint& endpoint() const { return service_->endpoint(); }
  [[nodiscard]] int clients() { return service_->clients(); }

 private:
  void serve(TcpStream& stream);
  [[nodiscard]] bool reply(TcpStream& stream, const modbus::TcpHeader& header, const ModbusAnswer& answer);

  ModbusHandler handler_;
  ModbusFaultBox* faults_;
  std::unique_ptr<TcpService> service_;
};

/// A Modbus/RTU slave on a pseudo terminal. Answers its own unit id only; requests that it cannot parse and
/// functions that it does not know get no answer.
class ModbusRtuServer {
 public:
  /// `link`: see PseudoTerminal::open.
  ModbusRtuServer(const std::string& link, int unit, ModbusHandler handler, ModbusFaultBox& faults);
  ~ModbusRtuServer();
  ModbusRtuServer(const ModbusRtuServer&) = delete;
  ModbusRtuServer& operator=(const ModbusRtuServer&) = delete;
  [[nodiscard]] const std::string& path() const { return line_.path(); }

 private:
  void serve();
  void reply(const modbus::RtuFrame& frame);

  PseudoTerminal line_;
  std::uint8_t unit_;
  ModbusHandler handler_;
  ModbusFaultBox* faults_;
  std::thread thread_;
};

}  // namespace stonestack::emulators
