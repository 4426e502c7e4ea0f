#include "motion/collision.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "core/constants.hpp"
#include "hardware/cell_config.hpp"
#include "kinematics/inverse.hpp"
#include "motion/collision/segment.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/hardware/cell.hpp"
#include "stonestack/kinematics/robot_model.hpp"

namespace stonestack::motion {
namespace {

using hardware::CellLayout;

PlanningScene empty_scene() {
  PlanningScene scene;
  scene.robot = read_robot("ur10");
  scene.T_F_T = CellLayout().T_F_T;
  return scene;
}

SceneObject box_at(const std::string& name, const Eigen::Vector3d& size, const Eigen::Vector3d& p) {
  return {name, {make_box(size)}, make_pose(p)};
}

/// Thirteen boxes and balls within reach, as a stack with loose stones around it.
PlanningScene cluttered_scene() {
  PlanningScene scene = empty_scene();
  Random random = Random::stream(5, "clutter");
  for (int i = 0; i < 13; ++i) {
    const double angle = random.uniform(-kPi, kPi);
    const double radius = random.uniform(0.45, 1.0);
    const Eigen::Vector3d p(radius * std::cos(angle), radius * std::sin(angle), random.uniform(0.05, 0.6));
    SceneObject object{"object " + std::to_string(i), {}, make_pose(p, random.rotation())};
    if (i % 2 == 0)
      object.pieces = {make_sphere(random.uniform(0.04, 0.12), 1)};
    else
      object.pieces = {make_box({random.uniform(0.05, 0.2), 0.1, random.uniform(0.05, 0.3)})};
    scene.objects.push_back(object);
  }
  return scene;
}

Joints tool_down() {
  Joints q;
  q << 0, -0.5 * kPi, 0.5 * kPi, -0.5 * kPi, -0.5 * kPi, 0;
  return q;
}

Joints random_joints(Random& random) {
  Joints q;
  for (auto& angle : q) angle = random.uniform(-kPi, kPi);
  return q;
}

/// Tool straight down at a place, closing direction along x.
Joints above(const PlanningScene& scene, const Eigen::Vector3d& p_W_tip) {
  Pose T_W_T = Pose::Identity();
  T_W_T.linear() = Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX()).toRotationMatrix();
  T_W_T.translation() = p_W_tip;
  const auto solutions = inverse(scene.robot, T_W_T * scene.T_F_T.inverse(), tool_down());
  EXPECT_FALSE(solutions.empty());
  return solutions.front().q;
}

// Segments

Eigen::Vector3d random_point(Random& random, double size) {
  return size * random.uniform() * random.unit_vector();
}

/// Golden section over a convex function of one parameter.
template <class Function>
double min(const Function& f) {
  double low = 0.0, high = 1.0;
  for (int k = 0; k < 80; ++k) {
    const double a = low + 0.382 * (high - low), b = low + 0.618 * (high - low);
    (f(a) < f(b) ? high : low) = f(a) < f(b) ? b : a;
  }
  return std::min({f(0.0), f(1.0), f(0.5 * (low + high))});
}

TEST(Segment, DistancesMatchASearchAlongTheSegment) {
  Random random = Random::stream(1, "segments");
  for (int k = 0; k < 3000; ++k) {
    const Segment s{random_point(random, 1.0), random_point(random, 1.0)};
    const Segment t{random_point(random, 1.0), k % 10 == 0 ? s.b - s.a : random_point(random, 1.0)};
    const auto on = [](const Segment& x, double u) -> Eigen::Vector3d { return x.a + u * (x.b - x.a); };
    const Eigen::Vector3d high = random_point(random, 0.5).cwiseAbs();
    const auto to_box = [&](double u) {
      const Eigen::Vector3d p = on(s, u);
      return (p - p.cwiseMax(-high).cwiseMin(high)).squaredNorm();
    };
    EXPECT_NEAR(squared_distance_to_box(s, -high, high), min(to_box), 1e-12);
    const auto to_segment = [&](double u) { return squared_distance(t, on(s, u)); };
    EXPECT_NEAR(squared_distance(s, t), min(to_segment), 1e-12);
    EXPECT_NEAR(squared_distance(s, t), squared_distance(t, s), 1e-12);
  }
}

TEST(Segment, PointsAndParallels) {
  const Eigen::Vector3d o(0, 0, 0), x(1, 0, 0), y(0, 1, 0);
  EXPECT_DOUBLE_EQ(squared_distance(Segment{o, o}, Segment{y, y}), 1.0);
  EXPECT_DOUBLE_EQ(squared_distance(Segment{o, x}, Segment{y, x + y}), 1.0);
  EXPECT_DOUBLE_EQ(squared_distance(Segment{o, x}, Segment{3 * x, 4 * x}), 4.0);
  EXPECT_DOUBLE_EQ(squared_distance_to_box(Segment{-x, x}, -0.1 * (x + y), 0.1 * (x + y)), 0.0);
}

// Collision

TEST(Collision, OrdinaryPosesAreFreeOverAnEmptyTable) {
  const CollisionChecker checker(empty_scene());
  EXPECT_FALSE(checker.collides(tool_down()));
  Joints up;
  up << 0, -0.5 * kPi, 0, -0.5 * kPi, 0, 0;
  EXPECT_FALSE(checker.collides(up));
}

TEST(Collision, TableStopsTheFingersAtTheirPadding) {
  const PlanningScene scene = empty_scene();
  CollisionRules rules;
  rules.padding = 0.002;
  const CollisionChecker checker(scene, rules);
  EXPECT_FALSE(checker.collides(above(scene, {0.7, 0.1, 0.0021})));
  EXPECT_TRUE(checker.collides(above(scene, {0.7, 0.1, 0.0019})));
  rules.gripper_may_touch = {kTableObject};
  EXPECT_FALSE(CollisionChecker(scene, rules).collides(above(scene, {0.7, 0.1, -0.001})));
  const Clearance clearance = checker.clearance(above(scene, {0.7, 0.1, 0.02}));
  EXPECT_NEAR(clearance.distance, 0.02, 1e-9);
  EXPECT_EQ(clearance.first, "finger");
  EXPECT_EQ(clearance.second, "table");
}

TEST(Collision, FoldedArmMeetsItself) {
  const CollisionChecker checker(empty_scene());
  Joints folded = tool_down();
  folded[2] = 0.98 * kPi;  // forearm onto the upper arm
  folded[1] = -0.5 * kPi;
  EXPECT_TRUE(checker.collides(folded));
  Joints gripper = tool_down();
  gripper[3] = 0.5 * kPi;  // gripper turned up and back into the forearm
  gripper[4] = kPi;
  EXPECT_TRUE(checker.collides(gripper));
}

/// Everything apart from self-collision: few poses of the working range may be lost to it.
TEST(Collision, DoesNotForbidTheWorkingRange) {
  for (const auto& name : robot_names()) {
    PlanningScene scene = empty_scene();
    scene.robot = read_robot(name);
    const CollisionChecker checker(scene);
    const double reach = -scene.robot.a2 - scene.robot.a3;
    int reachable = 0, free = 0;
    for (double x = 0.5; x < 0.8; x += 0.05) {
      for (double angle = -2.0; angle <= 2.0; angle += 0.5) {
        Pose T_W_T = Pose::Identity();
        T_W_T.linear() = (Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()) *
                          Eigen::AngleAxisd(kPi, Eigen::Vector3d::UnitX()))
                             .toRotationMatrix();
        T_W_T.translation() = reach * Eigen::Vector3d(x * std::cos(angle), x * std::sin(angle), 0.1);
        const auto solutions = inverse(scene.robot, T_W_T * scene.T_F_T.inverse(), tool_down());
        if (solutions.empty()) continue;
        ++reachable;
        free += std::any_of(solutions.begin(), solutions.end(),
                            [&](const auto& s) { return !checker.collides(s.q); })
                    ? 1
                    : 0;
      }
    }
    EXPECT_GT(reachable, 20) << name;
    EXPECT_EQ(free, reachable) << name;
  }
}

