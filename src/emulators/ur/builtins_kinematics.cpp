#include "emulators/ur/builtins.hpp"

namespace stonestack::emulators {
namespace {

// Tool offset of a call that may name another one than the active.
ArmGeometry with_tcp(const BuiltinCall& call, std::size_t i) {
  ArmGeometry geometry = controller(call).motion.geometry();
  if (call.has(i)) geometry.T_F_P = pose(call, i);
  return geometry;
}

Outcome forward_of(BuiltinCall& call) {
  const Joints q = call.has(0) ? joints(arg(call, 0)) : controller(call).plant().q;
  return Value(to_vector(with_tcp(call, 1).T_B_P(q)));
}

bool solve(BuiltinCall& call, Joints& q) {
  const Joints near = call.has(1) ? joints(arg(call, 1)) : controller(call).plant().q;
  return with_tcp(call, 4).inverse(pose(call, 0), near, false, q);
}

Outcome inverse_of(BuiltinCall& call) {
  Joints q;
  if (!solve(call, q)) throw ScriptError{"get_inverse_kin: unable to find an inverse kinematics solution"};
  return Value(to_list(q));
}

Outcome has_inverse(BuiltinCall& call) {
  Joints q;
  return Value(solve(call, q));
}

}  // namespace

void add_kinematics(std::vector<Builtin>& list) {
  list.push_back({"get_forward_kin", {"q", "tcp"}, 0, forward_of});
  const std::vector<const char*> inverse{"x", "qnear", "maxPositionError", "maxOrientationError", "tcp"};
  list.push_back({"get_inverse_kin", inverse, 1, inverse_of});
  list.push_back({"get_inverse_kin_has_solution", inverse, 1, has_inverse});
}

}  // namespace stonestack::emulators
