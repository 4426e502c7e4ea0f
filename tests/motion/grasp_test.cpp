#include "motion/grasp.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "motion/grasp/grasp_wrench.hpp"
#include "motion/grasp/nonnegative_least_squares.hpp"
#include "motion/grasp_cache.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"

namespace stonestack::motion {
namespace {

Stone box_stone(const Eigen::Vector3d& size, double density = 2600.0) {
  Stone stone;
  stone.name = "box";
  stone.scan = stone.mesh = make_box(size);
  stone.mass = mass_properties(stone.scan, density);
  return stone;
}

GraspOptions few() {
  GraspOptions options;
  options.directions = 60;
  return options;
}

const GripperModel kGripper = make_robotiq_3f();

TEST(Grasp, OnABoxEveryGraspIsAntipodal) {
  const Eigen::Vector3d size(0.12, 0.09, 0.06);
  const GraspSet set = grasp_candidates(box_stone(size), kGripper, few());
  ASSERT_GT(set.grasps.size(), 20u);
  for (const Grasp& grasp : set.grasps) {
    const Eigen::Vector3d x = grasp.T_O_T.linear().col(0);
    EXPECT_GT(grasp.n_O_contact[0].dot(x), 0.7);
    EXPECT_LT((grasp.n_O_contact[1] + grasp.n_O_contact[2]).dot(x) / 2, -0.7);
    ASSERT_EQ(grasp.contacts, 3);
    for (std::size_t i = 0; i < 3; ++i)
      EXPECT_LT((grasp.p_O_contact[i].cwiseAbs() - size / 2).maxCoeff(), 1e-9) << "contact off the box";
    EXPECT_GT(grasp.opening, size.minCoeff() - 1e-6);
    EXPECT_LT(grasp.opening, kGripper.max_opening);
    EXPECT_GE(grasp.pre_opening, grasp.opening);
  }
}

TEST(Grasp, TheGripperStaysOutOfTheStone) {
  const Stone stone = box_stone({0.14, 0.10, 0.07});
  for (const Grasp& grasp : grasp_candidates(stone, kGripper, few()).grasps) {
    const Pose T_T_O = grasp.T_O_T.inverse();
    for (const SurfaceSample& sample : sample_surface(stone.scan, 0.004)) {
      const Eigen::Vector3d p = T_T_O * sample.point;
      for (const GripperBox& box : kGripper.boxes) {
        const Eigen::Vector3d shift(box.finger_side * grasp.opening / 2, 0, 0);
        const Eigen::Vector3d inside =
            box.size / 2 - (p - box.p_T_centre - shift).cwiseAbs();  // all positive: p is in the box
        EXPECT_LT(inside.minCoeff(), 0.006) << p.transpose();
      }
    }
  }
}

TEST(Grasp, TooWideAndTooHeavyAreCounted) {
  const GraspSet wide = grasp_candidates(box_stone({0.25, 0.25, 0.25}), kGripper, few());
  EXPECT_TRUE(wide.grasps.empty());
  EXPECT_GT(wide.too_wide, 0);
  EXPECT_NEAR(wide.narrowest, 0.25, 0.02);
  const GraspSet heavy = grasp_candidates(box_stone({0.12, 0.09, 0.06}, 20000.0), kGripper, few());
  EXPECT_TRUE(heavy.grasps.empty());
  EXPECT_GT(heavy.too_heavy, 0);
}

/// Apart, fingers B and C go past a stone that is shorter than the gap of 42 mm between them; drawn together
/// they hold it.
TEST(Grasp, NeedsBothFingersBAndC) {
  const Stone stone = box_stone({0.028, 0.026, 0.024});
  GripperModel stiff = kGripper;
  stiff.narrow_spacing = 0.0;
  const GraspSet apart = grasp_candidates(stone, stiff, few());
  EXPECT_TRUE(apart.grasps.empty());
  EXPECT_GT(apart.no_contact, 0);
  const GraspSet set = grasp_candidates(stone, kGripper, few());
  ASSERT_FALSE(set.grasps.empty());
  for (const Grasp& grasp : set.grasps) {
    EXPECT_EQ(grasp.spacing, kGripper.narrow_spacing);
    const Pose T_T_O = grasp.T_O_T.inverse();
    EXPECT_GT((T_T_O * grasp.p_O_contact[1]).y(), (T_T_O * grasp.p_O_contact[2]).y());
  }
}

TEST(Grasp, SpacedFingersArePreferred) {
  const GraspSet set = grasp_candidates(box_stone({0.12, 0.09, 0.06}), kGripper, few());
  double wide = 0.0, narrow = 0.0;
  for (const Grasp& grasp : set.grasps)
    (grasp.spacing == kGripper.finger_spacing ? wide : narrow) =
        std::max(grasp.spacing == kGripper.finger_spacing ? wide : narrow, grasp.score);
  EXPECT_GT(narrow, 0.0);
  EXPECT_GT(wide, narrow);
}

TEST(Grasp, InAConeOnlySuchApproachesAreSampled) {
  const Stone stone = box_stone({0.12, 0.09, 0.06});
  GraspOptions options = few();
  options.directions = 600;
  options.cone = 0.4;
  options.n_O_towards = Eigen::Vector3d(0.2, 0.1, -1.0).normalized();
  const GraspSet set = grasp_candidates(stone, kGripper, options);
  ASSERT_FALSE(set.grasps.empty());
  for (const Grasp& grasp : set.grasps)
    EXPECT_GE(grasp.T_O_T.linear().col(2).dot(options.n_O_towards), std::cos(0.4) - 1e-9);
  EXPECT_NE(cached_grasps(stone, kGripper, options), cached_grasps(stone, kGripper, few()));
  const GraspSet both = joined(set, grasp_candidates(stone, kGripper, few()));
  EXPECT_GT(both.grasps.size(), set.grasps.size());
  EXPECT_GT(both.tried, set.tried);
  for (std::size_t i = 1; i < both.grasps.size(); ++i)
    EXPECT_LE(both.grasps[i].score, both.grasps[i - 1].score);
  options.n_O_towards = Eigen::Vector3d(0, 0, -2);
  EXPECT_THROW((void)grasp_candidates(stone, kGripper, options), InvalidArgument);
}

TEST(Grasp, SameStoneSameGrasps) {
  const Stone stone = box_stone({0.12, 0.09, 0.06});
  const GraspSet a = grasp_candidates(stone, kGripper, few());
  const auto b = cached_grasps(stone, kGripper, few());
  ASSERT_EQ(a.grasps.size(), b->grasps.size());
  for (std::size_t i = 0; i < a.grasps.size(); ++i)
    EXPECT_EQ(a.grasps[i].T_O_T.matrix(), b->grasps[i].T_O_T.matrix());
  EXPECT_EQ(b, cached_grasps(stone, kGripper, few()));
  GraspOptions other = few();
  other.yaws = 8;
  EXPECT_NE(b, cached_grasps(stone, kGripper, other));
}

/// An experiment meets new stones run after run.
TEST(Grasp, OnlyTheLastUsedSetsAreKept) {
  GraspOptions options = few();
  options.directions = 12;
  options.yaws = 4;
  const auto grasps = [&](double length) {
    return cached_grasps(box_stone({length, 0.09, 0.06}), kGripper, options);
  };
  const std::weak_ptr<const GraspSet> first = grasps(0.11);
  const auto held = grasps(0.12);
  EXPECT_EQ(grasps(0.11), first.lock());
  for (std::size_t k = 0; k < kMaxGraspSets; ++k) (void)grasps(0.121 + 0.0001 * static_cast<double>(k));
  EXPECT_TRUE(first.expired());
  EXPECT_EQ(grasps(0.12), held) << "what somebody holds is found";
}

TEST(Grasp, StoneWithoutMassIsRefused) {
  Stone stone = box_stone({0.1, 0.1, 0.1});
  stone.mass.mass = 0.0;
  EXPECT_THROW((void)grasp_candidates(stone, kGripper), InvalidArgument);
}

GraspContacts pinch(double tilt) {
  GraspContacts contacts;
  contacts.p_T = {Eigen::Vector3d(0.04, 0, 0), Eigen::Vector3d(-0.04, 0.03, 0),
                  Eigen::Vector3d(-0.04, -0.03, 0)};
  contacts.n_T = {Eigen::Vector3d(std::cos(tilt), 0, std::sin(tilt)), -Eigen::Vector3d::UnitX(),
                  -Eigen::Vector3d::UnitX()};
  return contacts;
}

TEST(GraspWrench, SqueezeHoldsUpToTheFrictionAngle) {
  // All forces lie in the plane z = 0 through the contacts, so A's face may tilt by atan(0.5) = 0.464.
  EXPECT_TRUE(squeeze_holds(pinch(0.0), 0.5));
  EXPECT_TRUE(squeeze_holds(pinch(0.38), 0.5));
  EXPECT_FALSE(squeeze_holds(pinch(0.50), 0.5));
  EXPECT_FALSE(squeeze_holds(pinch(0.2), 0.05));
}

TEST(GraspWrench, CentredPinchCarriesByFriction) {
  const auto force = force_per_weight(pinch(0.0), 0.5);
  ASSERT_TRUE(force.has_value());
  // Across the closing axis both sides carry mu N each: N = w / (2 mu) = w. Pyramids lose up to 1 - cos 30
  // deg.
  for (const std::size_t d : {2u, 3u, 4u, 5u}) EXPECT_NEAR((*force)[d], 1.0, 0.16) << d;
  Grasp grasp;
  grasp.force_per_weight = {1, 2, 3, 4, 5, 6};
  EXPECT_DOUBLE_EQ(holding_force(grasp, 10.0, {0, 0, -1}), 60.0);
  EXPECT_DOUBLE_EQ(holding_force(grasp, 10.0, {0.6, 0.8, 0}), 10 * (0.6 + 0.8 * 3));
}

TEST(NonnegativeLeastSquares, MatchesTheOptimalityConditions) {
  for (std::uint64_t trial = 0; trial < 300; ++trial) {
    Random random = Random::stream(5, trial);
    Eigen::MatrixXd A(6, 18);
    for (Eigen::Index i = 0; i < A.size(); ++i) A.data()[i] = random.normal();
    NonnegativeLeastSquares problem(A, 1e-5);
    for (int right_side = 0; right_side < 2; ++right_side) {
      Eigen::VectorXd b(6);
      for (Eigen::Index i = 0; i < 6; ++i) b[i] = random.normal();
      const Eigen::VectorXd x = problem.solve(b);
      const Eigen::VectorXd gradient = A.transpose() * (A * x - b) + 1e-5 * x;
      for (Eigen::Index i = 0; i < x.size(); ++i) {
        EXPECT_GE(x[i], 0.0);
        EXPECT_GE(gradient[i], -1e-7);
        EXPECT_LT(std::abs(gradient[i] * x[i]), 1e-7);
      }
    }
  }
}

}  // namespace
}  // namespace stonestack::motion