TEST(Collision, HeldStoneCountsAndMayTouchItsSupport) {
  PlanningScene scene = empty_scene();
  scene.objects = {box_at("support", {0.2, 0.2, 0.1}, {0.7, 0.1, 0.05})};
  const Joints q = above(scene, {0.7, 0.1, 0.16});
  const HeldObject stone{"stone", {make_box({0.06, 0.10, 0.10})}, make_pose(Eigen::Vector3d(0, 0, 0.01))};
  CollisionRules rules;
  rules.opening = 0.06;
  EXPECT_FALSE(CollisionChecker(scene, rules).collides(q)) << "the empty gripper is 6 cm above";
  const CollisionChecker holding(scene, rules, &stone);
  EXPECT_TRUE(holding.collides(q));
  const Clearance clearance = holding.clearance(q);
  EXPECT_NEAR(clearance.distance, 0.0, 1e-9) << "tip at 0.16, stone's underside 0.06 below";
  EXPECT_EQ(clearance.first, "stone");
  EXPECT_EQ(clearance.second, "support");
  rules.held_may_touch = {0};
  EXPECT_FALSE(CollisionChecker(scene, rules, &stone).collides(q));
  rules.held_may_touch = {};
  rules.left_out = 0;
  EXPECT_FALSE(CollisionChecker(scene, rules, &stone).collides(q));
}

