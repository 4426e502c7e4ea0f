#include <cmath>

#include "emulators/ur/builtins.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::emulators {
namespace {

constexpr int kPathProblem = 153;           // C-code
constexpr double kLongestMotion = 86400.0;  // s: what lasts longer than a day is a mistake
// All of an optimove's acceleration and speed: a share of 1.
constexpr double kMaxJointAcceleration = 10.0, kMaxJointSpeed = 2.0;  // rad/s^2, rad/s
constexpr double kMaxToolAcceleration = 5.0, kMaxToolSpeed = 1.0;     // m/s^2, m/s

Motion& claim(BuiltinCall& call) {
  controller(call).claim_motion(call.machine, call.thread);
  return controller(call).motion;
}

// The function returns when its motion is done; not at all while the robot may not move.
Outcome until_done(BuiltinCall& call) {
  return Wait([&host = controller(call)]() -> std::optional<Value> {
    if (!host.motion.done()) return std::nullopt;
    return Value();
  });
}

Joints as_joints(BuiltinCall& call, std::size_t i) {
  if (!is_pose(arg(call, i))) return joints(arg(call, i));
  Joints q;
  if (!controller(call).motion.geometry().inverse(to_pose(six(arg(call, i))), controller(call).motion.q(),
                                                  false, q))
    throw ScriptError{"The target pose is out of reach"};
  return q;
}

Pose as_pose(BuiltinCall& call, std::size_t i) {
  if (is_pose(arg(call, i))) return to_pose(six(arg(call, i)));
  return controller(call).motion.geometry().T_B_P(joints(arg(call, i)));
}

// A speed or acceleration from the program, as the controller wants it: finite and positive.
double positive(const BuiltinCall& call, std::size_t i, double preset) {
  const double value = call.number_or(i, preset);
  if (!std::isfinite(value) || value <= 0)
    throw ScriptError{concat("Value error: speeds and accelerations must be positive, got ", value)};
  return value;
}

// The same for speedj and speedl, where 0 keeps the speed that it has: what UR's own client library sends
// along the straight parts of a spline.
double not_negative(const BuiltinCall& call, std::size_t i, double preset) {
  return call.number_or(i, preset) == 0.0 ? 0.0 : positive(call, i, preset);
}

// How long speedj and speedl last; negative: until the speed is reached.
double speed_time(const BuiltinCall& call) {
  return within(finite_or(call, 2, -1.0), -kLongestMotion, kLongestMotion, "a time");
}

MoveOptions options_from(BuiltinCall& call, double a, double v, std::size_t t, std::size_t r) {
  MoveOptions options;
  options.seconds = t ? within(finite_or(call, t, 0.0), 0.0, kLongestMotion, "a time") : 0.0;
  options.blend = std::max(0.0, finite_or(call, r, 0.0));
  if (options.seconds > 0) return options;
  options.acceleration = positive(call, 1, a);
  options.speed = positive(call, 2, v);
  return options;
}

Outcome movej(BuiltinCall& call) {
  const Joints q = as_joints(call, 0);
  const MoveOptions options = options_from(call, 1.4, 1.05, 3, 4);
  claim(call).move_joints(q, options);
  return until_done(call);
}

Outcome movel(BuiltinCall& call) {
  const Pose T_B_P = as_pose(call, 0);
  const MoveOptions options = options_from(call, 1.2, 0.25, 3, 4);
  claim(call).move_line(T_B_P, options);
  return until_done(call);
}

Outcome movep(BuiltinCall& call) {
  const Pose T_B_P = as_pose(call, 0);
  const MoveOptions options = options_from(call, 1.2, 0.25, 0, 3);
  claim(call).move_line(T_B_P, options);
  return until_done(call);
}

MoveOptions optimal(BuiltinCall& call, double acceleration, double speed) {
  MoveOptions options;
  options.acceleration = acceleration * std::min(positive(call, 1, 0.3), 1.0);
  options.speed = speed * std::min(positive(call, 2, 0.3), 1.0);
  options.blend = std::max(0.0, finite_or(call, 3, 0.0));
  return options;
}

Outcome optimovej(BuiltinCall& call) {
  const Joints q = as_joints(call, 0);
  const MoveOptions options = optimal(call, kMaxJointAcceleration, kMaxJointSpeed);
  claim(call).move_joints(q, options);
  return until_done(call);
}

Outcome optimovel(BuiltinCall& call) {
  const Pose T_B_P = as_pose(call, 0);
  const MoveOptions options = optimal(call, kMaxToolAcceleration, kMaxToolSpeed);
  claim(call).move_line(T_B_P, options);
  return until_done(call);
}

Outcome movec(BuiltinCall& call) {
  const Pose via = as_pose(call, 0), T_B_P = as_pose(call, 1);
  MoveOptions options;
  options.acceleration = positive(call, 2, 1.2);
  options.speed = positive(call, 3, 0.25);
  options.blend = std::max(0.0, finite_or(call, 4, 0.0));
  claim(call).move_arc(via, T_B_P, options);
  return until_done(call);
}

Outcome servoj(BuiltinCall& call) {
  const double seconds = within(call.number_or(3, controller(call).period()), 1e-6, kLongestMotion, "a time");
  const double lookahead = within(call.number_or(4, 0.1), 0.03, 0.2, "lookahead_time");
  const double gain = within(call.number_or(5, 300.0), 100.0, 2000.0, "gain");
  const Joints q = as_joints(call, 0);
  claim(call).servo(q, seconds, lookahead, gain);
  return until_done(call);
}

Outcome speedj(BuiltinCall& call) {
  const Joints qd = six(arg(call, 0));
  const double a = not_negative(call, 1, 1.4);
  claim(call).speed_joints(qd, a, speed_time(call));
  return until_done(call);
}

Outcome speedl(BuiltinCall& call) {
  const Six twist = six(arg(call, 0));
  const double a = not_negative(call, 1, 1.2);
  claim(call).speed_line(twist, a, speed_time(call));
  return until_done(call);
}

Outcome stopj(BuiltinCall& call) {
  const double a = positive(call, 0, 2.0);
  claim(call).stop_joints(a);
  return until_done(call);
}

Outcome stopl(BuiltinCall& call) {
  const double a = positive(call, 0, 20.0);
  claim(call).stop_line(a);
  return until_done(call);
}

Outcome force_mode(BuiltinCall& call) {
  ForceMode mode;
  mode.active = true;
  mode.T_B_task = to_pose(six(arg(call, 0)));
  mode.selection = six(arg(call, 1));
  mode.wrench = six(arg(call, 2));
  const long long type = integer(arg(call, 3));
  mode.limits = six(arg(call, 4));
  if (type < 1 || type > 3) throw ScriptError{"Value error: the type of force_mode is 1, 2 or 3"};
  if (controller(call).is_secondary(call.machine))
    throw ScriptError{"A secondary program may not move the robot"};
  controller(call).motion.set_force_mode(mode);
  return Value();
}

Outcome end_force_mode(BuiltinCall& call) {
  controller(call).motion.set_force_mode({});
  return Value();
}

Outcome set_tcp(BuiltinCall& call) {
  controller(call).motion.set_tool(to_pose(six(arg(call, 0))));
  return Value();
}

double payload_mass(const BuiltinCall& call) {
  const double mass = num(call, 0);
  const double max = controller(call).motion.geometry().robot().payload;
  if (!(mass >= 0) || mass > max)
    throw ScriptError{concat("Value error: payload of ", mass, " kg, this robot carries ", max, " kg")};
  return mass;
}

Outcome set_payload(BuiltinCall& call) {
  const double mass = payload_mass(call);
  const Six inertia = call.has(2) ? Six(six(arg(call, 2))) : Six(Six::Zero());
  // Without a centre of gravity it is the tool centre point, as on the pendant.
  controller(call).set_payload(
      mass, call.has(1) ? three(arg(call, 1))
                        : Eigen::Vector3d(controller(call).motion.geometry().T_F_P.translation()));
  controller(call).payload_inertia = inertia;
  return Value();
}

Outcome protective_stop(BuiltinCall& call) {
  controller(call).protective_stop(kPathProblem, "Protective stop: called by the program");
  return Wait([&host = controller(call)]() -> std::optional<Value> {
    if (host.safety_mode == SafetyMode::kProtectiveStop) return std::nullopt;
    return Value();
  });
}

Outcome nothing(BuiltinCall&) {
  return Value();
}

template <bool kOn>
Outcome guide_by_hand(BuiltinCall& call) {
  controller(call).guided_by_hand = kOn;
  return Value();
}

Outcome no_torque(BuiltinCall&) {
  throw ScriptError{"direct_torque: the simulated arm takes positions and speeds only"};
}

}  // namespace

