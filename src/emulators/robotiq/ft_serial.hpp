#pragma once
#include <atomic>
#include <thread>

#include "core/serial.hpp"
#include "emulators/robotiq/ft_source.hpp"
#include "protocol/modbus_frame.hpp"

namespace stonestack::emulators {

/// The sensor's serial line: Modbus slave and stream, in a thread of its own.
class FtSerialServer {
 public:
  FtSerialServer(FtSource& source, const FtSimulatorOptions& options);
  ~FtSerialServer();
  FtSerialServer(const FtSerialServer&) = delete;
  FtSerialServer& operator=(const FtSerialServer&) = delete;
  [[nodiscard]] const std::string& path() const { return line_.path(); }

 private:
  void run();
  void listen(double seconds);
  void answer(const modbus::RtuFrame& frame);
  void stream(const FtReading& reading);
  void send(std::span<const std::uint8_t> bytes);
  [[nodiscard]] std::optional<std::uint16_t> register_value(int address);

  FtSource* source_;
  PseudoTerminal line_;
  std::uint8_t unit_;
  bool streaming_;
  std::size_t jammed_ = 0;  // bytes 0xFF running
  modbus::Bytes kept_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace stonestack::emulators