TEST(Collision, WithoutPaddingAnOverlapIsAHit) {
  PlanningScene scene = empty_scene();
  scene.objects = {box_at("post", {0.04, 0.12, 0.2}, {0.7, 0.1, 0.1})};
  const HeldObject stone{"stone", {make_box({0.06, 0.10, 0.10})}, make_pose(Eigen::Vector3d(0, 0, 0.01))};
  CollisionRules rules;
  rules.padding = 0.0;
  rules.opening = 0.06;
  EXPECT_TRUE(CollisionChecker(scene, rules, &stone).collides(above(scene, {0.7, 0.1, 0.24})));
  EXPECT_FALSE(CollisionChecker(scene, rules, &stone).collides(above(scene, {0.7, 0.1, 0.261})));
  // The fingers themselves: one stands where the post is.
  EXPECT_TRUE(CollisionChecker(scene, rules).collides(above(scene, {0.73, 0.1, 0.1})));
}

TEST(Collision, FingersMayTouchOnlyWhatTheyGrasp) {
  PlanningScene scene = empty_scene();
  scene.objects = {box_at("wanted", {0.06, 0.06, 0.1}, {0.7, 0.1, 0.05}),
                   box_at("other", {0.06, 0.06, 0.1}, {0.7, 0.22, 0.05})};
  CollisionRules rules;
  rules.padding = 0.002;
  rules.opening = 0.062;
  const Joints q = above(scene, {0.7, 0.1, 0.03});
  EXPECT_TRUE(CollisionChecker(scene, rules).collides(q)) << "pads 1 mm from the stone";
  rules.gripper_may_touch = {0};
  EXPECT_FALSE(CollisionChecker(scene, rules).collides(q));
  EXPECT_TRUE(CollisionChecker(scene, rules).collides(above(scene, {0.7, 0.22, 0.03})));
}

TEST(Collision, TheBaseStaysWhereItIs) {
  PlanningScene scene = empty_scene();
  const Eigen::Vector3d place(0.7, 0.1, 0.3);
  const Joints q = above(scene, place);
  scene.objects = {box_at("box", {0.2, 0.05, 0.05}, place)};
  EXPECT_TRUE(CollisionChecker(scene).collides(q));
  // The same arm moved by 2 m and turned, with table and box left where they are.
  scene.T_W_R =
      make_pose({2.0, 0.0, 0.0}, Eigen::Quaterniond(Eigen::AngleAxisd(1.0, Eigen::Vector3d::UnitZ())));
  EXPECT_FALSE(CollisionChecker(scene).collides(q));
  scene.T_W_R = make_pose(Eigen::Vector3d(0.0, 0.0, -0.35));
  EXPECT_TRUE(CollisionChecker(scene).collides(q)) << "lowered into the table";
}

