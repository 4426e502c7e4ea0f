#include "modelling/smooth_seen.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "stonestack/core/random.hpp"

namespace stonestack::modelling {
namespace {

constexpr double kRadius = 0.04;   // m
constexpr double kNoise = 0.0004;  // m

/// A ball of 4 cm with waves of 0.5 mm, 25 mm long, along z; without noise.
double radius_at(double z) {
  return kRadius + 0.0005 * std::sin(2.0 * M_PI * z / 0.025);
}

struct NoisyBall {
  Mesh mesh = make_sphere(kRadius, 4);
  std::vector<char> seen;

  NoisyBall() {
    Random random = Random::stream(3, "noisy ball");
    for (Eigen::Vector3d& p : mesh.vertices) {
      seen.push_back(p.x() > -0.01 ? 1 : 0);
      p = (radius_at(p.z()) + random.normal(0.0, kNoise)) * p.normalized();
    }
  }
  /// Root of the mean square of the distance from the ball without noise, of what was seen.
  [[nodiscard]] double error() const {
    double squares = 0.0, count = 0.0;
    for (std::size_t v = 0; v < seen.size(); ++v) {
      if (seen[v] == 0) continue;
      const Eigen::Vector3d& p = mesh.vertices[v];
      squares += std::pow(p.norm() - radius_at(p.z()), 2);
      ++count;
    }
    return std::sqrt(squares / count);
  }
};

TEST(SmoothSeen, TakesOutNoiseAndKeepsWaves) {
  NoisyBall ball;
  EXPECT_NEAR(ball.error(), kNoise, 0.1 * kNoise);
  smooth_seen(ball.mesh, ball.seen);
  EXPECT_LT(ball.error(), 0.6 * kNoise);
}

TEST(SmoothSeen, LeavesWhatWasCompleted) {
  NoisyBall ball;
  const Mesh before = ball.mesh;
  smooth_seen(ball.mesh, ball.seen);
  ASSERT_EQ(ball.mesh.faces.size(), before.faces.size());
  for (std::size_t v = 0; v < before.vertices.size(); ++v)
    EXPECT_EQ(ball.mesh.vertices[v] == before.vertices[v], ball.seen[v] == 0) << v;
}

TEST(SmoothSeen, LeavesAMeshOfFewVertices) {
  Mesh box = make_box({0.1, 0.1, 0.1});
  const Mesh before = box;
  smooth_seen(box, std::vector<char>(box.vertices.size(), 1));
  EXPECT_EQ(box.vertices, before.vertices);
}

}  // namespace
}  // namespace stonestack::modelling
