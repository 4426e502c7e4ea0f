// Bridges, corbels and what else a target asks that is no wall.
#include <gmock/gmock.h>

#include "box_scenes.hpp"
#include "search/wall/span_search.hpp"
#include "search/wall/span_state.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/search/plan_wall.hpp"
#include "temporary_folder.hpp"

namespace stonestack::search {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::UnorderedElementsAre;

constexpr double kLength = 0.12;  // m of a brick

/// Bricks of 120 x 70 x 50 mm.
const ShapeList& equal_bricks() {
  static const ShapeList list = [] {
    ShapeList made;
    for (int k = 0; k < 6; ++k) made.push_back(box(concat("brick_", k), {kLength, 0.07, 0.05}));
    return made;
  }();
  return list;
}

SearchProblem equal_bricks_on_the_floor(int count) {
  SearchProblem problem;
  problem.shapes = &equal_bricks();
  for (int k = 0; k < count; ++k) problem.available.push_back({StoneIndex(k), at(1.0, 0.2 * k, 0.025)});
  return problem;
}

SearchOptions with_friction() {
  SearchOptions options = quick();
  options.friction = 0.4;
  return options;
}

WallTarget target_of(SpanTask task) {
  WallTarget target;
  target.task = std::move(task);
  return target;
}

/// Two blocks 100 mm high with a gap between them.
SpanTask between_blocks(double gap) {
  return {{{-0.5 * gap - 0.2, -0.5 * gap, 0.1, 0.2}, {0.5 * gap, 0.5 * gap + 0.2, 0.1, 0.2}},
          {{-0.5 * gap, 0.5 * gap, 0.1}},
          false,
          std::nullopt};
}

/// A block that ends at x = 0, and how far stones are to reach beyond it.
SpanTask beyond_a_block(double reach) {
  return {{{-0.25, 0.0, 0.1, 0.2}}, {{0.0, reach, 0.1}}, false, std::nullopt};
}

/// From where to where along x the corners of a brick lie.
std::pair<double, double> reach_of(const Placement& placement) {
  double from = 1e9, to = -1e9;
  for (const Eigen::Vector3d& p : at(equal_bricks(), placement.stone)->scan.vertices) {
    const double x = (placement.T_W_O * p).x();
    from = std::min(from, x);
    to = std::max(to, x);
  }
  return {from, to};
}

/// Does all of it stand in simulation, with the blocks?
bool stands(const SpanTask& task, const WallPlan& plan) {
  ShapeList shapes = equal_bricks();
  Stack all;
  const TaskSupports supports = make_supports(task);
  for (std::size_t k = 0; k < supports.shapes.size(); ++k) {
    all.stones.push_back({StoneIndex(static_cast<int>(shapes.size())), plan.T_W_V * supports.T_V_O[k]});
    shapes.push_back(supports.shapes[k]);
  }
  for (const WallPlacement& next : plan.placements)
    all.stones.push_back({next.placement.stone, next.placement.T_W_O});
  StandOptions options;
  options.friction = 0.4;
  options.seconds = 3.0;
  return judge_stack(shapes, all, options).stands;
}

TEST(PlanTask, ABridgeIsTwoPiersAndAStoneOverTheGap) {
  const WallTarget target = read_wall_target("bridge:0.06");
  const WallPlan plan = plan_wall(equal_bricks_on_the_floor(4), target, with_friction());
  ASSERT_EQ(plan.placements.size(), 3U) << plan.reason;
  EXPECT_EQ(plan.reason, "");
  for (const std::size_t pier : {std::size_t{0}, std::size_t{1}}) {
    const auto [from, to] = reach_of(plan.placements[pier].placement);
    EXPECT_TRUE(to < -0.03 || from > 0.03) << from << " to " << to << " stands in the gap";
    EXPECT_THAT(plan.placements[pier].supports, IsEmpty());
    EXPECT_EQ(plan.placements[pier].course, 0);
  }
  const auto [from, to] = reach_of(plan.placements[2].placement);
  EXPECT_LT(from, -0.03);
  EXPECT_GT(to, 0.03);
  EXPECT_THAT(plan.placements[2].supports, UnorderedElementsAre(0, 1));
  EXPECT_EQ(plan.placements[2].course, 1);
  EXPECT_EQ(plan.metrics.placed, 3);
  EXPECT_NEAR(plan.metrics.spanned, 0.06, 1e-12);
  EXPECT_NEAR(plan.metrics.to_span, 0.06, 1e-12);
  EXPECT_GT(plan.metrics.margin, 0.02);
  for (const WallPlacement& next : plan.placements) {
    EXPECT_FALSE(next.alternatives.empty()) << "what was compared with it";
    EXPECT_LE(next.alternatives.size(), 5U);
    EXPECT_TRUE(next.placement.terms.contains("worth"));
  }
}

TEST(PlanTask, AGapThatIsWiderThanAStoneIsSpannedByStonesThatReachOut) {
  const SpanTask task = between_blocks(0.16);
  const WallPlan plan = plan_wall(equal_bricks_on_the_floor(6), target_of(task), with_friction());
  EXPECT_EQ(plan.reason, "");
  EXPECT_GE(plan.placements.size(), 2U);
  EXPECT_TRUE(stands(task, plan));
  EXPECT_NEAR(plan.metrics.spanned, 0.16, 1e-12);
  for (const WallPlacement& next : plan.placements)
    EXPECT_GT(next.placement.T_W_O.translation().z(), 0.12) << "on the blocks, not between them";
}

TEST(PlanTask, AStoneThatReachesTooFarIsWeighedDown) {
  const SpanTask task = beyond_a_block(0.07);  // more than half a brick
  const WallPlan plan = plan_wall(equal_bricks_on_the_floor(4), target_of(task), with_friction());
  EXPECT_EQ(plan.reason, "");
  ASSERT_GE(plan.placements.size(), 2U);
  double furthest = 0.0;
  for (const WallPlacement& next : plan.placements)
    furthest = std::max(furthest, reach_of(next.placement).second);
  EXPECT_GE(furthest, 0.07);
  EXPECT_TRUE(stands(task, plan));
}

TEST(PlanTask, OneStoneCannotReachFurtherThanHalfItsLength) {
  const WallPlan plan =
      plan_wall(equal_bricks_on_the_floor(1), target_of(beyond_a_block(0.07)), with_friction());
  EXPECT_NE(plan.reason, "");
  EXPECT_LT(plan.metrics.spanned, 0.07);
}

TEST(PlanTask, AStoneIsCarriedOverTheGap) {
  SpanTask task = between_blocks(0.06);
  task.carry = 0.0;
  const WallPlan plan = plan_wall(equal_bricks_on_the_floor(3), target_of(task), with_friction());
  ASSERT_EQ(plan.placements.size(), 2U) << plan.reason;
  EXPECT_EQ(plan.reason, "");
  EXPECT_NEAR(plan.placements[1].placement.T_W_O.translation().x(), 0.0, 0.03);
  EXPECT_THAT(plan.placements[0].supports, IsEmpty()) << "blocks are not counted among the stones";
  EXPECT_THAT(plan.placements[1].supports, ElementsAre(0));
}

TEST(PlanTask, TheSameSeedGivesTheSameForAnyNumberOfThreads) {
  SearchOptions one = with_friction();
  one.threads = 1;
  const WallTarget target = read_wall_target("bridge:0.06");
  const WallPlan p = plan_wall(equal_bricks_on_the_floor(3), target, with_friction());
  const WallPlan q = plan_wall(equal_bricks_on_the_floor(3), target, one);
  ASSERT_EQ(p.placements.size(), q.placements.size());
  for (std::size_t k = 0; k < p.placements.size(); ++k)
    EXPECT_EQ(p.placements[k].placement.T_W_O.matrix(), q.placements[k].placement.T_W_O.matrix());
}

TEST(PlanTask, GoesOnFromWhatStandsAsItWasPlanned) {
  const WallTarget target = read_wall_target("bridge:0.06");
  const WallPlan whole = plan_wall(equal_bricks_on_the_floor(3), target, with_friction());
  ASSERT_EQ(whole.placements.size(), 3U);
  SearchProblem problem = equal_bricks_on_the_floor(3);
  WallBegun begun{whole.T_W_V, {0, 0}, {whole.placements[2]}, true};
  for (const std::size_t k : {std::size_t{0}, std::size_t{1}}) {
    const Placement& placed = whole.placements[k].placement;
    problem.stack.stones.push_back({placed.stone, Eigen::Translation3d(0.002, 0.0, 0.0) * placed.T_W_O});
    std::erase_if(problem.available, [&](const auto& loose) { return loose.stone == placed.stone; });
  }
  const WallPlan rest = plan_wall(problem, target, with_friction(), {}, begun);
  ASSERT_EQ(rest.placements.size(), 1U) << rest.reason;
  EXPECT_EQ(rest.reason, "");
  EXPECT_EQ(rest.placements[0].placement.stone, whole.placements[2].placement.stone);
  EXPECT_EQ(rest.metrics.placed, 3);
  const WallMetrics piers = measure_wall(problem, target, begun, with_friction());
  EXPECT_EQ(piers.placed, 2);
  EXPECT_LT(piers.spanned, 0.06);
}

TEST(PlanTask, ABridgeWithAStoneInTheGapIsNotDone) {
  const WallTarget target = read_wall_target("bridge:0.06");
  SearchProblem problem = equal_bricks_on_the_floor(4);
  const auto stand = [&](StoneIndex stone, const Pose& T_W_O) {
    problem.stack.stones.push_back({stone, T_W_O});
    std::erase_if(problem.available, [&](const auto& loose) { return loose.stone == stone; });
  };
  stand(0_stone, at(-0.095, 0.0, 0.025));
  stand(1_stone, at(0.095, 0.0, 0.025));
  stand(2_stone, at(0.0, 0.0, 0.075));
  WallBegun begun{Pose::Identity(), {0, 0, 1}, {}, true};
  EXPECT_EQ(plan_wall(problem, target, with_friction(), {}, begun).reason, "");
  EXPECT_NEAR(measure_wall(problem, target, begun, with_friction()).spanned, 0.06, 1e-12);
  Pose across = at(0.0, 0.0, 0.025);
  across.linear() = Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  stand(3_stone, across * Eigen::Translation3d(0.12, 0.0, 0.0));
  begun.courses = {0, 0, 1, 0};
  EXPECT_NE(plan_wall(problem, target, with_friction(), {}, begun).reason, "");
  EXPECT_EQ(measure_wall(problem, target, begun, with_friction()).spanned, 0.0);
}

TEST(PlanTask, BlocksThatEndWhereASpanBeginsAreNotInIt) {
  SearchProblem problem = equal_bricks_on_the_floor(3);
  for (const double x : {0.0, 0.1, 0.7}) {  // however the place rounds
    problem.site = {x, 0.28};
    const WallPlan plan = plan_wall(problem, target_of(between_blocks(0.1)), with_friction());
    EXPECT_EQ(plan.reason, "") << x;
    EXPECT_NEAR(plan.metrics.spanned, 0.1, 1e-12) << x;
  }
}

TEST(PlanTask, TheArmIsAskedAndKnowsNothingOfBlocks) {
  SearchProblem problem = equal_bricks_on_the_floor(4);
  int asked = 0;
  problem.reachable = [&](StoneIndex stone, const Pose&, const Stack&) {
    ++asked;
    return stone != 0_stone;
  };
  const WallPlan plan = plan_wall(problem, read_wall_target("bridge:0.06"), with_friction());
  ASSERT_EQ(plan.placements.size(), 3U) << plan.reason;
  EXPECT_GT(asked, 0);
  for (const WallPlacement& next : plan.placements) EXPECT_NE(next.placement.stone, 0_stone);
  EXPECT_THROW((void)plan_wall(problem, target_of(between_blocks(0.06)), with_friction()), InvalidArgument);
}

TEST(PlanTask, RefusesWhatCannotBe) {
  const auto refusal = [&](SpanTask task) -> std::string {
    try {
      (void)plan_wall(equal_bricks_on_the_floor(2), target_of(std::move(task)), with_friction());
    } catch (const InvalidArgument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(refusal({}), HasSubstr("at least one span"));
  EXPECT_THAT(refusal({{}, {{0.1, 0.0, 0.03}}, true, std::nullopt}), HasSubstr("from 0.1 to 0 m"));
  EXPECT_THAT(refusal({{{-0.1, 0.05, 0.1, 0.2}}, {{0.0, 0.1, 0.1}}, false, std::nullopt}),
              HasSubstr("stands in the span"));
  EXPECT_THAT(refusal({{{-0.1, 0.0, -0.1, 0.2}}, {{0.0, 0.1, 0.1}}, false, std::nullopt}),
              HasSubstr("support"));
}

/// A stone over the axis that stands on one side.
AxisCrossing over(double from, double to, double ground_from, double ground_to) {
  return {from, to, 0.15, ground_from, ground_to};
}

TEST(OpenSpan, AStoneThatHangsOverTheGapFromOneSideDoesNotCloseIt) {
  const SpanTask task = between_blocks(0.1);
  const Span& span = task.spans.front();
  EXPECT_TRUE(open_span(task, span, {over(-0.08, 0.08, -0.2, 0.2)}, 0.1).closed);
  EXPECT_FALSE(open_span(task, span, {over(-0.08, 0.08, -0.2, -0.05)}, 0.1).closed);
  EXPECT_TRUE(open_span(task, span, {over(-0.1, 0.02, -0.2, -0.05), over(0.01, 0.1, 0.05, 0.2)}, 0.1).closed)
      << "two that meet";
  const OpenSpan open =
      open_span(task, span, {over(-0.1, -0.01, -0.2, -0.05), over(0.01, 0.1, 0.05, 0.2)}, 0.1);
  EXPECT_FALSE(open.closed);
  EXPECT_NEAR(open.length(), 0.02, 1e-12);
  EXPECT_EQ(open.left.stone, 0);
  EXPECT_EQ(open.right.stone, 1);
}

TEST(OpenSpan, NothingIsWantedWhereNothingCanStand) {
  const SpanTask task = beyond_a_block(0.07);
  const OpenSpan open = open_span(task, task.spans.front(), {over(-0.1, 0.03, -0.2, 0.0)}, 0.1);
  EXPECT_TRUE(open.left.wanted);
  EXPECT_FALSE(open.right.wanted);
  EXPECT_NEAR(open.length(), 0.04, 1e-12);
  EXPECT_TRUE(open_span(task, task.spans.front(), {over(-0.1, 0.07, -0.2, 0.0)}, 0.1).closed);
}

TEST(TaskTargetFile, IsReadAndFaultsAreNamed) {
  const std::string path = test::temporary_folder() + "task.yaml";
  const std::string head = "schema: stonestack.target/1\n";
  write_file(path, head +
                       "spans: [{from: -0.05, to: 0.05, clear: 0.1}]\n"
                       "supports: [{from: -0.25, to: -0.05, height: 0.1}]\non_table: false\ncarry: 0.01\n");
  const WallTarget target = read_wall_target(path);
  ASSERT_TRUE(target.task);
  EXPECT_EQ(target.task->spans.front().clear, 0.1);
  EXPECT_EQ(target.task->supports.front().to, -0.05);
  EXPECT_FALSE(target.task->on_table);
  EXPECT_EQ(target.task->carry, 0.01);
  const auto fault = [&](const std::string& text) -> std::string {
    write_file(path, head + text);
    try {
      (void)read_wall_target(path);
    } catch (const FileError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(fault("spans: [{from: 0.1, to: 0}]\n"), HasSubstr("spans[0]"));
  EXPECT_THAT(fault("spans: []\n"), HasSubstr("spans"));
  EXPECT_THAT(fault("spans: [{from: 0, to: 0.1, wide: 3}]\n"), HasSubstr("wide"));
  EXPECT_THAT(fault("spans: [{from: 0, to: 0.1}]\nsupports: [{from: 0.2, to: 0.1, height: 0.1}]\n"),
              HasSubstr("supports[0]"));
  EXPECT_THAT(fault("spans: [{from: 0, to: 0.1}]\non_table: 3\n"), HasSubstr("on_table"));
  EXPECT_THAT(fault("spans: [{from: 0, to: 0.1}]\nwall: {courses: [2, 1]}\n"), HasSubstr("wall"));
  for (const char* wrong : {"bridge:", "bridge:0", "bridge:-1", "bridge:nan", "bridge:1e9", "bridge:a"})
    EXPECT_THROW((void)read_wall_target(wrong), InvalidArgument) << wrong;
}

}  // namespace
}  // namespace stonestack::search
