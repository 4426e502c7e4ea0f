#include "stone/possible_stone.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "stone/geodesic.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::stone {
namespace {

constexpr double kSigma = 0.002;  // m, of the upper half; the lower one is known

/// A ball of 50 mm radius that lay on its lower pole, its upper half known to 2 mm.
Stone ball() {
  Stone stone;
  stone.name = "ball";
  stone.scan = make_geodesic(12);
  for (auto& v : stone.scan.vertices) v *= 0.05;
  stone.mass = mass_properties(stone.scan, 2600.0);
  SurfaceKnowledge& surface = stone.surface.emplace();
  for (const auto& v : stone.scan.vertices) {
    surface.sigma.push_back(v.z() > 0.0 ? kSigma : 0.0);
    surface.seen.push_back(v.z() > 0.0 ? 0 : 1);
  }
  surface.up_O_at_rest = {Eigen::Vector3d::UnitZ()};
  return stone;
}

TEST(PossibleStone, ErrsByTheStandardDeviation) {
  const Stone known = ball();
  double squares = 0.0;
  int count = 0;
  for (int draw = 0; draw < 60; ++draw) {
    const Stone stone = possible_stone(known, draw);
    for (std::size_t v = 0; v < known.scan.vertices.size(); ++v) {
      const double moved = (stone.scan.vertices[v] - known.scan.vertices[v]).norm();
      if (known.surface->sigma[v] == 0.0) {
        EXPECT_EQ(moved, 0.0);
        continue;
      }
      squares += moved * moved, ++count;
    }
  }
  EXPECT_NEAR(std::sqrt(squares / count), kSigma, 0.1 * kSigma);
}

TEST(PossibleStone, ErrsAlikeWherePlacesAreNear) {
  const Stone known = ball(), stone = possible_stone(known, 3);
  const auto height = [&](int v) { return stone.scan.vertices[static_cast<std::size_t>(v)].norm() - 0.05; };
  double steps = 0.0, all = 0.0;
  for (const Eigen::Vector3i& face : known.scan.faces) {
    if (known.scan.vertices[static_cast<std::size_t>(face[0])].z() < 0.02) continue;
    steps += std::abs(height(face[0]) - height(face[1]));
    all += std::abs(height(face[0]));
  }
  EXPECT_GT(all, 0.0);
  EXPECT_LT(steps, 0.5 * all);  // between neighbours 5 mm apart; independent errors: 1.4
}

TEST(PossibleStone, KeepsItsMassAndMovesItsCentreOfMass) {
  const Stone known = ball(), stone = possible_stone(known, 0);
  EXPECT_NEAR(stone.mass.mass, known.mass.mass, 1e-12);
  EXPECT_GT((stone.mass.p_O_M - known.mass.p_O_M).norm(), 5e-5);
  EXPECT_LT((stone.mass.p_O_M - known.mass.p_O_M).norm(), kSigma);
  EXPECT_EQ(check(stone.mass), "");
}

TEST(PossibleStone, ItsCentreOfMassIsAsFarOffAsMeasured) {
  Stone known = ball();
  const Eigen::Vector3d offset_O(0.003, -0.002, 0.001);
  const Stone even = possible_stone(known, 1);
  known.mass.p_O_M += offset_O;
  EXPECT_LT((possible_stone(known, 1).mass.p_O_M - even.mass.p_O_M - offset_O).norm(), 1e-9);
}

TEST(PossibleStone, DoesNotReachIntoTheTableThatItLayOn) {
  Stone known = ball();
  std::fill(known.surface->sigma.begin(), known.surface->sigma.end(), kSigma);
  for (int draw = 0; draw < 20; ++draw)
    for (const auto& p : possible_stone(known, draw).scan.vertices) EXPECT_GE(p.z(), -0.05 - 1e-12);
  known.surface->up_O_at_rest.clear();
  double lowest = 0.0;
  for (int draw = 0; draw < 20; ++draw)
    for (const auto& p : possible_stone(known, draw).scan.vertices) lowest = std::min(lowest, p.z());
  EXPECT_LT(lowest, -0.051);
}

TEST(PossibleStone, EachDrawIsAnotherAndRepeats) {
  const Stone known = ball();
  EXPECT_EQ(possible_stone(known, 4).scan.vertices, possible_stone(known, 4).scan.vertices);
  EXPECT_NE(possible_stone(known, 4).scan.vertices, possible_stone(known, 5).scan.vertices);
}

TEST(PossibleStone, AScannedStoneIsAsItIs) {
  Stone known = ball();
  known.surface.reset();
  EXPECT_EQ(possible_stone(known, 4).scan.vertices, known.scan.vertices);
}

TEST(PossibleStone, RefusesASurfaceOfAnotherScan) {
  Stone known = ball();
  known.surface->sigma.pop_back();
  EXPECT_THROW((void)possible_stone(known, 0), InvalidArgument);
}

}  // namespace
}  // namespace stonestack::stone
