#include "stonestack/search/plan_wall.hpp"

#include <gmock/gmock.h>

#include <numeric>

#include "box_scenes.hpp"
#include "geometry/convex_pieces.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "temporary_folder.hpp"

namespace stonestack::search {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::UnorderedElementsAre;

/// Six bricks, which differ a little in length.
const ShapeList& bricks() {
  static const ShapeList list = [] {
    ShapeList made;
    for (int k = 0; k < 6; ++k) made.push_back(box(concat("brick_", k), {0.12 + 0.002 * k, 0.07, 0.05}));
    return made;
  }();
  return list;
}

SearchProblem bricks_on_the_floor(int count) {
  SearchProblem problem;
  problem.shapes = &bricks();
  for (int k = 0; k < count; ++k) problem.available.push_back({StoneIndex(k), at(1.0, 0.2 * k, 0.025)});
  problem.site = {0.7, 0.28};
  return problem;
}

WallTarget courses(std::vector<int> counts) {
  WallTarget target;
  target.courses = std::move(counts);
  return target;
}

/// Pose of the k-th stone of a plan.
Eigen::Vector3d place(const WallPlan& plan, std::size_t k) {
  return plan.placements[k].placement.T_W_O.translation();
}

const WallPlan& three_bricks() {
  static const WallPlan plan = plan_wall(bricks_on_the_floor(3), courses({2, 1}), quick());
  return plan;
}

TEST(PlanWall, TwoBricksCarryTheThirdOverTheirJoint) {
  const WallPlan& plan = three_bricks();
  ASSERT_EQ(plan.placements.size(), 3U) << plan.reason;
  EXPECT_EQ(plan.reason, "");
  EXPECT_THAT(plan.placements[0].supports, ElementsAre());
  EXPECT_THAT(plan.placements[1].supports, ElementsAre());
  EXPECT_EQ(plan.placements[2].course, 1);
  EXPECT_THAT(plan.placements[2].supports, UnorderedElementsAre(0, 1));
}

TEST(PlanWall, KeepsWhatWasComparedWithEachStone) {
  for (const WallPlacement& next : three_bricks().placements) {
    const Placement& chosen = next.placement;
    EXPECT_EQ(chosen.terms.at("course"), next.course + 1);
    for (const char* term : {"joint_cover", "fill", "off_height", "off_axis", "worth", "urgency", "margin"})
      EXPECT_TRUE(chosen.terms.contains(term)) << term;
    EXPECT_GE(chosen.support.corners_W.size(), 3U);
    ASSERT_FALSE(next.alternatives.empty());
    EXPECT_LE(next.alternatives.size(), 5U);
    for (const Alternative& other : next.alternatives) {
      EXPECT_FALSE(other.stone == chosen.stone && other.T_W_O.isApprox(chosen.T_W_O));
      EXPECT_LT((other.T_W_O.translation() - chosen.T_W_O.translation()).norm(), 0.3)
          << "in W, as the chosen one";
      const auto rank = [](const auto& p) { return p.terms.at("worth") + p.terms.at("urgency"); };
      EXPECT_TRUE(other.why_not != "" || rank(other) <= rank(chosen));
    }
  }
  EXPECT_NEAR(three_bricks().placements[2].placement.terms.at("joint_cover"), 0.03, 1e-9) << "over the joint";
}

TEST(PlanWall, TheMiddleOfTheWallIsTheSite) {
  const WallPlan& plan = three_bricks();
  ASSERT_EQ(plan.placements.size(), 3U);
  const Eigen::Vector3d middle = 0.5 * (place(plan, 0) + place(plan, 1));
  EXPECT_NEAR(middle.x(), 0.7, 0.01);
  EXPECT_NEAR(middle.y(), 0.28, 0.002);
  EXPECT_NEAR(place(plan, 2).x(), 0.7, 0.03) << "over the joint";
}

TEST(PlanWall, TheWallIsTurnedAndMovedAsAsked) {
  WallTarget target = courses({2, 1});
  target.centre_W = Eigen::Vector2d(-0.3, 0.1);
  target.yaw = M_PI / 2;
  const WallPlan plan = plan_wall(bricks_on_the_floor(3), target, quick());
  ASSERT_EQ(plan.placements.size(), 3U);
  const WallPlan& straight = three_bricks();
  for (std::size_t k = 0; k < 3; ++k) {
    const Eigen::Vector3d p = place(straight, k) - Eigen::Vector3d(0.7, 0.28, 0.0);
    EXPECT_NEAR((place(plan, k) - Eigen::Vector3d(-0.3 - p.y(), 0.1 + p.x(), p.z())).norm(), 0.0, 1e-9);
  }
}

TEST(PlanWall, MetricsDescribeTheWall) {
  const WallMetrics& m = three_bricks().metrics;
  EXPECT_EQ(m.placed, 3);
  EXPECT_EQ(m.asked, 3);
  EXPECT_EQ(m.joints, 1);
  EXPECT_EQ(m.open_joints, 0);
  EXPECT_NEAR(m.flatness, 0.0, 0.03);
  EXPECT_GT(m.fill, 0.8) << "bricks leave their joints open, nothing else";
  EXPECT_LE(m.fill, 1.0);
  EXPECT_GT(m.face, 0.9);
  EXPECT_GT(m.margin, 0.02);
}

TEST(PlanWall, TheSameSeedGivesTheSameWallForAnyNumberOfThreads) {
  SearchOptions one = quick();
  one.threads = 1;
  const WallPlan again = plan_wall(bricks_on_the_floor(3), courses({2, 1}), one);
  ASSERT_EQ(again.placements.size(), 3U);
  for (std::size_t k = 0; k < 3; ++k)
    EXPECT_EQ(again.placements[k].placement.T_W_O.matrix(),
              three_bricks().placements[k].placement.T_W_O.matrix());
}

TEST(PlanWall, AStraightWallIsAsLongAsAskedAndNoJointRunsThrough) {
  WallTarget target;
  target.length = 0.3;
  target.levels = 2;
  const WallPlan plan = plan_wall(bricks_on_the_floor(6), target, quick());
  EXPECT_GE(plan.metrics.length, 0.3 - 0.07);
  EXPECT_EQ(plan.metrics.open_joints, 0);
  EXPECT_EQ(plan.placements.back().course, 1);
}

/// The problem and the plan when the first `count` stones of three_bricks() stand, moved by 3 mm along the
/// wall.
struct HalfBuilt {
  SearchProblem problem = bricks_on_the_floor(3);
  WallBegun begun;
  explicit HalfBuilt(std::size_t count) {
    begun.T_W_V = three_bricks().T_W_V;
    const auto& planned = three_bricks().placements;
    for (std::size_t k = 0; k < planned.size(); ++k) {
      if (k >= count) {
        begun.rest.push_back(planned[k]);
        continue;
      }
      const Placement& placed = planned[k].placement;
      problem.stack.stones.push_back({placed.stone, Eigen::Translation3d(0.003, 0.0, 0.0) * placed.T_W_O});
      begun.courses.push_back(planned[k].course);
      std::erase_if(problem.available, [&](const auto& loose) { return loose.stone == placed.stone; });
    }
  }
  [[nodiscard]] WallPlan plan() const { return plan_wall(problem, courses({2, 1}), quick(), {}, begun); }
};

TEST(PlanWall, GoesOnFromWhatStandsAsItWasPlanned) {
  const WallPlan plan = HalfBuilt(1).plan();
  ASSERT_EQ(plan.placements.size(), 2U) << plan.reason;
  EXPECT_EQ(plan.reason, "");
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(plan.placements[k].placement.stone, three_bricks().placements[k + 1].placement.stone);
    EXPECT_NEAR((place(plan, k) - place(three_bricks(), k + 1)).norm(), 0.0, 0.002);
    EXPECT_EQ(plan.placements[k].course, three_bricks().placements[k + 1].course);
  }
  EXPECT_THAT(plan.placements[1].supports, UnorderedElementsAre(0, 1));
  EXPECT_EQ(plan.metrics.placed, 3);
  EXPECT_EQ(plan.T_W_V.matrix(), three_bricks().T_W_V.matrix());
}

