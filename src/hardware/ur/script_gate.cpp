#include "hardware/trajectory_gate.hpp"
#include "hardware/ur/script_writer.hpp"

namespace stonestack::hardware {

std::string find_fault(const JointTrajectory& trajectory, const Joints& q, const RobotModel& robot,
                       const ScriptContext& context) {
  return find_path_fault(trajectory, q, robot,
                         {context.T_W_R, context.T_F_T, 1.0 / context.version.control_rate()});
}

FieldList fields(ScriptOptions& o) {
  return {
      field("stop_acceleration", o.stop_acceleration, {0.1, 20}, "rad/s^2", "of a stop on the controller"),
      field("heartbeat_rate", o.heartbeat_rate, {1, 50}, "Hz",
            "a host that is heard of less often is dead: the program stops"),
      field("force_stale", o.force_stale, {0.02, 1}, "s",
            "a guarded motion stops when no new force reading arrives for so long"),
      field("contact_samples", o.contact_samples, {1, 100}, "",
            "readings in a row above the threshold that are contact"),
      field("comply_time", o.comply_time, {0, 5}, "s", "force mode after contact; 0: just stop"),
  };
}

}  // namespace stonestack::hardware
