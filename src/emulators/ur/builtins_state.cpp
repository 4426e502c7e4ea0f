#include <algorithm>

#include "emulators/ur/builtins.hpp"

namespace stonestack::emulators {
namespace {

const ArmGeometry& geometry(const BuiltinCall& call) {
  return controller(call).motion.geometry();
}

Outcome joints_before(BuiltinCall& call) {
  const auto& history = controller(call).history();
  const long long steps = call.has(0) ? integer(arg(call, 0)) : 0;
  if (steps < 0 || history.empty()) return Value(to_list(controller(call).plant().q));
  return Value(to_list(history[std::min(static_cast<std::size_t>(steps), history.size() - 1)]));
}

// Control steps since what the tool meets began to press against the direction (base axes), by default that
// in which it moves; 0: nothing presses. A direction of zeros, as ur_rtde's moveUntilContact has it: any.
Outcome feel(BuiltinCall& call) {
  constexpr double kContact = 5.0;  // N
  Eigen::Vector3d direction =
      geometry(call).twist(controller(call).motion.q(), controller(call).motion.qd()).head<3>();
  if (call.has(0)) direction = six(arg(call, 0)).head<3>();
  const bool any = direction.norm() < 1e-9;
  if (any && !call.has(0)) return Value(0);
  const auto presses = [&](std::size_t steps) {
    const Eigen::Vector3d force = controller(call).force_before(steps);
    return (any ? force.norm() : -force.dot(direction.normalized())) > kContact;
  };
  std::size_t steps = 0;
  while (steps < controller(call).history().size() && presses(steps)) ++steps;
  return Value(static_cast<long long>(steps));
}

Outcome within_limits(BuiltinCall& call) {
  Joints q;
  if (is_pose(arg(call, 0))) {
    if (!geometry(call).inverse(to_pose(six(arg(call, 0))), controller(call).plant().q, false, q))
      return Value(false);
  } else {
    q = joints(arg(call, 0));
  }
  const auto& robot = geometry(call).robot();
  return Value((q.array() <= robot.upper.array()).all() && (q.array() >= robot.lower.array()).all());
}

template <class Read>
void add(std::vector<Builtin>& list, const char* name, Read) {
  list.push_back({name, {}, 0, [](BuiltinCall& call) { return Outcome(Value(Read()(call))); }});
}

}  // namespace

void add_state(std::vector<Builtin>& list) {
  const auto actual_q = [](BuiltinCall& c) { return to_list(controller(c).plant().q); };
  const auto target_q = [](BuiltinCall& c) { return to_list(controller(c).motion.q()); };
  add(list, "get_actual_joint_positions", actual_q);
  add(list, "get_joint_positions", actual_q);
  add(list, "get_target_joint_positions", target_q);
  add(list, "get_actual_joint_speeds", [](BuiltinCall& c) { return to_list(controller(c).plant().qd); });
  add(list, "get_joint_speeds", [](BuiltinCall& c) { return to_list(controller(c).plant().qd); });
  add(list, "get_target_joint_speeds",
      [](BuiltinCall& c) { return to_list(Joints(controller(c).motion.qd() * controller(c).scaling())); });
  add(list, "get_target_joint_accelerations",
      [](BuiltinCall& c) { return to_list(controller(c).motion.qdd()); });
  add(list, "get_actual_tcp_pose",
      [](BuiltinCall& c) { return to_vector(geometry(c).T_B_P(controller(c).plant().q)); });
  add(list, "get_tcp_pose",
      [](BuiltinCall& c) { return to_vector(geometry(c).T_B_P(controller(c).plant().q)); });
  add(list, "get_target_tcp_pose",
      [](BuiltinCall& c) { return to_vector(geometry(c).T_B_P(controller(c).motion.q())); });
  add(list, "get_target_waypoint",
      [](BuiltinCall& c) { return to_vector(controller(c).motion.T_B_waypoint()); });
  add(list, "get_actual_tool_flange_pose",
      [](BuiltinCall& c) { return to_vector(geometry(c).T_B_F(controller(c).plant().q)); });
  add(list, "get_actual_tcp_speed", [](BuiltinCall& c) {
    return to_list(geometry(c).twist(controller(c).plant().q, controller(c).plant().qd));
  });
  add(list, "get_target_tcp_speed", [](BuiltinCall& c) {
    return to_list(geometry(c).twist(controller(c).motion.q(), controller(c).motion.qd()));
  });
  add(list, "get_tcp_force", [](BuiltinCall& c) { return to_list(controller(c).wrench()); });
  add(list, "force", [](BuiltinCall& c) { return controller(c).wrench().head<3>().norm(); });
  add(list, "get_tcp_offset", [](BuiltinCall& c) { return to_vector(geometry(c).T_F_P); });
  add(list, "get_joint_torques", [](BuiltinCall&) { return to_list(Joints(Joints::Zero())); });
  add(list, "get_steptime", [](BuiltinCall& c) { return controller(c).period(); });
  add(list, "get_controller_temp", [](BuiltinCall&) { return 25.0; });
  // Script manual: "always false in modes other than the standard position mode".
  add(list, "is_steady", [](BuiltinCall& c) {
    const auto& motion = controller(c).motion;
    return !motion.moving() && !motion.in_force_mode() && !controller(c).guided_by_hand;
  });
  add(list, "get_target_payload", [](BuiltinCall& c) { return controller(c).payload; });
  add(list, "get_target_payload_cog", [](BuiltinCall& c) { return to_list(controller(c).payload_cog); });
  add(list, "get_target_payload_inertia",
      [](BuiltinCall& c) { return to_list(controller(c).payload_inertia); });
  list.push_back({"get_actual_joint_positions_history", {"steps"}, 0, joints_before});
  list.push_back({"tool_contact", {"direction"}, 0, feel});
  list.push_back({"is_within_safety_limits", {"q"}, 1, within_limits});
  list.push_back({"get_joint_temp", {"j"}, 1, [](BuiltinCall&) { return Outcome(Value(25.0)); }});
}

}  // namespace stonestack::emulators