TEST(Collision, RefusesPiecesThatAreNone) {
  PlanningScene scene = empty_scene();
  scene.objects = {{"bad", {Mesh{}}, Pose::Identity()}};
  EXPECT_THROW(CollisionChecker{scene}, InvalidArgument);
  scene.objects[0].pieces[0].vertices = {Eigen::Vector3d(std::nan(""), 0, 0)};
  EXPECT_THROW(CollisionChecker{scene}, InvalidArgument);
}

/// Points dense on every surface; distances between them by brute force. Coarse, slow and independent of
/// bounds, GJK and frames inside the checker.
class Reference {
 public:
  explicit Reference(const PlanningScene& scene) : scene_(scene) {
    for (const auto& object : scene.objects) {
      solids_.push_back({});
      for (const auto& piece : object.pieces) {
        const Mesh mesh = transformed(piece, object.T_W_object);
        solids_.back().push_back({mesh, face_normals(mesh)});
      }
    }
  }
  /// Distance from arm to objects; too large by at most kSpacing^2 / 8 / radius, which is below 0.1 mm.
  [[nodiscard]] double distance(const Joints& q) const {
    double best = 1e9;
    const auto T_R_link = link_poses(scene_.robot, q);
    for (const auto& c : scene_.robot.capsules) {
      if (c.link == 0) continue;
      const Pose& T = T_R_link[static_cast<std::size_t>(c.link)];
      const double length = (c.b - c.a).norm();
      const int steps = 1 + static_cast<int>(length / kSpacing);
      for (int i = 0; i <= steps; ++i)
        best = std::min(best, to_objects(T * (c.a + (c.b - c.a) * i / steps)) - c.radius);
    }
    return best;
  }
  static constexpr double kSpacing = 0.005;

 private:
  /// Signed only in so far as inside is 0 or less.
  [[nodiscard]] double to_objects(const Eigen::Vector3d& p) const {
    double best = 1e9;
    for (const auto& solid : solids_) {
      for (const auto& [piece, normals] : solid) {
        double outside = -1e9, nearest = 1e9;
        for (std::size_t f = 0; f < piece.faces.size(); ++f) {
          const auto& face = piece.faces[f];
          const auto& a = piece.vertices[static_cast<std::size_t>(face[0])];
          const auto& b = piece.vertices[static_cast<std::size_t>(face[1])];
          const auto& c = piece.vertices[static_cast<std::size_t>(face[2])];
          outside = std::max(outside, normals[f].dot(p - a));
          nearest = std::min(nearest, to_triangle(p, a, b, c, normals[f]));
        }
        best = std::min(best, outside <= 0.0 ? outside : nearest);
      }
    }
    return best;
  }
  static double to_triangle(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                            const Eigen::Vector3d& c, const Eigen::Vector3d& n) {
    const bool over = n.dot((b - a).cross(p - a)) >= 0 && n.dot((c - b).cross(p - b)) >= 0 &&
                      n.dot((a - c).cross(p - c)) >= 0;
    if (over) return std::abs(n.dot(p - a));
    return std::sqrt(std::min({squared_distance(Segment{a, b}, p), squared_distance(Segment{b, c}, p),
                               squared_distance(Segment{c, a}, p)}));
  }
  const PlanningScene& scene_;
  struct Piece {
    Mesh mesh;
    std::vector<Eigen::Vector3d> normals;
  };
  std::vector<std::vector<Piece>> solids_;
};

