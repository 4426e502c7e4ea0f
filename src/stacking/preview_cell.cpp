#include <algorithm>
#include <array>
#include <cmath>

#include "core/constants.hpp"
#include "hardware/cell_config.hpp"
#include "hardware/ready_joints.hpp"
#include "kinematics/inverse.hpp"
#include "motion/collision.hpp"
#include "motion/collision/overlap.hpp"
#include "motion/transit.hpp"
#include "stacking/arrangement.hpp"
#include "stacking/constants.hpp"
#include "stacking/examination.hpp"
#include "stacking/route_to_view.hpp"
#include "stonestack/stacking/build_tower.hpp"
#include "stonestack/stacking/check_cell.hpp"
#include "stonestack/stacking/observe.hpp"

namespace stonestack::stacking {
namespace {

constexpr double kTipHeight = 0.02;    // m, tip of the gripper at a stone on the table
constexpr double kTowerHeight = 0.30;  // m, likewise at the top of a tower of four limestones
constexpr double kFieldSpace = 0.25;   // m, height up to which stones may lie in the field
constexpr double kSiteHalf = 0.10;     // m, half of the square about the site that a view should show
constexpr int kTurnsOfGripper = 8;     // about the vertical, to try
constexpr int kDirections = 72;        // of the outline of what the arm reaches
constexpr double kRadiusStep = 0.01;   // m, likewise
constexpr double kFarthestSeen = 1.5;  // m along the optical axis, SR300
constexpr int kSeenGrid = 20;          // points along a side of the field that the camera should see

const std::string kMove = "move layout.field, layout.site or the base";

std::string place_text(const Eigen::Vector3d& p) {
  const auto millimetres = [](double metres) { return std::round(1e3 * metres) / 1e3; };
  return concat("(", millimetres(p.x()), ", ", millimetres(p.y()), ", ", millimetres(p.z()), ") m");
}

/// Joint angles with which the gripper points down with its tip at `p_W`, within the joints' limits.
std::vector<Joints> pointing_down(const RobotModel& robot, const CellLayout& layout,
                                  const Eigen::Vector3d& p_W, bool any_turn) {
  const Pose T_R_W = layout.T_W_R.inverse(), T_T_F = layout.T_F_T.inverse();
  std::vector<Joints> all;
  for (int k = 0; k < kTurnsOfGripper; ++k) {
    const Pose T_W_T = Pose(Eigen::Translation3d(p_W)) * Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX()) *
                       Eigen::AngleAxisd(kTwoPi * k / kTurnsOfGripper, Eigen::Vector3d::UnitZ());
    for (const IkSolution& solution : inverse(robot, T_R_W * T_W_T * T_T_F, home_joints()))
      all.push_back(solution.q);
    if (any_turn && !all.empty()) break;
  }
  return all;
}

/// Arm among the obstacles of its cell, and the reach of its gripper.
struct StandingArm {
  const CellPreview& cell;
  PlanningScene scene;
  CollisionChecker checker;

  StandingArm(const CellPreview& preview, PlanningScene made)
      : cell(preview), scene(std::move(made)), checker(scene, rules(scene)) {}
  static CollisionRules rules(const PlanningScene& scene) {
    CollisionRules close;
    close.padding = MotionOptions{}.approach_padding;
    close.opening = scene.opening;
    return close;
  }

