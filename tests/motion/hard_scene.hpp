#pragma once
#include <numbers>
#include <vector>

#include "kinematics/inverse.hpp"
#include "rooms.hpp"
#include "stonestack/hardware/cell.hpp"
#include "stonestack/motion/planning_scene.hpp"

namespace stonestack::test {

/// The hard set of `stonestack-bench motion`: a UR10, towers, a post and bars between stones and site.
inline PlanningScene hard_scene() {
  PlanningScene scene;
  scene.robot = read_robot("ur10");
  scene.T_F_T = CellLayout().T_F_T;
  const auto box = [&](const char* name, const Eigen::Vector3d& size, const Eigen::Vector3d& p) {
    scene.objects.push_back({name, {make_box(size)}, make_pose(p)});
  };
  box("first tower", {0.14, 0.14, 0.45}, {0.62, 0.05, 0.225});
  box("second tower", {0.14, 0.14, 0.45}, {0.90, 0.05, 0.225});
  box("post", {0.05, 0.05, 1.2}, {0.50, -0.45, 0.6});
  box("lower bar", {1.2, 0.04, 0.04}, {0.75, 0.05, 0.60});
  box("upper bar", {1.2, 0.04, 0.04}, {0.75, 0.05, 1.10});
  return scene;
}

/// All joints that bring the tool there, pointing down, turned about the vertical (rad).
inline std::vector<Joints> tool_down_at(const PlanningScene& scene, const Eigen::Vector3d& p_W_tip,
                                        double turn) {
  constexpr double kQuarter = 0.5 * std::numbers::pi;
  const Pose T_W_T =
      make_pose(p_W_tip, Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ()) * Eigen::Quaterniond(0, 1, 0, 0));
  Joints near;
  near << 0, -kQuarter, kQuarter, -kQuarter, -kQuarter, 0;
  std::vector<Joints> all;
  for (const auto& s : inverse(scene.robot, T_W_T * scene.T_F_T.inverse(), near)) all.push_back(s.q);
  return all;
}

}  // namespace stonestack::test
