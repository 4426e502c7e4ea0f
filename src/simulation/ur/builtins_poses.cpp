#include <cmath>

#include "simulation/ur/builtins.hpp"

namespace stonestack::simulation::urscript {
namespace {

Pose pose(const BuiltinCall& call, std::size_t i) {
  return to_pose(six(arg(call, i)));
}

// Tool offset of a call that may name another one than the active.
ArmGeometry with_tcp(const BuiltinCall& call, std::size_t i) {
  ArmGeometry geometry = call.host.motion.geometry();
  if (call.has(i)) geometry.T_F_P = pose(call, i);
  return geometry;
}

Outcome forward_of(BuiltinCall& call) {
  const Joints q = call.has(0) ? joints(arg(call, 0)) : call.host.plant().q;
  return Value(to_vector(with_tcp(call, 1).T_B_P(q)));
}

bool solve(BuiltinCall& call, Joints& q) {
  const Joints near = call.has(1) ? joints(arg(call, 1)) : call.host.plant().q;
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

Outcome add(BuiltinCall& call) {  // translations add, rotations follow each other
  const Pose a = pose(call, 0), b = pose(call, 1);
  Pose sum = Pose::Identity();
  sum.translation() = a.translation() + b.translation();
  sum.linear() = a.rotation() * b.rotation();
  return Value(to_vector(sum));
}

Outcome subtract(BuiltinCall& call) {
  const Pose a = pose(call, 0), b = pose(call, 1);
  Pose rest = Pose::Identity();
  rest.translation() = a.translation() - b.translation();
  rest.linear() = b.rotation().transpose() * a.rotation();
  return Value(to_vector(rest));
}

Outcome between(BuiltinCall& call) {
  return Value(to_vector(interpolate(pose(call, 0), pose(call, 1), finite(arg(call, 2)))));
}

Outcome to_rotation_vector(BuiltinCall& call) {
  const Eigen::Vector3d rpy = three(arg(call, 0));
  const Eigen::AngleAxisd turn(Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) *
                               Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
                               Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()));
  return Value(to_list(Eigen::Vector3d(turn.angle() * turn.axis())));
}

Outcome to_rpy(BuiltinCall& call) {
  PoseVector vector = PoseVector::Zero();
  vector.tail<3>() = three(arg(call, 0));
  const Eigen::Matrix3d R = to_pose(vector).rotation();
  const double pitch = std::atan2(-R(2, 0), std::hypot(R(0, 0), R(1, 0)));
  return Value(to_list(Eigen::Vector3d(std::atan2(R(2, 1), R(2, 2)), pitch, std::atan2(R(1, 0), R(0, 0)))));
}

// A wrench in frame `from`, seen from where `from` is known.
Outcome wrench_into(BuiltinCall& call) {
  const Pose T = pose(call, 0);
  const Six wrench = six(arg(call, 1));
  Six seen;
  seen.head<3>() = T.rotation() * wrench.head<3>();
  seen.tail<3>() = T.rotation() * wrench.tail<3>() +
                   Eigen::Vector3d(T.translation()).cross(Eigen::Vector3d(seen.head<3>()));
  return Value(to_list(seen));
}

}  // namespace

void add_poses(std::vector<Builtin>& list) {
  list.push_back({"pose_trans", {"p_from", "p_from_to"}, 2, [](BuiltinCall& c) {
                    return Outcome(Value(to_vector(pose(c, 0) * pose(c, 1))));
                  }});
  list.push_back({"pose_inv", {"p_from"}, 1, [](BuiltinCall& c) {
                    return Outcome(Value(to_vector(pose(c, 0).inverse())));
                  }});
  list.push_back({"pose_add", {"p_1", "p_2"}, 2, add});
  list.push_back({"pose_sub", {"p_to", "p_from"}, 2, subtract});
  list.push_back({"pose_dist", {"p_from", "p_to"}, 2, [](BuiltinCall& c) {
                    const Six a = to_vector(pose(c, 1).inverse() * pose(c, 0));
                    return Outcome(Value(a.norm()));
                  }});
  list.push_back({"point_dist", {"p_from", "p_to"}, 2, [](BuiltinCall& c) {
                    return Outcome(Value((pose(c, 0).translation() - pose(c, 1).translation()).norm()));
                  }});
  list.push_back({"interpolate_pose", {"p_from", "p_to", "alpha"}, 3, between});
  list.push_back({"rpy2rotvec", {"rpy_vector"}, 1, to_rotation_vector});
  list.push_back({"rotvec2rpy", {"rotation_vector"}, 1, to_rpy});
  list.push_back({"wrench_trans", {"T_from_to", "w_from"}, 2, wrench_into});
  list.push_back({"get_forward_kin", {"q", "tcp"}, 0, forward_of});
  const std::vector<const char*> inverse{"x", "qnear", "maxPositionError", "maxOrientationError", "tcp"};
  list.push_back({"get_inverse_kin", inverse, 1, inverse_of});
  list.push_back({"get_inverse_kin_has_solution", inverse, 1, has_inverse});
}

}  // namespace stonestack::simulation::urscript
