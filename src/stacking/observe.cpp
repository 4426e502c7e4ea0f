#include "stonestack/stacking/observe.hpp"

#include <algorithm>
#include <cmath>

#include "core/constants.hpp"
#include "motion/collision/mounted_gripper.hpp"
#include "stacking/route_to_view.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::stacking {
namespace {

void keep_better(std::vector<Sighting>& sightings, const Sighting& seen) {
  const auto known = std::find_if(sightings.begin(), sightings.end(),
                                  [&](const Sighting& s) { return s.stone == seen.stone; });
  if (known == sightings.end()) {
    sightings.push_back(seen);
  } else if (seen.score > known->score) {
    *known = seen;
  }
}

/// Standard deviations in W of a pose that was found in C.
PoseSigma sigma_of(const Pose& T_W_C, const Detection& found) {
  const Eigen::Matrix3d R_W_C = T_W_C.linear();
  PoseSigma sigma;
  sigma.translation_W = (R_W_C * found.covariance.topLeftCorner<3, 3>() * R_W_C.transpose())
                            .diagonal()
                            .cwiseMax(0.0)
                            .cwiseSqrt();
  sigma.turn = std::sqrt(std::max(0.0, found.covariance.bottomRightCorner<3, 3>().trace()) / 3.0);
  return sigma;
}

Sighting sighting_of(const Pose& T_W_C, const Detection& found) {
  return {found.stone,   T_W_C * found.T_C_O, found.score,
          found.visible, found.certainty,     sigma_of(T_W_C, found)};
}

void add(std::vector<Sighting>& sightings, const Pose& T_W_C, const DetectionResult& result) {
  for (const auto& found : result.detections) keep_better(sightings, sighting_of(T_W_C, found));
}

bool seen(const std::vector<Sighting>& sightings, StoneIndex stone) {
  return std::any_of(sightings.begin(), sightings.end(), [&](const Sighting& s) { return s.stone == stone; });
}

std::vector<StoneIndex> unseen(const std::vector<StoneIndex>& wanted,
                               const std::vector<Sighting>& sightings) {
  std::vector<StoneIndex> missing;
  for (const StoneIndex stone : wanted)
    if (!seen(sightings, stone)) missing.push_back(stone);
  return missing;
}

/// Returns the known stones of a view, which explain their own pixels.
SceneKnowledge known_in(const Pose& T_W_C, const std::vector<Sighting>& sightings) {
  SceneKnowledge known;
  for (const auto& s : sightings) known.stones.push_back({s.stone, T_W_C.inverse() * s.T_W_O});
  return known;
}

/// Stones of a stack that were not seen, but something above them was, near where it was.
std::vector<PlacedStone> carrying(const std::vector<PlacedStone>& stack,
                                  const std::vector<Sighting>& sightings) {
  std::vector<PlacedStone> hidden;
  bool carries = false;
  for (auto placed = stack.rbegin(); placed != stack.rend(); ++placed) {
    if (seen(sightings, placed->stone))
      carries = true;
    else if (carries)
      hidden.push_back(*placed);
  }
  return hidden;
}

}  // namespace

Pose camera_looking_at(const Eigen::Vector3d& p_W_eye, const Eigen::Vector3d& p_W_target, double roll) {
  const Eigen::Vector3d z = (p_W_target - p_W_eye).normalized();
  Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ());
  if (x.norm() < 1e-6) x = Eigen::Vector3d::UnitX();
  x.normalize();
  Pose T_W_C = Pose::Identity();
  T_W_C.linear() << x, z.cross(x), z;
  T_W_C.translation() = p_W_eye;
  return T_W_C * Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitZ());
}

Pose camera_pose(const CellLayout& layout, const RobotModel& robot, const Joints& q) {
  return layout.T_W_R * forward(robot, q) * layout.T_F_T * layout.T_T_C;
}

Joints home_joints() {
  return (Joints() << 0.0, -1.75, 1.85, -1.67, -1.5708, 0.0).finished();
}

GripperModel gripper_of(const CellLayout& layout) {
  GripperModel gripper =
      mounted_at(with_camera_at(read_gripper(layout.gripper, linkage_named(layout.linkage)), layout.T_T_C),
                 layout.T_F_T);
  gripper.sensor_mass = layout.sensor_mass;
  gripper.camera_mass = layout.camera_mass;
  return gripper;
}

CellLayout with_option_gripper(CellLayout layout, const std::string& name, bool from_cell_file) {
  require(!from_cell_file || name.empty() || name == layout.gripper, "gripper.hand is ", name,
          ", the cell file has ", layout.gripper, "; write `hand: ", name, "` there");
  return with_gripper(std::move(layout), name);
}

