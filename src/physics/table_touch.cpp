#include <algorithm>

#include "physics/first_touch.hpp"

namespace stonestack::physics {

std::vector<Touch> TablePairs::touches(const Surface& A, const Pose& T_W_A) {
  const SurfaceFeatures& x = *A.features;
  if (!fresh_ || moved_enough(T_W_A_, T_W_A, radius_about_origin(x), kSlack, kTurn)) {
    fresh_ = true;
    T_W_A_ = T_W_A;
    vertices_.clear();
    const Eigen::Vector3d up_A = T_W_A.linear().transpose() * Eigen::Vector3d::UnitZ();
    for (const SampleBall& group : x.groups) {
      if ((T_W_A * group.centre).z() > group.radius + kReach) continue;
      for (int b = group.begin; b < group.end; ++b) {
        const SampleBall& ball = x.balls[static_cast<std::size_t>(b)];
        if ((T_W_A * ball.centre).z() > ball.radius + kReach) continue;
        for (int i = ball.begin; i < ball.end; ++i) {
          const FeatureSample& s = x.samples[static_cast<std::size_t>(i)];
          if (s.vertex >= 0 && (T_W_A * s.p).z() <= kReach && leads(x, s.vertex, up_A, kCone + kTurn))
            vertices_.push_back(s.vertex);
        }
      }
    }
    std::sort(vertices_.begin(), vertices_.end());
  }
  std::vector<Touch> out;
  const Eigen::Vector3d up_A = T_W_A.linear().transpose() * Eigen::Vector3d::UnitZ();
  for (const int v : vertices_) {
    const Eigen::Vector3d& p_A = x.vertices[static_cast<std::size_t>(v)];
    const Eigen::Vector3d p = T_W_A * p_A;
    if (p.z() > kTouchGap || !leads(x, v, up_A, kCone)) continue;
    out.push_back({TouchKind::kVertexOfA, v, -1, {p.x(), p.y(), 0.0}, Eigen::Vector3d::UnitZ(), p.z(), p_A});
  }
  return out;
}

}  // namespace stonestack::physics
