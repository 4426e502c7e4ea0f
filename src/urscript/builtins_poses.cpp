#include <cmath>

#include "urscript/builtins.hpp"

namespace stonestack::urscript {
namespace {

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
  const PoseVector wrench = six(arg(call, 1));
  PoseVector seen;
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
                    const PoseVector a = to_vector(pose(c, 1).inverse() * pose(c, 0));
                    return Outcome(Value(a.norm()));
                  }});
  list.push_back({"point_dist", {"p_from", "p_to"}, 2, [](BuiltinCall& c) {
                    return Outcome(Value((pose(c, 0).translation() - pose(c, 1).translation()).norm()));
                  }});
  list.push_back({"interpolate_pose", {"p_from", "p_to", "alpha"}, 3, between});
  list.push_back({"rpy2rotvec", {"rpy_vector"}, 1, to_rotation_vector});
  list.push_back({"rotvec2rpy", {"rotation_vector"}, 1, to_rpy});
  list.push_back({"wrench_trans", {"T_from_to", "w_from"}, 2, wrench_into});
}

}  // namespace stonestack::urscript
