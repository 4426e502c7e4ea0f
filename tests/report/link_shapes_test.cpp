#include "report/link_shapes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>

namespace stonestack::report {
namespace {

double distance_to(const LinkCapsule& c, const Eigen::Vector3d& p) {
  const Eigen::Vector3d along = c.b - c.a;
  const double at = std::clamp(along.dot(p - c.a) / std::max(along.squaredNorm(), 1e-12), 0.0, 1.0);
  return (c.a + at * along - p).norm();
}

TEST(LinkShapes, EveryLinkOfEveryArmHasAShapeCloseToItsCapsules) {
  for (const std::string& name : robot_names()) {
    const RobotModel robot = read_robot(name);
    std::map<int, int> shapes;
    for (const LinkShape& shape : link_shapes(robot)) {
      ++shapes[shape.link];
      EXPECT_NEAR(shape.n_axis.norm(), 1.0, 1e-9);
      for (const Eigen::Vector3d& p : mesh_of(shape).vertices) {
        ASSERT_TRUE(p.allFinite());
        double outside = 1.0;
        for (const LinkCapsule& c : robot.capsules)
          if (c.link == shape.link) outside = std::min(outside, distance_to(c, p) - c.radius);
        // A housing goes on to the next link, a flat end has edges outside the round one of a capsule.
        EXPECT_LT(outside, 0.035) << name << ", link " << shape.link;
      }
    }
    EXPECT_EQ(shapes.size(), 7U) << name;
  }
}

TEST(LinkShapes, LinksMeetAtTheirJoints) {
  const RobotModel robot = read_robot("ur10");
  Joints q;
  q << 0.3, -1.2, 1.4, -1.8, -1.5, 0.7;
  const auto T_R_link = link_poses(robot, q);
  std::map<int, std::vector<Eigen::Vector3d>> points;
  for (const LinkShape& shape : link_shapes(robot))
    for (const Eigen::Vector3d& p : mesh_of(shape).vertices)
      points[shape.link].push_back(T_R_link[static_cast<std::size_t>(shape.link)] * p);
  for (int link = 0; link < 6; ++link) {
    double nearest = 1.0;
    for (const Eigen::Vector3d& a : points[link])
      for (const Eigen::Vector3d& b : points[link + 1]) nearest = std::min(nearest, (a - b).norm());
    EXPECT_LT(nearest, 0.02) << "links " << link << " and " << link + 1;
  }
}

TEST(LinkShapes, JointsHaveLidsThatTheGripperHasNot) {
  std::map<int, int> lids;
  for (const LinkShape& shape : link_shapes(read_robot("ur10"))) lids[shape.link] += shape.lid ? 1 : 0;
  EXPECT_EQ(lids[0], 0);
  EXPECT_EQ(lids[1], 1);
  EXPECT_EQ(lids[2], 2);
  EXPECT_EQ(lids[3], 2);
  EXPECT_EQ(lids[4], 1);
  EXPECT_EQ(lids[5], 1);
  EXPECT_EQ(lids[6], 0);
}

TEST(LinkShapes, ACapsuleAlongNoJointIsDrawnAsItIs) {
  RobotModel robot = read_robot("ur10");
  LinkCapsule skew = robot.capsules.front();
  skew.link = 3;
  skew.a << 0.1, 0.2, 0.3;
  skew.b << 0.2, 0.3, 0.3;
  skew.radius = 0.04;
  robot.capsules = {skew};
  const auto shapes = link_shapes(robot);
  ASSERT_EQ(shapes.size(), 1U);
  double furthest = 0.0;
  for (const Eigen::Vector3d& p : mesh_of(shapes.front()).vertices) {
    EXPECT_NEAR(distance_to(skew, p), 0.04, 1e-9);
    furthest = std::max(furthest, p.x());
  }
  EXPECT_GT(furthest, 0.2);
}

}  // namespace
}  // namespace stonestack::report
