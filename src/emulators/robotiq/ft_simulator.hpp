#pragma once
#include <memory>
#include <string>

#include "core/socket.hpp"
#include "stonestack/core/options.hpp"
#include "stonestack/hardware/devices.hpp"

namespace stonestack::simulation {
class SharedWorld;
}

namespace stonestack::emulators {

/// Source of a simulated force sensor's readings.
class WrenchPlant {
 public:
  virtual ~WrenchPlant() = default;
  /// The next sample, before any zeroing; called by one thread, `seconds` after the sample before.
  virtual Wrench sample(double seconds) = 0;
};

/// A wrench that a test sets, with a noise of one count so that no two readings are equal. Thread-safe.
class IdealWrenchPlant final : public WrenchPlant {
 public:
  IdealWrenchPlant();
  ~IdealWrenchPlant() override;
  Wrench sample(double seconds) override;
  void set(const Wrench& wrench);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The wrist of a simulated cell, with its sensor's offset, noise and counts. The world must outlive it.
[[nodiscard]] std::unique_ptr<WrenchPlant> make_world_wrench(SharedWorld& world);

/// Faults of a simulated force sensor. Counts: frames from now on, -1 all.
struct FtFaults {
  bool silent = false;     ///< neither streams nor answers
  bool deaf = false;       ///< streams on, whatever is sent
  bool forgets = false;    ///< a power cycle: the stream ends and must be started again (ends by itself)
  int bad_crc = 0;         ///< serial: one bit flipped
  int lost_bytes = 0;      ///< a frame without its last bytes, the next follows at once
  int noise = 0;           ///< bytes that are no frame, before a frame
  bool split = false;      ///< every frame in two pieces
  bool stuck = false;      ///< one reading repeated
  bool zeros = false;      ///< all zero
  bool saturated = false;  ///< the largest counts that the frame can carry
  double spike = 0.0;      ///< force [N] added to Fz of the next frame
  double drift = 0.0;      ///< N/s on Fz
  double rate = 0.0;       ///< readings/s instead of the right rate; 0: right
  std::string firmware;    ///< what another device would answer; empty: the right one
};
[[nodiscard]] FieldList fields(FtFaults& faults);

struct FtSimulatorOptions {
  bool serial = true;  ///< the sensor's own line, on a pseudo terminal
  std::string link;    ///< a name for it, e.g. /tmp/ttyFT
  int unit = 9;
  bool streaming = false;             ///< the line streams from the start, as a sensor left so does
  bool cap = false;                   ///< the UR cap's servers
  std::string address = "127.0.0.1";  ///< any 127.x.y.z
  int port = 63351;                   ///< stream; 0: a free one
  int command_port = 63350;           ///< "SET ZRO"; 0: a free one
  double rate = 100.0;                ///< readings/s
  double speed_up = 1.0;              ///< simulated seconds per second
};
[[nodiscard]] FieldList fields(FtSimulatorOptions& options);

/// A Robotiq FT150/FT300: Modbus RTU and stream on a pseudo terminal, and the UR cap's stream and command
/// sockets. It streams after 0x0200 is written to register 410, answers nothing meanwhile, and stops after 50
/// bytes 0xFF.
class FtSimulator {
 public:
  /// `plant` must outlive the simulator. Throws as TcpListener and PseudoTerminal do.
  explicit FtSimulator(WrenchPlant& plant, const FtSimulatorOptions& options = {});
  ~FtSimulator();
  [[nodiscard]] std::string serial_path() const;
  [[nodiscard]] Endpoint stream_endpoint() const;
  [[nodiscard]] Endpoint command_endpoint() const;
  void set_faults(const FtFaults& faults);

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace stonestack::emulators
