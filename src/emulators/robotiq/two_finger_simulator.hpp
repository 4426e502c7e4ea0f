#pragma once
#include <memory>
#include <string>

#include "emulators/robotiq/gripper_simulator.hpp"
#include "kinematics/gripper_file.hpp"

namespace stonestack::emulators {

/// A Robotiq 2F-85, 2F-140 or Hand-E: over TCP the text socket of Robotiq's URCap, on a pseudo terminal
/// Modbus RTU with commands at 1000 and status at 2000 (functions 3, 4 and 23). Its own threads serve and
/// move the plant until it is destroyed. Of the faults of the wire the text socket has no_reply, hang_up,
/// exceptions ("?"), delayed, wrong_transaction (the answer to another question), truncated, garbage and
/// fragments.
class TwoFingerSimulator final : public GripperServer {
 public:
  /// `plant` must outlive the simulator and is called by its thread only. Throws as TcpListener and
  /// PseudoTerminal do.
  TwoFingerSimulator(GripperPlant& plant, const GripperFile& file,
                     const GripperSimulatorOptions& options = {});
  ~TwoFingerSimulator() override;
  [[nodiscard]] Endpoint endpoint() const override;
  [[nodiscard]] std::string serial_path() const override;
  void set_faults(const GripperFaults& faults) override;
  void set_faults(const ModbusFaults& faults) override;
  /// Ends every connection of the text socket; new ones are welcome.
  void drop_clients();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace stonestack::emulators