TEST(PlanWall, PlansAnewWhereTheRestOfThePlanDoesNotHold) {
  HalfBuilt half(1);
  half.begun.rest.front().placement.T_W_O = half.problem.stack.stones.front().T_W_O;  // within the first
  const WallPlan plan = half.plan();
  ASSERT_EQ(plan.placements.size(), 2U) << plan.reason;
  EXPECT_GT((place(plan, 0) - half.problem.stack.stones.front().T_W_O.translation()).norm(), 0.10);
}

/// Two stones of a wall of 2 + 1 that have a ridge below and lean outwards, and the one that is to lie over
/// their joint: under its load they rock inwards.
struct Rocking {
  static constexpr double kSlope = 0.02;  // rad, of the faces beside the ridge
  ShapeList shapes{ridged("left"), ridged("right"), box("top", {0.12, 0.07, 0.05})};
  SearchProblem problem;
  WallBegun begun{Pose::Identity(), {0, 0}, {}, true};
  SearchOptions options = quick();

  Rocking() {
    problem.shapes = &shapes;
    problem.stack.stones = {{0_stone, leaning(-0.07, -kSlope)}, {1_stone, leaning(0.07, kSlope)}};
    problem.available = {{2_stone, at(0.6, 0.0, 0.025)}};
    options.friction = 0.5;
    options.min_margin = 0.0;  // between one face and the other they bear nothing sideways
    WallPlacement top;
    top.placement.stone = 2_stone;
    top.placement.T_W_O = at(0.0, 0.0, 0.0765);
    top.course = 1;
    begun.rest = {top};
  }
  /// O is on the ridge.
  static std::shared_ptr<const ContactShape> ridged(const std::string& name) {
    Mesh corners;
    for (const double y : {-0.045, 0.045}) {
      corners.vertices.emplace_back(0.0, y, 0.0);
      for (const double x : {-0.06, 0.06})
        for (const double z : {0.06 * std::tan(kSlope), 0.05}) corners.vertices.emplace_back(x, y, z);
    }
    const Mesh mesh = geometry::convex_hull(corners);
    return make_contact_shape(mesh, mass_properties(mesh, 2600.0), name);
  }
  static Pose leaning(double x, double turn) {
    return make_pose({x, 0.0, 0.0}, Eigen::Quaterniond(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitY())));
  }
  [[nodiscard]] WallPlan plan() const { return plan_wall(problem, courses({2, 1}), options, {}, begun); }
};