  /// Why the gripper cannot point down with its tip at `p_W`; empty: it can.
  [[nodiscard]] std::string obstruction(const Eigen::Vector3d& p_W) const {
    const std::vector<Joints> all = pointing_down(cell.robot, cell.layout, p_W, false);
    if (all.empty()) return "out of the arm's reach at " + place_text(p_W);
    if (std::any_of(all.begin(), all.end(), [&](const Joints& q) { return !checker.collides(q); })) return {};
    const Joints& q = all.front();
    std::string text = describe_outside_workspace(cell.robot, q, -kWorkspaceMargin);
    if (text.empty()) text = describe_outside_fence(cell.robot, q, -kWorkspaceMargin);
    if (!text.empty()) return text;
    const Clearance nearest = checker.clearance(q);
    text = concat("with the gripper at ", place_text(p_W), " ");
    if (nearest.distance > checker.rules().self_padding) return text + "fingers or camera leave the fence";
    return concat(text, nearest.first, " and ", nearest.second, " come too near to each other");
  }
};

std::array<Eigen::Vector2d, 5> corners_and_middle(const CellLayout& layout) {
  const Eigen::Vector2d half = 0.5 * layout.field_size, &c = layout.field_centre;
  return {c, c - half, c + Eigen::Vector2d(half.x(), -half.y()), c + half,
          c + Eigen::Vector2d(-half.x(), half.y())};
}

Found judge_reach(const StandingArm& arm, const std::vector<Eigen::Vector3d>& p_W, const std::string& good) {
  std::string first;
  int failed = 0;
  for (const Eigen::Vector3d& p : p_W)
    if (const std::string why = arm.obstruction(p); !why.empty() && ++failed == 1) first = why;
  if (failed == 0) return {good};
  throw Error(concat(first, " (", failed, " of ", p_W.size(), " places that were tried); ", kMove),
              ExitCode::kExecutionFailed);
}

Found judge_field(const StandingArm& arm) {
  std::vector<Eigen::Vector3d> p_W;
  for (const Eigen::Vector2d& p : corners_and_middle(arm.cell.layout))
    for (const double above : {0.0, MotionOptions{}.approach})
      p_W.emplace_back(p.x(), p.y(), kTipHeight + above);
  return judge_reach(arm, p_W, "the gripper reaches its middle and corners, pointing down");
}

Found judge_site(const StandingArm& arm) {
  std::vector<Eigen::Vector3d> p_W;
  for (const double height : {kTipHeight, kTowerHeight, kTowerHeight + MotionOptions{}.approach})
    p_W.emplace_back(arm.cell.layout.site.x(), arm.cell.layout.site.y(), height);
  return judge_reach(arm, p_W, concat("the gripper reaches it up to ", p_W.back().z(), " m, pointing down"));
}

/// "joint 3 at 2.1 rad ..."; empty: all are within.
std::string outside_joint_limits(const RobotModel& robot, const Joints& q) {
  for (Eigen::Index i = 0; i < q.size(); ++i)
    if (!(q[i] >= robot.lower[i] && q[i] <= robot.upper[i]))
      return concat("joint ", i + 1, " at ", q[i], " rad is outside the limits of the cell, ", robot.lower[i],
                    " to ", robot.upper[i], " rad");
  return {};
}

Found judge_start(const StandingArm& arm, const Joints& q) {
  for (const std::string& problem :
       {outside_joint_limits(arm.cell.robot, q),
        describe_outside_workspace(arm.cell.robot, q, -kWorkspaceMargin),
        describe_outside_fence(arm.cell.robot, q, -kWorkspaceMargin), start_problem(arm.scene, q)})
    if (!problem.empty())
      throw Error(problem + "; no motion begins there: jog the arm out, or correct limits and obstacles",
                  ExitCode::kExecutionFailed);
  const Clearance nearest = arm.checker.clearance(q);
  return {concat("free; nearest are ", nearest.first, " and ", nearest.second, ", ",
                 std::lround(1e3 * nearest.distance), " mm apart")};
}

/// Stones lie or stand in `space`: nothing else may.
Found judge_space(const CellLayout& layout, const SceneObject& space) {
  for (const Obstacle& obstacle : layout.obstacles)
    if (objects_overlap(space, {obstacle.name, obstacle.pieces, obstacle.T_W_O}))
      throw Error(concat("the obstacle '", obstacle.name, "' stands in it; move it, or ", kMove),
                  ExitCode::kExecutionFailed);
  return {layout.obstacles.empty() ? "there are no obstacles" : "no obstacle stands in it"};
}

/// Where stones may lie or stand, up to the height of a stone or of a tower.
SceneObject space_over(const Eigen::Vector2d& middle, const Eigen::Vector2d& size, double height) {
  return {"", {make_box({size.x(), size.y(), height})}, make_pose({middle.x(), middle.y(), height / 2})};
}

/// The camera of the file; `assumed` where only the camera itself knows its lens.
std::optional<CameraIntrinsics> camera_of(const CellConfig& cell, bool simulated, bool& assumed) {
  assumed = false;
  if (cell.camera == "v4l2") return to_intrinsics(cell.v4l2.camera);
  if (cell.camera == "recorded") return RecordedCamera(cell.recorded).intrinsics();
  if (cell.camera == "stream" && cell.stream.port == 0 && !simulated) return std::nullopt;
  assumed = true;
  return CameraIntrinsics{};
}

/// Share of points on the table, `half` about the middle, that are in the image.
double seen_share(const CameraIntrinsics& camera, const Pose& T_W_C, const Eigen::Vector2d& middle,
                  const Eigen::Vector2d& half) {
  const Pose T_C_W = T_W_C.inverse();
  int seen = 0;
  for (int i = 0; i <= kSeenGrid; ++i)
    for (int j = 0; j <= kSeenGrid; ++j) {
      const Eigen::Vector2d p =
          middle + (2.0 * Eigen::Vector2d(i, j) / kSeenGrid - Eigen::Vector2d::Ones()).cwiseProduct(half);
      const Eigen::Vector3d p_C = T_C_W * Eigen::Vector3d(p.x(), p.y(), 0.0);
      if (p_C.z() <= 0.0) continue;
      const Eigen::Vector2d pixel = project(camera, p_C);
      if (pixel.minCoeff() >= 0.0 && pixel.x() <= camera.width - 1 && pixel.y() <= camera.height - 1) ++seen;
    }
  return static_cast<double>(seen) / ((kSeenGrid + 1) * (kSeenGrid + 1));
}

std::vector<Eigen::Vector3d> seen_outline(const CameraIntrinsics& camera, const Pose& T_W_C) {
  std::vector<Eigen::Vector3d> outline;
  for (const auto& [u, v] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
    const Eigen::Vector3d ray =
        T_W_C.linear() * deproject(camera, u * (camera.width - 1), v * (camera.height - 1));
    const double to_table = ray.z() < 0.0 ? -T_W_C.translation().z() / ray.z() : kFarthestSeen;
    outline.emplace_back(T_W_C.translation() + std::clamp(to_table, 0.0, kFarthestSeen) * ray);
  }
  return outline;
}

CellPose pose_at(const CellPreview& cell, const std::string& name, const Joints& q) {
  CellPose pose{name, q, camera_pose(cell.layout, cell.robot, q), {}};
  if (cell.camera) pose.p_W_seen = seen_outline(*cell.camera, pose.T_W_C);
  return pose;
}

/// A view of a run from where the arm stands at its start, before it knows what lies and stands there.
struct WantedView {
  std::string name;
  Eigen::Vector3d p_W_target;
  Eigen::Vector2d half;  ///< of what the view should show [m]
};

Found judge_view(CellPreview& cell, PlanningScene scene, const WantedView& wanted) {
  scene.objects.push_back(unseen_field(cell.layout));
  scene.objects.push_back(unseen_site(cell.layout));
  const BuildOptions options;
  // As `find_route` of a run: the arm first comes out of what it is near.
  const auto away = escape_path(scene, cell.poses.front().q, options.motion);
  const Joints q = away && !away->empty() ? away->back() : cell.poses.front().q;
  const auto route =
      route_to_view(cell.layout, scene, q, view_poses(cell.layout, wanted.p_W_target, options.view_distance),
                    options.motion);
  if (!route)
    throw Error(concat("no view of it can be reached from the start; ", kMove, ", or correct layout.T_T_C"),
                ExitCode::kExecutionFailed);
  const CellPose pose = pose_at(cell, "view of the " + wanted.name, route->q.back());
  cell.poses.push_back(pose);
  const double share = seen_share(*cell.camera, pose.T_W_C, wanted.p_W_target.head<2>(), wanted.half);
  const std::string lens = cell.camera_is_assumed ? " by a lens as that of an SR300, 68 x 54 deg" : "";
  if (share == 1.0)
    return {concat("seen whole from ", place_text(pose.T_W_C.translation()), lens), cell.camera_is_assumed};
  const std::string part = concat("from ", place_text(pose.T_W_C.translation()), " the camera shows ",
                                  std::lround(100.0 * share), " % of it", lens);
  if (cell.camera_is_assumed) return {part, true};
  throw Error(part + "; make it smaller, or correct layout.T_T_C", ExitCode::kExecutionFailed);
}

/// Outline of the first radius from `from` on, in steps of `step`, at which the gripper points down.
std::vector<Eigen::Vector2d> outline_of_reach(const CellPreview& cell, double from, double step) {
  const Eigen::Vector2d base = cell.layout.T_W_R.translation().head<2>();
  const double farthest = std::abs(cell.robot.a2) + std::abs(cell.robot.a3) + cell.robot.d4 + cell.robot.d5;
  std::vector<Eigen::Vector2d> outline;
  for (int k = 0; k < kDirections; ++k) {
    const double angle = kTwoPi * k / kDirections;
    const Eigen::Vector2d n(std::cos(angle), std::sin(angle));
    double radius = from > 0.0 ? farthest : 0.0, reached = 0.0;
    for (; radius >= 0.0 && radius <= farthest; radius += step) {
      const Eigen::Vector2d p = base + radius * n;
      if (pointing_down(cell.robot, cell.layout, {p.x(), p.y(), kTipHeight}, true).empty()) continue;
      reached = radius;
      break;
    }
    outline.emplace_back(base + reached * n);
  }
  return outline;
}

}  // namespace