TEST(Collision, AgreesWithASampledReference) {
  PlanningScene scene = cluttered_scene();
  scene.gripper.boxes.clear();
  scene.table_z = -5.0;
  const Reference reference(scene);
  CollisionRules rules;
  rules.padding = 0.01;
  const CollisionChecker checker(scene, rules);
  scene.objects.clear();
  const CollisionChecker alone(scene, rules);
  Random random = Random::stream(6, "reference");
  int hits = 0, decided = 0;
  for (int k = 0; k < 150; ++k) {
    const Joints q = random_joints(random);
    if (alone.collides(q)) continue;
    const double distance = reference.distance(q);
    if (std::abs(distance - rules.padding) < 0.0003) continue;
    ++decided;
    EXPECT_EQ(checker.collides(q), distance < rules.padding) << q.transpose() << " at " << distance;
    hits += distance < rules.padding ? 1 : 0;
  }
  EXPECT_GT(hits, decided / 10);
  EXPECT_LT(hits, decided * 9 / 10);
}

/// The yes-or-no answer and the distance are computed by different methods; they must agree.
TEST(Collision, AnswerAndClearanceAgree) {
  const PlanningScene scene = cluttered_scene();
  const HeldObject stone{"stone", {make_sphere(0.05, 1)}, Pose::Identity()};
  CollisionRules rules;
  rules.padding = rules.self_padding = 0.01;
  const CollisionChecker checker(scene, rules, &stone);
  Random random = Random::stream(7, "clearance");
  int hits = 0;
  for (int k = 0; k < 20000; ++k) {
    const Joints q = random_joints(random);
    const Clearance clearance = checker.clearance(q);
    const bool near = clearance.distance < rules.padding;
    if (std::abs(clearance.distance - rules.padding) < 1e-7) continue;
    EXPECT_EQ(checker.collides(q), near)
        << clearance.first << " - " << clearance.second << " " << clearance.distance;
    hits += near ? 1 : 0;
  }
  EXPECT_GT(hits, 1000);
}

TEST(Collision, AFreeMotionIsFreeAtTenTimesTheResolution) {
  const CollisionChecker checker(cluttered_scene());
  Random random = Random::stream(8, "motions");
  int free = 0;
  for (int k = 0; k < 400; ++k) {
    const Joints a = random_joints(random);
    Joints b = a;
    for (auto& angle : b) angle += random.uniform(-0.6, 0.6);
    if (!checker.motion_is_free(a, b, 0.005)) continue;
    ++free;
    const int steps = static_cast<int>((b - a).cwiseAbs().maxCoeff() / 0.0005) + 1;
    for (int i = 0; i <= steps; ++i)
      ASSERT_FALSE(checker.collides(a + (b - a) * i / steps)) << "motion " << k << " step " << i;
  }
  EXPECT_GT(free, 20);
}

/// A certified motion is never refused by samples, and samples refuse nearly all that is not certified.
TEST(Collision, SamplesAreAQuickAnswer) {
  const CollisionChecker checker(cluttered_scene());
  Random random = Random::stream(9, "motions");
  int free = 0, missed = 0;
  for (int k = 0; k < 400; ++k) {
    const Joints a = random_joints(random);
    Joints b = a;
    for (auto& angle : b) angle += random.uniform(-0.6, 0.6);
    if (checker.collides(a) || checker.collides(b)) continue;
    if (checker.motion_is_free(a, b, 0.001)) {
      ++free;
      ASSERT_TRUE(checker.samples_are_free(a, b)) << "motion " << k;
    } else {
      missed += checker.samples_are_free(a, b) ? 1 : 0;
    }
  }
  EXPECT_GT(free, 20);
  EXPECT_LT(missed, free / 4);
  EXPECT_THROW((void)checker.samples_are_free(Joints::Zero(), Joints::Zero(), 0.0), InvalidArgument);
}

