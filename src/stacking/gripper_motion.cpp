#include "stacking/gripper_motion.hpp"

#include "stacking/record.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"

namespace stonestack::stacking {
namespace {

bool may_repeat(Cell& cell) {
  throw_if_interrupted();
  const GripperState gripper = cell.gripper.state();
  return gripper.fault.empty() && !gripper.moving && cell.arm.state().can_move;
}

template <class Motion>
auto repeated_once(Cell& cell, Journal* journal, const Motion& motion) {
  try {
    return motion();
  } catch (const DeviceError& problem) {
    if (!may_repeat(cell)) throw;
    const GripperRetried retried{problem.what()};
    log_warning(to_text(retried, {}));
    record(journal, retried);
  }
  return motion();
}

}  // namespace

GripperState move_gripper(Cell& cell, Journal* journal, double opening, double speed, double force) {
  return repeated_once(cell, journal, [&] { return cell.gripper.move(opening, speed, force); });
}

void spread_gripper(Cell& cell, Journal* journal, double spacing) {
  repeated_once(cell, journal, [&] { cell.gripper.spread(spacing); });
}

}  // namespace stonestack::stacking
