#pragma once
#include <functional>
#include <memory>

#include "stonestack/hardware/cell.hpp"
#include "stonestack/hardware/cell_file.hpp"

/// Private: devices of a cell that are read and never commanded.
namespace stonestack::hardware {

/// Arm, gripper and force sensor that refuse every command, in place of a cell's own. `stop` does nothing:
/// nothing moves by them.
class ReadOnlyDevices {
 public:
  /// `arm_state` answers for the arm. The gripper counts as open, empty and at rest. Camera and clock must
  /// outlive this object.
  ReadOnlyDevices(std::function<ArmState()> arm_state, DepthCamera& camera, Clock& clock, CellLayout layout);
  ~ReadOnlyDevices();
  [[nodiscard]] Cell cell();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

/// Arm and camera of a real cell. Only the camera's stream and the arm's state are asked for: no register is
/// claimed, no script port opened, gripper and force sensor are not connected.
class ReadOnlyHardware {
 public:
  /// @throws DeviceError, FileError as HardwareCell
  explicit ReadOnlyHardware(const CellConfig& config);
  ~ReadOnlyHardware();
  [[nodiscard]] Cell cell();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace stonestack::hardware