TEST(PlanWall, WhereAnArmBuildsStonesMayRockUnderTheLoad) {
  Rocking wall;
  EXPECT_THAT(wall.plan().placements, testing::IsEmpty()) << "without an arm";
  wall.problem.reachable = [](StoneIndex, const Pose&, const Stack&) { return true; };
  const WallPlan plan = wall.plan();
  ASSERT_EQ(plan.placements.size(), 1U) << plan.reason;
  Stack whole = wall.problem.stack;
  whole.stones.push_back({2_stone, plan.placements.front().placement.T_W_O});
  StandOptions stand;
  stand.friction = 0.5;
  stand.seconds = 5.0;
  EXPECT_FALSE(judge_stack(wall.shapes, whole, stand).stands) << "within 1 mm and 1 deg";
  stand.max_shift = 0.006;
  stand.max_turn = 0.1;
  const StandVerdict verdict = judge_stack(wall.shapes, whole, stand);
  EXPECT_TRUE(verdict.stands) << verdict.reason;
  EXPECT_NEAR(verdict.turn, 2 * Rocking::kSlope, 0.005) << "rad: from one face onto the other";
}

TEST(PlanWall, AWallThatIsWholeAsksForNothing) {
  const WallPlan plan = HalfBuilt(3).plan();
  EXPECT_TRUE(plan.placements.empty());
  EXPECT_EQ(plan.reason, "");
  EXPECT_EQ(plan.metrics.placed, 3);
}

TEST(PlanWall, AsksTheArmForEachStoneAmongThoseThatStand) {
  SearchProblem problem = bricks_on_the_floor(4);
  std::size_t max_below = 0;
  double furthest = 0.0;
  problem.reachable = [&](StoneIndex stone, const Pose& T_W_O, const Stack& below) {
    max_below = std::max(max_below, below.stones.size());
    furthest = std::max(furthest, (T_W_O.translation().head<2>() - problem.site).norm());
    for (const PlacedStone& lower : below.stones)
      furthest = std::max(furthest, (lower.T_W_O.translation().head<2>() - problem.site).norm());
    return stone != 1_stone;
  };
  const WallPlan plan = plan_wall(problem, courses({2, 1}), quick());
  ASSERT_EQ(plan.placements.size(), 3U) << plan.reason;
  for (const WallPlacement& next : plan.placements) EXPECT_NE(next.placement.stone, 1_stone);
  EXPECT_EQ(max_below, 2U);
  EXPECT_LT(furthest, 0.25) << "poses are given in W, near the site";
  EXPECT_GT(plan.unreachable, 0);
  problem.reachable = [](StoneIndex, const Pose&, const Stack&) { return false; };
  const WallPlan none = plan_wall(problem, courses({2, 1}), quick());
  EXPECT_TRUE(none.placements.empty());
  EXPECT_THAT(none.reason, HasSubstr("the arm brings none"));
}

