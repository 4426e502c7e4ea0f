#include "search/pose_cost.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace stonestack::search {
namespace {

ContactPose example() {
  ContactPose pose;
  pose.support.area = 0.004;
  pose.support.n_W = Eigen::Vector3d(0.0, std::sin(0.2), std::cos(0.2));
  pose.kinetic_energy = 0.0001;
  pose.p_W_com = {0.03, 0.0, 0.14};
  pose.p_W_previous_com = {0.0, 0.0, 0.10};
  return pose;
}

TEST(PoseCost, NormalisedTermsAreThoseOfEquation2) {
  const PoseCost cost = pose_cost(example(), {});
  EXPECT_NEAR(cost.terms.at("area"), 0.179 * 0.5, 1e-12);
  EXPECT_NEAR(cost.terms.at("kinetic_energy"), 0.472 * 0.5, 1e-12);
  EXPECT_NEAR(cost.terms.at("distance"), 0.094 * 0.5, 1e-12);
  EXPECT_NEAR(cost.terms.at("normal"), 0.255 * (1.0 - std::cos(0.2)), 1e-12);
  double sum = 0.0;
  for (const auto& [name, value] : cost.terms) sum += value;
  EXPECT_DOUBLE_EQ(cost.total, sum);
}

TEST(PoseCost, LiteralFormKeepsUnitsAndSign) {
  SearchOptions options;
  options.si_cost = true;
  const PoseCost cost = pose_cost(example(), options);
  EXPECT_NEAR(cost.terms.at("area"), 0.179 / 0.004, 1e-9);
  EXPECT_NEAR(cost.terms.at("kinetic_energy"), 0.472e-4, 1e-12);
  EXPECT_NEAR(cost.terms.at("distance"), 0.094 * 0.05, 1e-12);
  EXPECT_NEAR(cost.terms.at("normal"), 0.255 * std::cos(0.2), 1e-12);
}

TEST(PoseCost, WeightsScaleTheirTermsAlone) {
  const PoseCost plain = pose_cost(example(), {});
  SearchOptions options;
  options.w1 = 2 * options.w1;
  options.w2 = 3 * options.w2;
  options.w3 = 0.0;
  options.w4 = 5 * options.w4;
  const PoseCost weighted = pose_cost(example(), options);
  EXPECT_NEAR(weighted.terms.at("area"), 2 * plain.terms.at("area"), 1e-12);
  EXPECT_NEAR(weighted.terms.at("kinetic_energy"), 3 * plain.terms.at("kinetic_energy"), 1e-12);
  EXPECT_EQ(weighted.terms.at("distance"), 0.0);
  EXPECT_NEAR(weighted.terms.at("normal"), 5 * plain.terms.at("normal"), 1e-12);
}

TEST(PoseCost, ShearCostsMoreThanAlignmentUnlessLiteral) {
  ContactPose aligned = example(), sheared = example();
  aligned.support.n_W = Eigen::Vector3d::UnitZ();
  sheared.support.n_W = Eigen::Vector3d(std::sin(0.6), 0.0, std::cos(0.6));
  EXPECT_LT(pose_cost(aligned, {}).total, pose_cost(sheared, {}).total);
  SearchOptions literal;
  literal.si_cost = true;
  EXPECT_GT(pose_cost(aligned, literal).total, pose_cost(sheared, literal).total);
}

TEST(PoseCost, NoAreaIsDearButFinite) {
  ContactPose pose = example();
  pose.support.area = 0.0;
  const double total = pose_cost(pose, {}).total;
  EXPECT_TRUE(std::isfinite(total));
  EXPECT_GT(total, 1e3);
}

}  // namespace
}  // namespace stonestack::search