CellPreview preview_cell(const CellConfig& config, const CellPreviewOptions& options) {
  CellPreview cell;
  cell.robot = read_cell_robot(config);
  cell.layout = to_layout(config);
  const Joints q = options.q_start.value_or(ready_joints(cell.robot, cell.layout));
  const std::string outside = outside_joint_limits(cell.robot, q);
  require(!options.q_start || outside.empty(), outside,
          q.cwiseAbs().maxCoeff() > kTwoPi ? "; angles are in rad, not degrees" : "");
  Examination examination;
  examination.check("camera", "lens", [&]() -> Found {
    cell.camera = camera_of(config, options.simulated, cell.camera_is_assumed);
    if (!cell.camera) return {"the file names no camera; a run needs one", true};
    if (cell.camera_is_assumed) return {"the camera says it once it is connected", true};
    return {concat(cell.camera->width, " x ", cell.camera->height, ", as the file has it")};
  });
  examination.check("camera", "mount", [&] { return check_hand_eye(config, {}); });
  cell.poses.push_back(pose_at(cell, "start", q));
  cell.p_W_reach = outline_of_reach(cell, 1.0, -kRadiusStep);
  cell.p_W_too_near = outline_of_reach(cell, 0.0, kRadiusStep);

  const CellLayout& layout = cell.layout;
  const StandingArm arm(cell, make_planning_scene(layout, cell.robot, {}, {}));
  examination.check("start", "arm", [&] { return judge_start(arm, q); });
  examination.check("field", "reach", [&] { return judge_field(arm); });
  examination.check("field", "obstacles", [&] {
    return judge_space(layout, space_over(layout.field_centre, layout.field_size, kFieldSpace));
  });
  examination.check("site", "reach", [&] { return judge_site(arm); });
  examination.check("site", "obstacles", [&] { return judge_space(layout, unseen_site(layout)); });
  if (cell.camera) {
    const auto at = [](const Eigen::Vector2d& p, double z) { return Eigen::Vector3d(p.x(), p.y(), z); };
    const WantedView field{"field", at(layout.field_centre, kFieldViewHeight), 0.5 * layout.field_size};
    const WantedView site{"site", at(layout.site, kSiteViewHeight), Eigen::Vector2d::Constant(kSiteHalf)};
    for (const WantedView& wanted : {field, site})
      examination.check(wanted.name, "view", [&] { return judge_view(cell, arm.scene, wanted); });
  }
  cell.report = examination.report();
  return cell;
}

}  // namespace stonestack::stacking
