#include "stonestack/detection/detect_stones.hpp"

#include "test_scene.hpp"

namespace stonestack::detection {
namespace {

using test::look_at;
using test::make_camera_pose;

TEST(TableFrame, HasItsOriginBelowTheCameraAndXAlongTheImage) {
  const Pose T_W_C = make_camera_pose(0.4, 1.1);
  const auto table_C = find_table(look_at({}, T_W_C));
  ASSERT_TRUE(table_C);
  const Pose T_V_C = camera_over(*table_C);  // V: the frame that is made of the table
  EXPECT_NEAR(T_V_C.translation().x(), 0.0, 1e-9);
  EXPECT_NEAR(T_V_C.translation().y(), 0.0, 1e-9);
  EXPECT_NEAR(T_V_C.translation().z(), T_W_C.translation().z(), 1e-4);
  EXPECT_NEAR((T_V_C.linear() * Eigen::Vector3d::UnitX()).y(), 0.0, 1e-9) << "image x has no part along y";
  EXPECT_GT((T_V_C.linear() * Eigen::Vector3d::UnitX()).x(), 0.0);
  // W and V differ by a turn about the vertical and a shift along the table alone.
  const Pose T_V_W = T_V_C * T_W_C.inverse();
  EXPECT_NEAR(T_V_W.linear()(2, 2), 1.0, 1e-6);
  EXPECT_NEAR(T_V_W.translation().z(), 0.0, 2e-4);
}

TEST(TableFrame, ServesACameraThatLiesOnItsSide) {
  const Plane table_C{Eigen::Vector3d::UnitX(), -0.5};
  const Pose T_V_C = camera_over(table_C);
  EXPECT_TRUE(is_valid(T_V_C));
  EXPECT_LT((T_V_C * Eigen::Vector3d(-0.5, 0.0, 0.0)).norm(), 1e-12) << "the point below the camera";
}

TEST(TableFrame, ShowsWhereTheBareTableIsSeen) {
  Stone box;
  box.scan = box.mesh = make_box({0.2, 0.2, 0.1});
  const Pose T_W_C = make_camera_pose(0.0, 0.0);
  const DepthImage image = look_at({{&box, make_pose(Eigen::Vector3d(0.1, 0.1, 0.05))}}, T_W_C);
  const auto table_C = find_table(image);
  ASSERT_TRUE(table_C);
  const TableView view = view_of_table(image, *table_C, T_W_C);
  const auto sees = [&](double x, double y) {
    return std::any_of(view.p_W.begin(), view.p_W.end(), [&](const Eigen::Vector2d& p) {
      return (p - Eigen::Vector2d(x, y)).cwiseAbs().maxCoeff() <= 0.5 * view.cell;
    });
  };
  EXPECT_TRUE(sees(-0.11, -0.11));
  EXPECT_FALSE(sees(0.11, 0.11)) << "below the box";
  EXPECT_FALSE(sees(0.9, 0.0)) << "out of view";
  EXPECT_LT(view.p_W_middle.norm(), 0.03);
}

TEST(TableFrame, ShowsTheSurfaceAboveTheTable) {
  Stone box;
  box.scan = box.mesh = make_box({0.2, 0.2, 0.1});
  const Pose T_W_C = make_camera_pose(0.0, 0.0);
  const DepthImage image = look_at({{&box, make_pose(Eigen::Vector3d(0.1, 0.1, 0.05))}}, T_W_C);
  const auto table_C = find_table(image);
  ASSERT_TRUE(table_C);
  const TableView view = view_of_table(image, *table_C, T_W_C);
  EXPECT_GT(view.above_W.size(), 1200U) << "the top alone has 1600 squares of 5 mm";
  EXPECT_LT(view.above_W.size(), 4000U);
  for (const Eigen::Vector3d& p : view.above_W) {
    EXPECT_GT(p.x(), -0.005);
    EXPECT_LT(p.x(), 0.205);
    EXPECT_GT(p.z(), 0.009);
    EXPECT_LT(p.z(), 0.105);
  }
}

}  // namespace
}  // namespace stonestack::detection
