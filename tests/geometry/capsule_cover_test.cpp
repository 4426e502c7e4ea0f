#include "geometry/capsule_cover.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "geometry/rough_stone.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::geometry {
namespace {

void add(Mesh& mesh, const Mesh& other) {
  const auto offset = static_cast<int>(mesh.vertices.size());
  mesh.vertices.insert(mesh.vertices.end(), other.vertices.begin(), other.vertices.end());
  for (const auto& f : other.faces) mesh.faces.push_back(f + Eigen::Vector3i::Constant(offset));
}

/// A tube without ends, of 24 long thin faces each way, as CAD exports it.
Mesh make_tube(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double radius) {
  const Eigen::Vector3d n = (to - from).normalized(), x = n.unitOrthogonal(), y = n.cross(x);
  Mesh mesh;
  constexpr int kSides = 24;
  for (int i = 0; i < kSides; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / kSides;
    const Eigen::Vector3d out = radius * (std::cos(angle) * x + std::sin(angle) * y);
    mesh.vertices.push_back(from + out);
    mesh.vertices.push_back(to + out);
    const int a = 2 * i, b = 2 * ((i + 1) % kSides);
    mesh.faces.emplace_back(a, b, a + 1);
    mesh.faces.emplace_back(b, b + 1, a + 1);
  }
  return mesh;
}

/// Like an upper arm: a long tube with a joint across either end, both to the same side.
Mesh make_bracket() {
  Mesh mesh = make_tube({0, 0, 0.12}, {-0.6, 0, 0.12}, 0.05);
  add(mesh, make_tube({0, 0, 0}, {0, 0, 0.18}, 0.07));
  add(mesh, make_tube({-0.6, 0, 0}, {-0.6, 0, 0.18}, 0.06));
  return mesh;
}

double out_of_all(const std::vector<Capsule>& capsules, const Eigen::Vector3d& p) {
  double min = std::numeric_limits<double>::infinity();
  for (const Capsule& c : capsules) min = std::min(min, distance(c, p));
  return min;
}

double total(const std::vector<Capsule>& capsules) {
  double sum = 0.0;
  for (const Capsule& c : capsules) sum += volume(c);
  return sum;
}

TEST(CapsuleCover, LeavesNoPointOfTheSurfaceOut) {
  Random random = Random::stream(11, "capsule cover");
  for (int trial = 0; trial < 12; ++trial) {
    Mesh mesh = trial % 3 == 0 ? make_bracket() : make_rough_stone(static_cast<std::uint64_t>(trial), 2);
    Pose T = Pose::Identity();
    T.linear() = Eigen::AngleAxisd(random.uniform(0, 3), random.unit_vector()).toRotationMatrix();
    T.translation() = random.unit_vector();
    mesh = transformed(mesh, T);
    const auto capsules = cover_by_capsules(mesh, static_cast<std::size_t>(1 + trial % 6));
    EXPECT_LE(capsules.size(), static_cast<std::size_t>(1 + trial % 6));
    for (const SurfaceSample& s : sample_surface(mesh, 0.003))
      ASSERT_LE(out_of_all(capsules, s.point), 1e-9) << "trial " << trial;
  }
}

TEST(CapsuleCover, FindsTheCapsuleThatAMeshIs) {
  Mesh mesh = make_sphere(0.05, 3);
  const Eigen::Vector3d end = Eigen::Vector3d(1, 2, -2).normalized() * 0.2;
  for (auto& v : mesh.vertices)
    if (v.dot(end) > 0.0) v += end;
  const auto capsules = cover_by_capsules(mesh, 6);
  ASSERT_EQ(capsules.size(), 1u);
  EXPECT_NEAR(capsules[0].radius, 0.05, 0.0005);
  EXPECT_NEAR((capsules[0].b - capsules[0].a).norm(), 0.2, 0.01) << "the ends are blunter than spheres";
}

TEST(CapsuleCover, SplitsABracketAtItsJoints) {
  const Mesh bracket = make_bracket();
  const auto one = cover_by_capsules(bracket, 1), six = cover_by_capsules(bracket, 6);
  ASSERT_EQ(one.size(), 1u);
  EXPECT_GE(six.size(), 3u);
  // Its three tubes, closed, hold 0.0047 + 0.0028 + 0.0020 m^3.
  EXPECT_LT(total(six), 0.0145);
  EXPECT_GT(total(one), 0.015);
  EXPECT_GT(out_of_all(six, {-0.3, 0, 0.0}), 0.03) << "the space between the joints is free";
}

TEST(CapsuleCover, TakesFlatAndTinyMeshes) {
  Mesh flat;
  flat.vertices = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  flat.faces = {{0, 1, 2}};
  const auto capsules = cover_by_capsules(flat, 3);
  for (const auto& s : sample_surface(flat, 0.02)) EXPECT_LE(out_of_all(capsules, s.point), 0.0);
  const Mesh tiny = scaled(flat, 1e-6);
  for (const auto& v : tiny.vertices) EXPECT_LE(out_of_all(cover_by_capsules(tiny, 3), v), 0.0);
}

TEST(CapsuleCover, RefusesWhatHasNoSurface) {
  EXPECT_THROW((void)cover_by_capsules({}, 3), InvalidArgument);
  Mesh point;
  point.vertices = {{1, 1, 1}};
  point.faces = {{0, 0, 0}};
  EXPECT_THROW((void)cover_by_capsules(point, 3), InvalidArgument);
  point.vertices[0].x() = std::nan("");
  EXPECT_THROW((void)cover_by_capsules(point, 3), InvalidArgument);
}

}  // namespace
}  // namespace stonestack::geometry