PlanningScene make_planning_scene(const CellLayout& layout, const RobotModel& robot,
                                  const Catalogue& catalogue, const Arrangement& arrangement) {
  PlanningScene scene;
  scene.robot = robot;
  scene.gripper = gripper_of(layout);
  scene.opening = scene.gripper.max_opening;
  scene.T_W_R = layout.T_W_R;
  scene.T_F_T = layout.T_F_T;
  for (const auto* group : {&arrangement.stack, &arrangement.loose})
    for (const auto& placed : *group) {
      const Stone& stone = catalogue[placed.stone];
      scene.objects.push_back({stone.name, stone.pieces, placed.T_W_O});
    }
  scene.paddings = layout.paddings;
  for (const Obstacle& o : layout.obstacles) {
    require(std::none_of(scene.objects.begin(), scene.objects.end(),
                         [&](const auto& other) { return other.name == o.name; }),
            "the obstacle '", o.name,
            "' is called as something else in the cell or scene; give it a name of its own");
    scene.objects.push_back({o.name, o.pieces, o.T_W_O});
  }
  return scene;
}

std::vector<Pose> view_poses(const CellLayout& layout, const Eigen::Vector3d& p_W_target, double distance) {
  const Eigen::Vector3d to_base = layout.T_W_R.translation() - p_W_target;
  const double towards_base = std::atan2(to_base.y(), to_base.x());
  std::vector<Pose> poses;
  for (const double elevation : {72.0, 60.0, 84.0, 48.0})
    for (const double aside : {0.0, 40.0, -40.0, 80.0, -80.0, 130.0, -130.0})
      for (const double roll : {180.0, 0.0, 90.0, -90.0}) {
        const double azimuth = towards_base + aside * kDegree;
        const double level = std::cos(elevation * kDegree);
        const Eigen::Vector3d direction(level * std::cos(azimuth), level * std::sin(azimuth),
                                        std::sin(elevation * kDegree));
        poses.push_back(camera_looking_at(p_W_target + distance * direction, p_W_target, roll * kDegree));
      }
  return poses;
}

std::optional<JointTrajectory> route_to_view(const CellLayout& layout, const PlanningScene& scene,
                                             const Joints& q_start, const std::vector<Pose>& T_W_C_candidates,
                                             const MotionOptions& options) {
  const Pose T_C_F = (layout.T_F_T * layout.T_T_C).inverse();
  for (const Pose& T_W_C : T_W_C_candidates)
    if (auto route = plan_transit(scene, q_start, Pose(T_W_C * T_C_F), options)) return route;
  return std::nullopt;
}

std::optional<JointTrajectory> plan_route_to_view(Cell& cell, const PlanningScene& scene,
                                                  const std::vector<Pose>& T_W_C_candidates,
                                                  const MotionOptions& options) {
  return route_to_view(cell.layout, scene, cell.arm.state().q, T_W_C_candidates, options);
}

CameraView take_view(Cell& cell, const RobotModel& robot, const JointTrajectory& route) {
  const MotionResult moved = cell.arm.follow(route);
  if (moved.status != MotionResult::Status::kDone)
    throw DeviceError("arm", "stopped on the route to a view: " + moved.reason,
                      "clear the cell and start again");
  const DepthFrame frame = cell.camera.capture();
  return {frame.image, camera_pose(cell.layout, robot, cell.arm.state().q)};
}

std::vector<Sighting> find_in_views(const std::vector<CameraView>& views, const DetectionModels& models,
                                    const std::vector<StoneIndex>& wanted, const KnownScene& scene,
                                    const DetectionOptions& options) {
  const Arrangement& before = scene.before;
  std::vector<Sighting> sightings;
  for (const auto& view : views)
    for (const auto* group : {&before.stack, &before.loose})
      for (const auto& placed : *group)
        if (const auto found =
                track_stone(view.image, models, placed.stone, view.T_W_C.inverse() * placed.T_W_O, options))
          keep_better(sightings, sighting_of(view.T_W_C, *found));
  // What is hidden too much to be found again is where it was if what stands on it is.
  std::vector<Sighting> explained = sightings;
  for (const PlacedStone& hidden : carrying(before.stack, sightings))
    explained.push_back({hidden.stone, hidden.T_W_O});
  const auto missing = unseen(wanted, explained);
  if (missing.empty()) return sightings;
  std::vector<Sighting> by_one;
  for (const auto& view : views)
    add(by_one, view.T_W_C,
        detect_stones(view.image, models, missing, options, known_in(view.T_W_C, explained)));
  std::vector<StoneIndex> for_all;
  for (const StoneIndex stone : missing) {
    const bool known = std::find(scene.known.begin(), scene.known.end(), stone) != scene.known.end();
    const auto found =
        std::find_if(by_one.begin(), by_one.end(), [&](const Sighting& s) { return s.stone == stone; });
    if (found != by_one.end() && (known || views.size() == 1))
      sightings.push_back(*found);
    else if (views.size() > 1 && (found != by_one.end() || known || scene.first))
      for_all.push_back(stone);
  }
  if (for_all.empty()) return sightings;
  for (const Sighting& s : sightings)
    if (!seen(explained, s.stone)) explained.push_back(s);
  const Pose& T_W_C = views.front().T_W_C;
  std::vector<DepthView> depths;
  for (const auto& view : views) depths.push_back({view.image, view.T_W_C});
  add(sightings, T_W_C, detect_stones(depths, models, for_all, options, known_in(T_W_C, explained)));
  return sightings;
}

}  // namespace stonestack::stacking
