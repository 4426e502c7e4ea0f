#pragma once
#include <memory>
#include <string>

#include "core/socket.hpp"
#include "emulators/robotiq/gripper_plant.hpp"
#include "emulators/robotiq/modbus_faults.hpp"

namespace stonestack::emulators {

/// Faults of a simulated gripper behind a healthy wire.
struct GripperFaults {
  bool activation_hangs = false;  ///< the activation never completes
  int fault = 0;                  ///< gFLT that is reported, 0 to 15; 13 to 15 end with a reset
  bool stuck_moving = false;      ///< the axes report motion for ever
  double echo_delay = 0.0;        ///< time [s] until a write is acted upon and echoed
  int ignored_writes = 0;         ///< position commands that are lost (never echoed), from now on
  bool false_object = false;      ///< contact is reported at the requested position
  double slip = 0.0;              ///< counts/s that the closed fingers creep on with a grip on something
};
[[nodiscard]] FieldList fields(GripperFaults& faults);

struct GripperSimulatorOptions {
  bool tcp = true;                    ///< serve Modbus/TCP; of a 2-finger gripper the URCap's text socket
  std::string address = "127.0.0.1";  ///< any 127.x.y.z
  int port = 502;                     ///< 0: a free one
  bool rtu = false;                   ///< serve Modbus/RTU on a pseudo terminal
  std::string link;                   ///< a name for the pseudo terminal, e.g. /tmp/ttyGripper
  int unit = 9;                       ///< on the serial line
  double speed_up = 1.0;              ///< simulated seconds per second, of activation and fingers
};
[[nodiscard]] FieldList fields(GripperSimulatorOptions& options);

/// A gripper that is served, of either kind.
class GripperServer {
 public:
  virtual ~GripperServer() = default;
  /// Where it listens.
  /// @throws InvalidArgument when that link is off.
  [[nodiscard]] virtual Endpoint endpoint() const = 0;
  [[nodiscard]] virtual std::string serial_path() const = 0;
  virtual void set_faults(const GripperFaults& faults) = 0;
  virtual void set_faults(const ModbusFaults& faults) = 0;
};

/// A Robotiq 3-finger gripper for any Modbus master. Both register layouts at once: commands at 0 and 1000,
/// status at 0 and 2000 with functions 3, 4 and 23, commands read back with function 3 at 1000. Every TCP
/// unit id is served. Its own threads serve and move the plant until it is destroyed.
class GripperSimulator final : public GripperServer {
 public:
  /// `plant` must outlive the simulator and is called by its thread only. Throws as TcpListener and
  /// PseudoTerminal do.
  explicit GripperSimulator(GripperPlant& plant, const GripperSimulatorOptions& options = {});
  ~GripperSimulator() override;
  [[nodiscard]] Endpoint endpoint() const override;
  [[nodiscard]] std::string serial_path() const override;
  void set_faults(const GripperFaults& faults) override;
  void set_faults(const ModbusFaults& faults) override;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace stonestack::emulators