void add_motion(std::vector<Builtin>& list) {
  list.push_back({"movej", {"q", "a", "v", "t", "r"}, 1, movej});
  list.push_back({"movel", {"pose", "a", "v", "t", "r"}, 1, movel});
  list.push_back({"movep", {"pose", "a", "v", "r"}, 1, movep});
  // Their a and v are shares of what the arm can do.
  list.push_back({"optimovej", {"q", "a", "v", "r"}, 1, optimovej});
  list.push_back({"optimovel", {"pose", "a", "v", "r"}, 1, optimovel});
  list.push_back(
      {"direct_torque", {"target_torque", "friction_comp", "viscous_scale", "coulomb_scale"}, 1, no_torque});
  list.push_back({"movec", {"pose_via", "pose_to", "a", "v", "r", "mode"}, 2, movec});
  list.push_back({"servoc", {"pose", "a", "v", "r"}, 1, movep});
  list.push_back({"servoj", {"q", "a", "v", "t", "lookahead_time", "gain"}, 1, servoj});
  list.push_back({"speedj", {"qd", "a", "t"}, 1, speedj});
  list.push_back({"speedl", {"xd", "a", "t", "aRot"}, 1, speedl});
  list.push_back({"stopj", {"a"}, 0, stopj});
  list.push_back({"stopl", {"a", "aRot"}, 0, stopl});
  list.push_back(
      {"force_mode", {"task_frame", "selection_vector", "wrench", "type", "limits"}, 5, force_mode});
  list.push_back({"end_force_mode", {}, 0, end_force_mode});
  list.push_back({"zero_ftsensor", {}, 0, [](BuiltinCall& c) {
                    controller(c).zero_wrench();
                    return Outcome(Value());
                  }});
  list.push_back({"set_tcp", {"pose"}, 1, set_tcp});
  list.push_back({"set_payload", {"m", "cog"}, 1, set_payload});
  list.push_back({"set_target_payload", {"m", "cog", "inertia", "transition_time"}, 1, set_payload});
  list.push_back({"set_payload_mass", {"m"}, 1, [](BuiltinCall& c) {
                    controller(c).set_payload(payload_mass(c), controller(c).payload_cog);
                    return Outcome(Value());
                  }});
  list.push_back({"set_payload_cog", {"CoG"}, 1, [](BuiltinCall& c) {
                    controller(c).set_payload(controller(c).payload, three(arg(c, 0)));
                    return Outcome(Value());
                  }});
  list.push_back({"protective_stop", {}, 0, protective_stop});
  // Accepted, without effect on a simulated arm.
  list.push_back({"force_mode_set_damping", {"damping"}, 1, [](BuiltinCall& c) {
                    within(num(c, 0), 0.0, 1.0, "damping");
                    return Outcome(Value());
                  }});
  list.push_back({"force_mode_set_gain_scaling", {"scaling"}, 1, [](BuiltinCall& c) {
                    within(num(c, 0), 0.0, 2.0, "scaling");
                    return Outcome(Value());
                  }});
  list.push_back({"set_gravity", {"d"}, 1, [](BuiltinCall& c) {
                    static_cast<void>(three(arg(c, 0)));
                    return Outcome(Value());
                  }});
  list.push_back({"freedrive_mode", {"freeAxes", "feature"}, 0, guide_by_hand<true>});
  list.push_back({"end_freedrive_mode", {}, 0, guide_by_hand<false>});
  list.push_back({"get_freedrive_status", {}, 0, [](BuiltinCall&) { return Outcome(Value(0)); }});
  list.push_back({"teach_mode", {}, 0, guide_by_hand<true>});
  list.push_back({"end_teach_mode", {}, 0, guide_by_hand<false>});
  const std::vector<const char*> serial{"enabled",   "baud_rate",     "parity",
                                        "stop_bits", "rx_idle_chars", "tx_idle_chars"};
  list.push_back({"set_tool_communication", serial, 1, nothing});
  const std::vector<const char*> sensor{"enable", "sensor_mass", "sensor_measuring_offset", "sensor_cog"};
  list.push_back({"enable_external_ft_sensor", sensor, 1, nothing});
  list.push_back({"ft_rtde_input_enable", sensor, 1, nothing});
}

}  // namespace stonestack::emulators
