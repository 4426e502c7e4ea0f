#pragma once
#include <vector>

#include "stonestack/geometry/mesh.hpp"
#include "stonestack/kinematics/robot_model.hpp"

/// Private to report/: the outer shape of an arm's links, as pictures and pages draw it.
namespace stonestack::report {

/// A surface of revolution that moves with a link.
struct LinkShape {
  int link = 0;                                       ///< 0: base
  Eigen::Vector3d p = Eigen::Vector3d::Zero();        ///< where the profile begins, in the link's frame [m]
  Eigen::Vector3d n_axis = Eigen::Vector3d::UnitZ();  ///< unit vector, in the link's frame
  std::vector<Eigen::Vector2d> profile;               ///< distance along the axis and radius [m]
  bool lid = false;                                   ///< cover of a joint, which has a colour of its own
};

/// Housings about the joints' axes, with a lid where nothing follows, and tubes between them: made from the
/// chain and the capsules of the collision shape, which they leave by the edges of flat ends only. Capsules
/// that lie along no joint and end in no housing are drawn as they are.
[[nodiscard]] std::vector<LinkShape> link_shapes(const RobotModel& robot);

/// Mesh of a shape, in the link's frame.
[[nodiscard]] Mesh mesh_of(const LinkShape& shape);

}  // namespace stonestack::report
