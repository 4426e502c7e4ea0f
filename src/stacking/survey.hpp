#pragma once
#include <vector>

#include "stacking/journal.hpp"
#include "stonestack/hardware/cell.hpp"
#include "stonestack/motion/planning_scene.hpp"
#include "stonestack/stacking/observe.hpp"

/// Private to stacking/: views of things that nobody knows.
namespace stonestack::stacking {

/// A piece of surface that is worth seeing.
struct SurfaceElement {
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();
  Eigen::Vector3d n_W = Eigen::Vector3d::UnitZ();  ///< unit, outwards
  double area = 0.0;                               ///< [m^2]
};

/// A view, and where the arm said that the tool was.
struct SurveyView {
  CameraView view;
  Pose T_W_T = Pose::Identity();
};

/// Surface of a thing of unknown shape: a dome, as much from each side.
[[nodiscard]] std::vector<SurfaceElement> dome_over(const Eigen::Vector3d& p_W);

/// As `survey`, but none where no view is reached.
[[nodiscard]] std::vector<SurveyView> survey_if_reached(Cell& cell, const PlanningScene& scene,
                                                        const std::vector<SurfaceElement>& wanted,
                                                        const Eigen::Vector3d& p_W_target, int count,
                                                        double distance, const MotionOptions& options,
                                                        Journal* journal = nullptr);

/// Takes up to `count` views of `p_W_target` from `distance` m, each from the direction that tells most about
/// surface of which the views before told little: the next best view, among those that the arm reaches in the
/// scene. Fewer where it reaches no more or another tells nothing new. Each is in the journal before the arm
/// moves.
/// @throws DeviceError when no view at all is reached, or the arm stops.
[[nodiscard]] std::vector<SurveyView> survey(Cell& cell, const PlanningScene& scene,
                                             const std::vector<SurfaceElement>& wanted,
                                             const Eigen::Vector3d& p_W_target, int count, double distance,
                                             const MotionOptions& options, Journal* journal = nullptr);

}  // namespace stonestack::stacking
