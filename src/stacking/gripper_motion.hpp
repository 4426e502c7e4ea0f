#pragma once
#include "stacking/journal.hpp"
#include "stonestack/hardware/cell.hpp"

/// Private to stacking/: motions of the fingers. One that fails is commanded once more where that is safe:
/// the arm can move, and the gripper answers that it is at rest and has no fault. The arm stands still
/// meanwhile. The repetition is in the journal before it begins (`GripperRetried`).
namespace stonestack::stacking {

/// Moves the fingers, as `Gripper::move`. @throws DeviceError when it fails for good.
GripperState move_gripper(Cell& cell, Journal* journal, double opening, double speed, double force);
/// Brings fingers B and C together or apart, as `Gripper::spread`. @throws DeviceError likewise.
void spread_gripper(Cell& cell, Journal* journal, double spacing);

}  // namespace stonestack::stacking
