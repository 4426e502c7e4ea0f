#include "stone/displaced_scan.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "stonestack/stone/model_stone.hpp"

namespace stonestack::stone {
namespace {

/// A limestone as it lies: its upper half is known to 0.2 mm, its lower half to 4 mm.
Stone half_known() {
  Stone stone = model_stone(make_limestone(9), "limestone", "generated").stone;
  SurfaceKnowledge known;
  Eigen::Vector3d up_O = Eigen::Vector3d::UnitZ();
  for (const Eigen::Vector3d& up : {Eigen::Vector3d::UnitZ().eval(), (-Eigen::Vector3d::UnitZ()).eval()})
    if (rests_with(stone.scan, stone.mass.p_O_M, up, 0.1)) up_O = up;
  for (const Eigen::Vector3d& p : stone.scan.vertices) {
    known.seen.push_back(up_O.dot(p - stone.mass.p_O_M) > 0.0 ? 1 : 0);
    known.sigma.push_back(known.seen.back() != 0 ? 0.0002 : 0.004);
  }
  known.up_O_at_rest = {up_O};
  stone.surface = known;
  return stone;
}

TEST(DisplacedScans, AgreeWithWhatIsKnown) {
  const Stone stone = half_known();
  const SurfaceKnowledge& known = *stone.surface;
  const Eigen::Vector3d& up_O = known.up_O_at_rest[0];
  double table = 1e9;
  for (const auto& p : stone.scan.vertices) table = std::min(table, up_O.dot(p));
  const std::vector<Mesh> scans = displaced_scans(stone, 4, 1);
  ASSERT_EQ(scans.size(), 4U);
  for (const Mesh& scan : scans) {
    ASSERT_EQ(scan.vertices.size(), stone.scan.vertices.size());
    double farthest = 0.0;
    for (std::size_t v = 0; v < scan.vertices.size(); ++v) {
      const double moved = (scan.vertices[v] - stone.scan.vertices[v]).norm();
      ASSERT_LE(moved, 2.5 * known.sigma[v] + 1e-9);
      ASSERT_GE(up_O.dot(scan.vertices[v]), table - 1e-9) << "not through the table";
      farthest = std::max(farthest, moved);
    }
    EXPECT_GT(farthest, 0.004);
    EXPECT_TRUE(rests_with(scan, stone.mass.p_O_M, up_O, 0.16));
  }
  EXPECT_GT((scans[0].vertices[0] - scans[1].vertices[0]).norm() +
                (scans[0].vertices.back() - scans[1].vertices.back()).norm(),
            1e-5);
  EXPECT_EQ(displaced_scans(stone, 4, 1)[3].vertices, scans[3].vertices) << "the same seed, the same scans";
}

TEST(DisplacedScans, ThereAreNoneOfAStoneThatWasScanned) {
  Stone stone = half_known();
  std::fill(stone.surface->sigma.begin(), stone.surface->sigma.end(), 0.0001);
  EXPECT_TRUE(displaced_scans(stone, 4, 1).empty()) << "known better than it matters";
  stone.surface.reset();
  EXPECT_TRUE(displaced_scans(stone, 4, 1).empty());
}

TEST(RestsWith, IsDecidedByTheFaceBelowTheCentreOfMass) {
  Mesh pyramid;  // on its square base, 8 cm wide and 6 cm high
  pyramid.vertices = {{-0.04, -0.04, 0}, {0.04, -0.04, 0}, {0.04, 0.04, 0}, {-0.04, 0.04, 0}, {0, 0, 0.06}};
  pyramid.faces = {{0, 2, 1}, {0, 3, 2}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  const Eigen::Vector3d p_O_M(0, 0, 0.015);
  EXPECT_TRUE(rests_with(pyramid, p_O_M, Eigen::Vector3d::UnitZ(), 0.1));
  EXPECT_FALSE(rests_with(pyramid, p_O_M, -Eigen::Vector3d::UnitZ(), 0.1)) << "on its tip";
  EXPECT_FALSE(rests_with(pyramid, {0.05, 0, 0.015}, Eigen::Vector3d::UnitZ(), 0.1))
      << "mass beyond the base";
}

}  // namespace
}  // namespace stonestack::stone
