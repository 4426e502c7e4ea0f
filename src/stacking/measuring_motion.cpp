#include "stacking/measuring_motion.hpp"

#include <algorithm>

#include "stacking/arrangement.hpp"
#include "stacking/back_away.hpp"
#include "stacking/constants.hpp"
#include "stonestack/stacking/build_tower.hpp"
#include "stonestack/stacking/observe.hpp"

namespace stonestack::stacking {
namespace {

constexpr double kMeasuringSpeed = 0.25;  // m/s, of the tool

}  // namespace

MotionOptions measuring_motion() {
  MotionOptions options;
  options.tool_speed = std::min(options.tool_speed, kMeasuringSpeed);
  options.near_speed = std::min(options.near_speed, kMeasuringSpeed);
  return options;
}

void report_stop(Cell& cell, const std::string& reason) {
  if (!cell.arm.state().can_move)
    throw Error("arm: stopped: " + reason + "; look at the cell, then `stonestack rearm CELL`",
                ExitCode::kSafetyStop);
  throw DeviceError(
      "arm", "did not carry out a motion: " + reason,
      "look at the cell; a motion that is refused may leave the limits or the fence of the cell");
}

CameraView view_after(Cell& cell, const RobotModel& robot, const JointTrajectory& route) {
  const MotionResult moved = cell.arm.follow(route);
  if (moved.status != MotionResult::Status::kDone) report_stop(cell, moved.reason);
  const DepthFrame frame = cell.camera.capture();
  return {frame.image, camera_pose(cell.layout, robot, cell.arm.state().q)};
}

PlanningScene unknown_scene(const Cell& cell, const RobotModel& robot) {
  PlanningScene scene = make_planning_scene(cell.layout, robot, {}, {});
  scene.opening = present_opening(cell, scene.gripper);
  scene.objects.push_back(unseen_field(cell.layout));
  scene.objects.push_back(unseen_site(cell.layout));
  return scene;
}

CameraView view_unknown_field(Cell& cell, const RobotModel& robot, const PlanningScene& scene,
                              const MotionOptions& options) {
  (void)back_away(cell, scene, options, [] {});
  const Eigen::Vector2d& field = cell.layout.field_centre;
  const auto route = plan_route_to_view(
      cell, scene,
      view_poses(cell.layout, {field.x(), field.y(), kFieldViewHeight}, BuildOptions{}.view_distance),
      options);
  if (!route)
    throw DeviceError("arm", "no view of the field can be reached",
                      "check the cell's layout with `stonestack view CELL`");
  return view_after(cell, robot, *route);
}

}  // namespace stonestack::stacking
