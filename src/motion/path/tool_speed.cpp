#include "motion/path/tool_speed.hpp"

#include <algorithm>
#include <limits>
#include <vector>

#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::motion {

double fastest_with_tool(const PathPiece& piece, const ToolLimit& limit) {
  constexpr double kSpare = 1.005, kStep = 1e-5;  // rad
  const auto tool = [&](const Joints& q) {
    return (forward(limit.robot, q) * limit.T_F_T).translation().eval();
  };
  double per_radian = 0.0;  // m
  double speed = std::numeric_limits<double>::infinity();
  for (const double share : {0.0, 0.5, 1.0}) {
    const Joints q = piece.at(share * piece.length), t = piece.tangent_at(share * piece.length);
    per_radian = std::max(per_radian, (tool(q + kStep * t) - tool(q - kStep * t)).norm() / (2 * kStep));
    speed = std::min(speed, limit.speed(q));
  }
  return per_radian > 1e-9 ? speed / (kSpare * per_radian) : std::numeric_limits<double>::infinity();
}

ToolSpeed transit_speed(const PlanningScene& scene, const MotionOptions& options, int left_out,
                        double reach) {
  constexpr double kBetween = 0.02;  // m, by which the tool may come nearer between two points that are asked
  struct Box {
    Pose T_object_R;
    Eigen::AlignedBox3d box;
  };
  std::vector<Box> boxes;
  for (std::size_t i = 0; i < scene.objects.size(); ++i) {
    if (static_cast<int>(i) == left_out) continue;
    Box next{scene.objects[i].T_W_object.inverse() * scene.T_W_R, {}};
    for (const Mesh& piece : scene.objects[i].pieces)
      for (const auto& v : piece.vertices) next.box.extend(v);
    boxes.push_back(next);
  }
  const double near = options.near_distance + reach + kBetween;
  return
      [boxes = std::move(boxes), robot = scene.robot, T_F_T = scene.T_F_T, near, options](const Joints& q) {
        const Eigen::Vector3d p_R = (forward(robot, q) * T_F_T).translation();
        const bool is_near = std::any_of(boxes.begin(), boxes.end(), [&](const Box& b) {
          return b.box.exteriorDistance(b.T_object_R * p_R) < near;
        });
        return is_near ? std::min(options.near_speed, options.tool_speed) : options.tool_speed;
      };
}

}  // namespace stonestack::motion
