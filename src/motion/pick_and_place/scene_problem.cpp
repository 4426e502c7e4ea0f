#include "stonestack/motion/pick_and_place.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "motion/collision.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::motion {
namespace {

constexpr double kOverlap = 0.008;  // m: what stones that are seen may overlap by

/// Amount by which the deepest of `points` lies in a convex body [m]; 0 if none does.
double depth_in(const Mesh& body, const Pose& T_body_points, const std::vector<Eigen::Vector3d>& points) {
  const std::vector<Eigen::Vector3d> normals = face_normals(body);
  double deepest = 0.0;
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector3d p = T_body_points * point;
    double depth = std::numeric_limits<double>::infinity();
    for (std::size_t f = 0; f < body.faces.size() && depth > deepest; ++f) {
      if (normals[f].isZero()) continue;  // a sliver bounds nothing
      depth = std::min(depth, normals[f].dot(body.vertices[static_cast<std::size_t>(body.faces[f][0])] - p));
    }
    if (std::isfinite(depth)) deepest = std::max(deepest, depth);
  }
  return deepest;
}

double overlap(const Stone& stone, const Pose& T_W_O, const SceneObject& object) {
  const Pose T_B_O = object.T_W_object.inverse() * T_W_O, T_O_B = T_B_O.inverse();
  double deepest = 0.0;
  for (const Mesh& piece : object.pieces) {
    deepest = std::max(deepest, depth_in(piece, T_B_O, stone.scan.vertices));
    for (const Mesh& own : stone.pieces) deepest = std::max(deepest, depth_in(own, T_O_B, piece.vertices));
  }
  return deepest;
}

std::string millimetres(double metres) {
  return concat(std::lround(1e3 * metres), " mm");
}

/// The limit of the cell that the arm breaks; empty where that is not known.
std::string outside_limits(const RobotModel& robot, const Joints& q) {
  std::string text = describe_outside_workspace(robot, q, -kWorkspaceMargin);
  if (text.empty()) text = describe_outside_fence(robot, q, -kWorkspaceMargin);
  return text;
}

}  // namespace

std::string start_problem(const PlanningScene& scene, const Joints& q_start) {
  CollisionRules rules;
  rules.padding = rules.self_padding = 0.0;
  rules.opening = scene.opening;
  const CollisionChecker checker(scene, rules);
  if (!checker.collides(q_start)) return {};
  const Clearance c = checker.clearance(q_start);
  if (c.distance > 0.0) {
    if (const std::string outside = outside_limits(scene.robot, q_start); !outside.empty())
      return "at the start " + outside;
    return concat("at the start ", c.first, " and ", c.second, " are ", millimetres(c.distance),
                  " apart, nearer than their padding, or fingers or camera leave the fence");
  }
  return concat("at the start the arm stands in something: ", c.first, " and ", c.second, " overlap");
}

std::string scene_problem(const PlanningScene& scene, const PickAndPlaceTask& task) {
  require(task.stone != nullptr, "a task needs a stone");
  const Stone& stone = *task.stone;
  double lowest = scene.table_z;
  for (const Eigen::Vector3d& p : stone.scan.vertices) lowest = std::min(lowest, (task.T_W_O_pick * p).z());
  if (scene.table_z - lowest > kOverlap)
    return concat(stone.name, " reaches ", millimetres(scene.table_z - lowest),
                  " into the table where it lies");
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    if (static_cast<int>(i) == task.object) continue;
    if (const double depth = overlap(stone, task.T_W_O_pick, scene.objects[i]); depth > kOverlap)
      return concat(stone.name, " and ", scene.objects[i].name, " overlap by ", millimetres(depth),
                    " where they are");
  }
  return start_problem(scene, task.q_start);
}

}  // namespace stonestack::motion
