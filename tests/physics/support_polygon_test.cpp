#include "stonestack/physics/equilibrium.hpp"

#include <gtest/gtest.h>

namespace stonestack::physics {
namespace {

using Eigen::Vector3d;

Contact touch(double x, double y, double z = 0.0, double gap = 0.0) {
  return {kTable, 0, {x, y, z}, Vector3d::UnitZ(), gap, 0.0};
}

TEST(SupportPolygon, OfACubeIsItsFace) {
  std::vector<Contact> contacts;
  for (int step = 0; step < 5; ++step)  // collected over several steps
    for (const double x : {-0.03, 0.0, 0.03})
      for (const double y : {-0.03, 0.03}) contacts.push_back(touch(x + 1e-5 * step, y));
  const SupportPolygon polygon = support_polygon(contacts, {0.01, 0, 0.05});
  EXPECT_EQ(polygon.contacts, 6);
  EXPECT_EQ(polygon.corners_W.size(), 4u);
  EXPECT_NEAR(polygon.area, 0.0036, 1e-9);
  EXPECT_NEAR(polygon.margin, 0.02, 1e-9);
  EXPECT_LT((polygon.p_W_centroid - Vector3d(0, 0, 0)).norm(), 1e-9);
  EXPECT_LT((polygon.n_W - Vector3d::UnitZ()).norm(), 1e-12);
}

TEST(SupportPolygon, LeavesOutGapsAndReportsACentreOutside) {
  const std::vector<Contact> contacts{touch(0, 0), touch(0.04, 0), touch(0, 0.04), touch(0.4, 0.4, 0, 0.002)};
  const SupportPolygon polygon = support_polygon(contacts, {-0.01, 0.01, 0.05});
  EXPECT_EQ(polygon.contacts, 3);
  EXPECT_NEAR(polygon.area, 0.0008, 1e-12);
  EXPECT_NEAR(polygon.margin, -0.01, 1e-12);
}

TEST(SupportPolygon, OfAnEdgeHasNoAreaAndNoneOfNothing) {
  const std::vector<Contact> edge{touch(-0.02, 0), touch(0.02, 0)};
  const SupportPolygon on_edge = support_polygon(edge, {0, 0.003, 0.05});
  EXPECT_EQ(on_edge.area, 0.0);
  EXPECT_NEAR(on_edge.margin, -0.003, 1e-12);
  const SupportPolygon nothing = support_polygon({}, {0, 0, 0});
  EXPECT_EQ(nothing.contacts, 0);
  EXPECT_LT(nothing.margin, 0.0);
}

TEST(SupportPolygon, SpansSeveralPatchesOfABridge) {
  std::vector<Contact> contacts;
  for (const double side : {-1.0, 1.0})
    for (const double y : {-0.01, 0.01})
      for (const double x : {0.05, 0.06}) contacts.push_back(touch(side * x, y, 0.1));
  const SupportPolygon polygon = support_polygon(contacts, {0, 0, 0.2});
  EXPECT_NEAR(polygon.area, 0.12 * 0.02, 1e-9);
  EXPECT_NEAR(polygon.margin, 0.01, 1e-9);
  EXPECT_NEAR(polygon.p_W_centroid.z(), 0.1, 1e-12);
}

TEST(SupportPolygon, OnATiltedPlaneMeasuresTheMarginAlongGravity) {
  const double tilt = 0.5;
  const Vector3d along(std::cos(tilt), 0, std::sin(tilt)), n(-std::sin(tilt), 0, std::cos(tilt));
  std::vector<Contact> contacts;
  for (const double s : {-0.03, 0.03})
    for (const double y : {-0.03, 0.03})
      contacts.push_back({kTable, 0, s * along + Vector3d(0, y, 0), n, 0, 0});
  const SupportPolygon polygon = support_polygon(contacts, {0, 0, 0.05});
  EXPECT_NEAR(polygon.area, 0.0036, 1e-9);
  EXPECT_NEAR(polygon.margin, 0.03 * std::cos(tilt), 1e-9);
  EXPECT_LT((polygon.n_W - n).norm(), 1e-9);
}

TEST(SupportPolygon, RoundPatchIsSimplified) {
  std::vector<Contact> contacts;
  for (int i = 0; i < 60; ++i)
    contacts.push_back(touch(0.03 * std::cos(i * M_PI / 30), 0.03 * std::sin(i * M_PI / 30)));
  const SupportPolygon polygon = support_polygon(contacts, {0, 0, 0.05});
  EXPECT_LT(polygon.corners_W.size(), 35u);
  EXPECT_NEAR(polygon.area, M_PI * 0.0009, 0.02 * M_PI * 0.0009);
}

}  // namespace
}  // namespace stonestack::physics
