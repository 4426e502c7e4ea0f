#include "stacking/survey.hpp"

#include <algorithm>
#include <cmath>

#include "core/constants.hpp"
#include "motion/collision.hpp"
#include "stacking/record.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::stacking {
namespace {

constexpr double kElevations[] = {75.0, 62.0, 50.0, 40.0, 30.0};  // degrees
constexpr double kAzimuthStep = 30.0;                             // degrees
constexpr double kRolls[] = {180.0, 0.0, 90.0, -90.0};            // degrees about the optical axis
constexpr double kMinCosine = 0.25;                               // of a view on surface that it shows
constexpr double kSeenWell = 0.6;        // sum of squared cosines: more shows it no better
constexpr double kMinGainOfView = 0.01;  // of the wanted area: less is no view worth

/// Direction from the target to the camera.
struct Direction {
  Eigen::Vector3d n_W;
  double gain = 0.0;
};

std::vector<Direction> directions_around(const CellLayout& layout, const Eigen::Vector3d& p_W_target) {
  const Eigen::Vector3d to_base = layout.T_W_R.translation() - p_W_target;
  const double towards_base = std::atan2(to_base.y(), to_base.x());
  std::vector<Direction> directions;
  for (const double elevation : kElevations)
    for (double aside = -180.0; aside < 180.0 - 1e-9; aside += kAzimuthStep) {
      const double azimuth = towards_base + aside * kDegree, level = std::cos(elevation * kDegree);
      directions.push_back(
          {{level * std::cos(azimuth), level * std::sin(azimuth), std::sin(elevation * kDegree)}});
    }
  return directions;
}

/// Weight of a view from a direction for surface, as in the models: the square of the cosine.
double shown(const SurfaceElement& element, const Eigen::Vector3d& n_W) {
  const double cosine = element.n_W.dot(n_W);
  return cosine < kMinCosine ? 0.0 : cosine * cosine;
}

std::vector<Pose> cameras_at(const Eigen::Vector3d& p_W_target, const Eigen::Vector3d& n_W, double distance) {
  std::vector<Pose> poses;
  for (const double roll : kRolls)
    poses.push_back(camera_looking_at(p_W_target + distance * n_W, p_W_target, roll * kDegree));
  return poses;
}

/// Names the parts of arm and scene that touch where the arm stands; empty if none do.
std::string in_the_way(const Cell& cell, const PlanningScene& scene, const MotionOptions& options) {
  CollisionRules rules;
  rules.opening = scene.opening;
  const Clearance nearest = CollisionChecker(scene, rules).clearance(cell.arm.state().q);
  if (nearest.distance >= options.transit_padding) return "";
  return concat(": where the arm stands, ", nearest.first, " and ", nearest.second, " are ",
                std::round(1e4 * nearest.distance) / 10, " mm apart");
}

}  // namespace

std::vector<SurfaceElement> dome_over(const Eigen::Vector3d& p_W) {
  constexpr int kElements = 200;
  const double golden = M_PI * (3.0 - std::sqrt(5.0));
  std::vector<SurfaceElement> dome;
  for (int k = 0; k < kElements; ++k) {  // Fibonacci lattice, down to 10 deg below the level
    const double z = 1.0 - 1.17 * (k + 0.5) / kElements, level = std::sqrt(1.0 - z * z);
    dome.push_back({p_W, {level * std::cos(golden * k), level * std::sin(golden * k), z}, 1.0});
  }
  return dome;
}

std::vector<SurveyView> survey_if_reached(Cell& cell, const PlanningScene& scene,
                                          const std::vector<SurfaceElement>& wanted,
                                          const Eigen::Vector3d& p_W_target, int count, double distance,
                                          const MotionOptions& options, Journal* journal) {
  std::vector<Direction> directions = directions_around(cell.layout, p_W_target);
  std::vector<double> seen(wanted.size(), 0.0);
  double all = 0.0;
  for (const SurfaceElement& element : wanted) all += element.area;
  std::vector<SurveyView> views;
  while (static_cast<int>(views.size()) < count) {
    for (Direction& direction : directions) {
      direction.gain = 0.0;
      for (std::size_t i = 0; i < wanted.size(); ++i)
        direction.gain +=
            wanted[i].area * (std::min(1.0, (seen[i] + shown(wanted[i], direction.n_W)) / kSeenWell) -
                              std::min(1.0, seen[i] / kSeenWell));
    }
    std::stable_sort(directions.begin(), directions.end(),
                     [](const Direction& a, const Direction& b) { return a.gain > b.gain; });
    std::optional<JointTrajectory> route;
    while (!route && !directions.empty() && directions.front().gain > kMinGainOfView * all) {
      throw_if_interrupted();
      route =
          plan_route_to_view(cell, scene, cameras_at(p_W_target, directions.front().n_W, distance), options);
      if (!route) directions.erase(directions.begin());
    }
    if (!route) break;
    const Eigen::Vector3d n_W = directions.front().n_W;
    directions.erase(directions.begin());
    record(journal, StepBegun{"move to a view"});
    SurveyView taken;
    taken.view = take_view(cell, scene.robot, *route);
    taken.T_W_T = taken.view.T_W_C * cell.layout.T_T_C.inverse();
    views.push_back(std::move(taken));
    for (std::size_t i = 0; i < wanted.size(); ++i) seen[i] += shown(wanted[i], n_W);
  }
  return views;
}

std::vector<SurveyView> survey(Cell& cell, const PlanningScene& scene,
                               const std::vector<SurfaceElement>& wanted, const Eigen::Vector3d& p_W_target,
                               int count, double distance, const MotionOptions& options, Journal* journal) {
  std::vector<SurveyView> views =
      survey_if_reached(cell, scene, wanted, p_W_target, count, distance, options, journal);
  if (views.empty())
    throw DeviceError("arm", "no view of the field can be reached" + in_the_way(cell, scene, options),
                      "check the cell's layout: field, robot base and camera mount");
  return views;
}

}  // namespace stonestack::stacking
