#pragma once
#include "rooms.hpp"
#include "stonestack/hardware/cell.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/stacking/observe.hpp"

namespace stonestack::test {

/// A camera that gets no depth around a place: something black or wet, or a curtain for one frame.
struct HidingCamera : DepthCamera {
  Cell cell;
  const RobotModel& robot;
  Eigen::Vector2d p_W_hidden = Eigen::Vector2d::Zero();
  double radius = 0.0;  // m about p_W_hidden
  int only_frame = -1;  // hides in that frame (from 0) only; below 0: in all
  int frames = 0;

  HidingCamera(const Cell& c, const RobotModel& r) : cell(c), robot(r) {}
  DepthFrame capture() override {
    DepthFrame frame = cell.camera.capture();
    const int now = frames++;
    if (only_frame >= 0 && now != only_frame) return frame;
    const Pose T_W_C = camera_pose(cell.layout, robot, cell.arm.state().q);
    const CameraIntrinsics& camera = frame.image.camera;
    for (int v = 0; v < camera.height; ++v)
      for (int u = 0; u < camera.width; ++u) {
        float& z = frame.image.z[static_cast<std::size_t>(v * camera.width + u)];
        const Eigen::Vector3d p_W = T_W_C * Eigen::Vector3d(z * deproject(camera, u, v));
        if ((p_W.head<2>() - p_W_hidden).norm() < radius) z = 0.0F;
      }
    return frame;
  }
};

}  // namespace stonestack::test