TEST(PlanWall, NeighboursKeepTheGapThatIsAskedFor) {
  WallTarget target = courses({2, 2});
  target.joint_gap = 0.02;
  const WallPlan plan = plan_wall(bricks_on_the_floor(4), target, quick());
  ASSERT_EQ(plan.placements.size(), 4U) << plan.reason;
  for (const std::size_t k : {std::size_t{0}, std::size_t{2}}) {
    Stack pair;
    for (const std::size_t i : {k, k + 1})
      pair.stones.push_back({plan.placements[i].placement.stone, plan.placements[i].placement.T_W_O});
    const auto contacts = geometric_contacts(bricks(), pair, 0.016);
    for (const Contact& contact : contacts) EXPECT_EQ(contact.below, kTable) << "nearer than 16 mm";
  }
}

TEST(PlanWall, RefusesWhatCannotBe) {
  const SearchProblem problem = bricks_on_the_floor(3);
  const auto refusal = [&](const WallTarget& target) -> std::string {
    try {
      (void)plan_wall(problem, target, quick());
    } catch (const InvalidArgument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(refusal(courses({3, 2})), HasSubstr("asks for 5 stones, and 3 are there"));
  EXPECT_THAT(refusal(courses({1, 2})), HasSubstr("more stones (2) than the one below"));
  EXPECT_THAT(refusal(WallTarget{}), HasSubstr("a wall needs stones a course"));
  SearchProblem standing = base_stands();
  try {
    (void)plan_wall(standing, courses({1, 1}), quick());
    ADD_FAILURE() << "planned among stones of unknown courses";
  } catch (const InvalidArgument& error) {
    EXPECT_THAT(error.what(), HasSubstr("on the empty table, and 1 stones stand"));
  }
  EXPECT_THROW((void)plan_wall(standing, courses({1, 1}), quick(), {}, WallBegun{}), InvalidArgument);
  SearchOptions firm = quick();
  firm.objective = "firm";
  EXPECT_THROW((void)plan_wall(problem, courses({2, 1}), firm), InvalidArgument) << "only towers are shaken";
}

TEST(WallTargetText, CountsOrLengthAndCourses) {
  EXPECT_THAT(read_wall_target("4+3+2+1").courses, ElementsAre(4, 3, 2, 1));
  const WallTarget straight = read_wall_target("0.8x3");
  EXPECT_EQ(straight.length, 0.8);
  EXPECT_EQ(straight.levels, 3);
  EXPECT_TRUE(straight.courses.empty());
  for (const char* wrong :
       {"", "0", "2+", "+1", "2+1.5", "-1", "0x3", "0.8x", "0.8x0", "axb", "1e9", "2+1+x"})
    EXPECT_THROW((void)read_wall_target(wrong), InvalidArgument) << wrong;
}

TEST(WallTargetFile, IsReadAndFaultsAreNamed) {
  const std::string path = test::temporary_folder() + "wall.yaml";
  write_file(
      path, "schema: stonestack.target/1\nwall: {courses: [3, 2]}\ncentre: {x: 0.6, y: -0.2}\nyaw_deg: 90\n");
  const WallTarget target = read_wall_target(path);
  EXPECT_THAT(target.courses, ElementsAre(3, 2));
  ASSERT_TRUE(target.centre_W);
  EXPECT_EQ(*target.centre_W, Eigen::Vector2d(0.6, -0.2));
  EXPECT_NEAR(target.yaw, M_PI / 2, 1e-12);
  const auto fault = [&](const std::string& text) -> std::string {
    write_file(path, text);
    try {
      (void)read_wall_target(path);
    } catch (const FileError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(fault("schema: stonestack.target/2\nwall: {length: 1, levels: 2}\n"), HasSubstr("target/1"));
  EXPECT_THAT(fault("schema: stonestack.target/1\nwall: {courses: [3, none]}\n"), HasSubstr("courses"));
  EXPECT_THAT(fault("schema: stonestack.target/1\nwall: {length: 1, levels: 2, high: 3}\n"),
              HasSubstr("high"));
  EXPECT_THAT(fault("schema: stonestack.target/1\nwall: {length: -1, levels: 2}\n"), HasSubstr("length"));
  EXPECT_THAT(fault("schema: stonestack.target/1\nwall: {length: 1, levels: 2.5}\n"),
              HasSubstr("whole number"));
}

}  // namespace
}  // namespace stonestack::search
