#include <algorithm>
#include <future>

#include "motion/timing.hpp"
#include "motion/transit.hpp"
#include "stacking/arrangement.hpp"
#include "stacking/back_away.hpp"
#include "stacking/workcell.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/log.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::stacking {
namespace {

constexpr double kBackAwaySpeed = 0.05;  // m/s
constexpr double kOpeningError = 0.003;  // m: fingers may be open that much wider than the gripper reports

/// Unit, W: where a straight path takes the tool.
Eigen::Vector3d direction_of_tool(const PlanningScene& scene, const JointPath& path) {
  const auto p_W = [&](const Joints& q) -> Eigen::Vector3d {
    return (scene.T_W_R * forward(scene.robot, q) * scene.T_F_T).translation();
  };
  return (p_W(path.back()) - p_W(path.front())).normalized();
}

}  // namespace

bool back_away(Cell& cell, const PlanningScene& scene, const MotionOptions& options,
               const std::function<void()>& before) {
  const auto out = escape_path(scene, cell.arm.state().q, options);
  if (!out || out->size() < 2) return false;  // without a path out no route is found, which is reported
  before();
  TimingLimits limits = timing_limits(scene.robot, options);
  limits.tool_speed = kBackAwaySpeed;
  GuardedMotion away;
  away.trajectory = time_path(*out, limits, scene.robot, scene.T_F_T);
  away.n_W_direction = direction_of_tool(scene, *out);
  away.threshold = options.early_threshold;
  const MotionResult moved = cell.arm.follow_guarded(away);
  if (moved.status == MotionResult::Status::kNoContact) return true;
  throw DeviceError("arm", "stopped as the gripper backed away from what it is near: " + moved.reason,
                    "check the cell and free the gripper");
}

double present_opening(const Cell& cell, const GripperModel& gripper) {
  return std::min(gripper.max_opening, cell.gripper.state().opening + kOpeningError);
}

PlanningScene scene_of_view(const Workcell& w, const Arrangement& arrangement) {
  PlanningScene scene = make_planning_scene(w.cell.layout, *w.models.robot, *w.models.catalogue, arrangement);
  // Fingers that let a stone go beside another were opened no further than there was clearance.
  scene.opening = present_opening(w.cell, scene.gripper);
  return scene;
}

std::optional<JointTrajectory> find_route(Workcell& w, const ViewScene& known,
                                          const std::vector<Pose>& T_W_C) {
  PlanningScene scene = scene_of_view(w, known.arrangement);
  if (known.all_unknown) {
    scene.objects.push_back(unseen_field(w.cell.layout));
    scene.objects.push_back(unseen_site(w.cell.layout));
  }
  const double start = w.cell.clock.now();
  (void)back_away(w.cell, scene, w.options.motion, [&] {
    w.emit(BackedAway{});
    w.emit(StepBegun{"back away"});
  });
  w.seconds.motion += w.cell.clock.now() - start;
  const Stopwatch watch;
  auto route = plan_route_to_view(w.cell, scene, T_W_C, w.options.motion);
  w.seconds.planning += watch.seconds();
  return route;
}

JointTrajectory route_to(Workcell& w, const ViewScene& known, const std::vector<Pose>& T_W_C) {
  if (auto route = find_route(w, known, T_W_C)) return *std::move(route);
  throw DeviceError("arm", concat("none of ", T_W_C.size(), " camera poses can be reached"),
                    "check the cell's layout: site, field and robot base");
}

CameraView view_along(Workcell& w, const JointTrajectory& route, const std::function<void()>& meanwhile) {
  w.emit(StepBegun{"move to a view"});
  double moved = 0.0;
  const auto go = [&] {
    const double start = w.cell.clock.now();
    try {
      CameraView view = take_view(w.cell, *w.models.robot, route);
      moved = w.cell.clock.now() - start;
      return view;
    } catch (...) {  // stopped at once, whatever else is still being done
      try {
        w.cell.arm.stop();
      } catch (const Error& problem) {
        log_warning(problem.what());  // what ended the motion is reported by the caller
      }
      throw;
    }
  };
  const StageSeconds before = w.seconds;
  std::future<CameraView> coming;
  if (meanwhile) {
    coming = std::async(std::launch::async, go);
    meanwhile();  // if it throws, the future waits until the arm has stopped
  }
  CameraView view = coming.valid() ? coming.get() : go();
  double left = moved;  // of the motion, beside which nobody waited for anything
  for (double StageSeconds::*stage : {&StageSeconds::detection, &StageSeconds::search}) {
    const double beside = std::min(left, w.seconds.*stage - before.*stage);
    w.seconds.*stage -= beside;
    w.seconds.beside_motion += beside;
    left -= beside;
  }
  w.seconds.motion += moved;
  return view;
}

}  // namespace stonestack::stacking