TEST(Collision, AMotionThroughAnObstacleIsNotFree) {
  PlanningScene scene = empty_scene();
  const Joints a = above(scene, {0.7, -0.3, 0.3});
  const Joints b = above(scene, {0.7, 0.3, 0.3});
  EXPECT_TRUE(CollisionChecker(scene).motion_is_free(a, b));
  scene.objects = {box_at("thin post", {0.002, 0.002, 0.5}, {0.72, 0.0, 0.25})};
  const CollisionChecker checker(scene);
  EXPECT_FALSE(checker.collides(a));
  EXPECT_FALSE(checker.collides(b));
  EXPECT_FALSE(checker.motion_is_free(a, b));
}

TEST(Collision, TheToolStaysInItsWorkspaceDuringAMotion) {
  PlanningScene scene = empty_scene();
  const Joints start = tool_down();
  const Eigen::Vector3d p = (forward(scene.robot, start) * scene.T_F_T).translation();
  const Eigen::Vector3d half(0.2, 0.2, 0.2);
  scene.robot.workspace = ToolWorkspace{{p - half, p + half}, scene.T_W_R, scene.T_F_T};
  const CollisionChecker checker(scene);
  EXPECT_FALSE(checker.collides(start));
  Joints away = start;
  away[0] += 0.6;
  EXPECT_TRUE(checker.collides(away));
  EXPECT_FALSE(checker.motion_is_free(start, away));
  Random random = Random::stream(3, "room");
  int free = 0;
  for (int i = 0; i < 300; ++i) {
    Joints a = start, b = start;
    for (int j = 0; j < 6; ++j) {
      a[j] += random.uniform(-0.3, 0.3);
      b[j] += random.uniform(-0.3, 0.3);
    }
    if (!checker.motion_is_free(a, b)) continue;
    ++free;
    for (int k = 0; k <= 50; ++k)
      EXPECT_LE(outside_workspace(scene.robot, a + (b - a) * k / 50.0), -kWorkspaceMargin);
  }
  EXPECT_GT(free, 20);
}

// What the planner lets pass, the gate before the arm lets pass, too.
TEST(Collision, ArmAndGripperStayWithinTheFenceDuringAMotion) {
  PlanningScene scene = empty_scene();
  const Joints start = tool_down();
  hardware::CellLimits limits;
  const RobotModel whole = scene.robot;
  const auto fenced = [&](const std::string& z) {
    limits.fence = {"[-0.35, 0.85]", "[-0.5, 0.5]", z};
    return hardware::limit_robot(whole, limits, scene.T_W_R, scene.T_F_T, "test");
  };
  scene.robot = fenced("[-0.1, 1.0]");
  ASSERT_LT(outside_fence(scene.robot, start), -kWorkspaceMargin);
  EXPECT_FALSE(CollisionChecker(scene).collides(start));
  scene.robot = fenced("[-0.1, 0.6]");
  EXPECT_GT(outside_fence(scene.robot, start), 0.0) << "the elbow";
  EXPECT_TRUE(CollisionChecker(scene).collides(start));
  scene.robot = fenced("[-0.1, 1.0]");
  const CollisionChecker checker(scene);
  Random random = Random::stream(4, "fence");
  int free = 0, outside = 0;
  for (int i = 0; i < 400; ++i) {
    Joints a = start, b = start;
    for (int j = 0; j < 6; ++j) {
      a[j] += random.uniform(-0.5, 0.5);
      b[j] += random.uniform(-0.5, 0.5);
    }
    if (!checker.motion_is_free(a, b)) {
      if (outside_fence(scene.robot, a) > 0.0) {
        ++outside;
        EXPECT_TRUE(checker.collides(a));
      }
      continue;
    }
    ++free;
    for (int k = 0; k <= 50; ++k)
      EXPECT_LE(outside_fence(scene.robot, a + (b - a) * k / 50.0), -kWorkspaceMargin);
  }
  EXPECT_GT(free, 20);
  EXPECT_GT(outside, 20);
}

}  // namespace
}  // namespace stonestack::motion
