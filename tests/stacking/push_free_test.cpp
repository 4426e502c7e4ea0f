#include "stacking/push_free.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "motion/timing.hpp"
#include "stacking/heard.hpp"
#include "stacking/journal.hpp"
#include "stacking/learn.hpp"
#include "stacking/mortal_devices.hpp"
#include "stacking/resume_point.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/kinematics/robot_model.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/build_tower.hpp"
#include "temporary_folder.hpp"

/// Pushing stones that no finger gets beside.
namespace stonestack::stacking {
namespace {

using namespace simulation;  // the cell that the loop works in here

constexpr double kGap = 0.002;  // m, between stone and box

/// A stone in the field that could be held but for a box beside it.
struct Blocked {
  Catalogue catalogue = read_catalogue(data_path("stones"));
  RobotModel robot = read_robot("ur10");
  CellLayout layout;
  PlacedStone stone;
  bool found = false;

  Blocked() {
    // One that serves is tried first: the search takes half a minute of processor time.
    if (const auto rests = rest_poses(catalogue[0_stone]); rests.size() > 2)
      found = try_box(0_stone, rests[2], 0.0);
    for (const StoneIndex index : {1_stone, 2_stone, 0_stone, 3_stone, 4_stone, 5_stone}) {
      if (found) break;
      for (const RestPose& rest : rest_poses(catalogue[index]))
        for (int k = 0; k < 16 && !found; ++k) found = try_box(index, rest, k * M_PI / 8);
    }
  }
  [[nodiscard]] Reach reach(const CellLayout& with, const PlacedStone& there) const {
    const Arrangement arrangement{{}, {there}};
    return {arrangement, make_planning_scene(with, robot, catalogue, arrangement), catalogue, motion_};
  }
  [[nodiscard]] PlacedStone lying(StoneIndex index, const RestPose& rest, const Eigen::Vector2d& p_W) const {
    PlacedStone placed{index, make_pose(Eigen::Vector3d::Zero(), rest.R_W_O)};
    double low = 1.0;
    for (const auto& p : catalogue[index].scan.vertices) low = std::min(low, (placed.T_W_O * p).z());
    placed.T_W_O.translation() << p_W, -low;
    return placed;
  }
  [[nodiscard]] bool held_at(const PlacedStone& there) const {
    return !reach(layout, there).at_pick(there.stone).usable.empty();
  }

 private:
  bool try_box(StoneIndex index, const RestPose& rest, double azimuth) {
    stone = lying(index, rest, CellLayout().field_centre);
    const Eigen::Vector3d towards(std::cos(azimuth), std::sin(azimuth), 0.0);
    double far = -1.0;
    for (const auto& p : catalogue[index].scan.vertices)
      far = std::max(far, towards.dot(stone.T_W_O * p - stone.T_W_O.translation()));
    Obstacle box;
    box.name = "box";
    box.pieces = {make_box({0.06, 0.12, 0.06})};
    box.T_W_O = make_pose(stone.T_W_O.translation() + (far + kGap + 0.03) * towards,
                          Eigen::Quaterniond(Eigen::AngleAxisd(azimuth, Eigen::Vector3d::UnitZ())));
    box.T_W_O.translation().z() = 0.03;
    layout.obstacles = {box};
    if (reach(CellLayout{}, stone).at_pick(index).usable.empty()) return false;  // it is not the box
    return !held_at(stone);
  }
  MotionOptions motion_;
};

TEST(PushFree, AStoneBesideABoxIsPushedToWhereAGraspServes) {
  const Blocked bench;
  ASSERT_TRUE(bench.found);
  const Models models = make_models(bench.catalogue, bench.robot, bench.layout);
  BuildOptions options;
  WorldEstimate world;
  world.layout = bench.layout;
  world.site = SiteStatus::kFree;
  world.loose.push_back({bench.stone.stone, bench.stone.T_W_O, bench.stone.T_W_O});
  const RunMemory memory = make_memory(options);
  add_resting_stacks(models, options, memory.friction, world);
  const Decision decision = choose_action(world, memory, models, options);
  const auto* push = std::get_if<Push>(&decision.action);
  ASSERT_NE(push, nullptr) << name_of(decision.action);
  ASSERT_FALSE(push->p_W_shifts.empty());
  for (const Eigen::Vector2d& shift : push->p_W_shifts)
    EXPECT_TRUE(bench.held_at(
        {bench.stone.stone, Eigen::Translation3d(shift.x(), shift.y(), 0.0) * bench.stone.T_W_O}));

  RunMemory refused = memory;
  refused.not_pushed.insert(bench.stone.stone);
  EXPECT_FALSE(std::holds_alternative<Push>(choose_action(world, refused, models, options).action));
  RunMemory often = memory;
  often.pushed = options.max_reoriented;
  EXPECT_FALSE(std::holds_alternative<Push>(choose_action(world, often, models, options).action))
      << "not for ever";
}

TEST(PushFree, AStoneThatStayedWhereItWasIsNotPushedOnceMore) {
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  const RobotModel robot = read_robot("ur10");
  const Models models = make_models(catalogue, robot, CellLayout{});
  const BuildOptions options;
  const Pose T_W_O = make_pose(Eigen::Vector3d(0.7, -0.2, 0.05));
  for (const double moved : {0.003, 0.025}) {
    RunMemory memory = make_memory(options);
    Attempt attempt;
    attempt.action = Push{{1_stone, T_W_O}, {Eigen::Vector2d(0.03, 0.0)}};
    attempt.done.status = ExecutionResult::Status::kReleased;
    attempt.placement.stone = 1_stone;
    memory.attempt = attempt;
    WorldEstimate seen;
    seen.site = SiteStatus::kFree;
    const Pose now = Eigen::Translation3d(moved, 0.0, 0.0) * T_W_O;
    seen.loose.push_back({1_stone, now, now});
    memory = learn(std::move(memory), seen, models, options, {});
    ASSERT_EQ(memory.records.size(), 1U);
    EXPECT_EQ(memory.not_pushed.contains(1_stone), moved < 0.01) << moved;
  }
}

TEST(PushFree, APlacementThatHoldsAllowsFurtherPushes) {
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  const RobotModel robot = read_robot("ur10");
  const Models models = make_models(catalogue, robot, CellLayout{});
  const BuildOptions options;
  const Pose T_W_O = make_pose(Eigen::Vector3d(0.7, 0.28, 0.05));
  for (const bool stands : {false, true}) {
    RunMemory memory = make_memory(options);
    memory.pushed = 2;
    Attempt attempt;
    attempt.placement.stone = 1_stone;
    attempt.placement.T_W_O = T_W_O;
    attempt.action = Place{{attempt.placement}};
    attempt.done.status = ExecutionResult::Status::kReleased;
    memory.attempt = attempt;
    WorldEstimate seen;
    (stands ? seen.stack : seen.loose).push_back({1_stone, T_W_O, T_W_O});
    add_resting_stacks(models, options, memory.friction, seen);
    memory = learn(std::move(memory), seen, models, options, {});
    ASSERT_EQ(memory.records.size(), 1U);
    EXPECT_EQ(memory.records.front().outcome == PlacementRecord::Outcome::kPlaced, stands);
    EXPECT_EQ(memory.pushed, stands ? 0 : 2);
  }
}

TEST(PushFree, AStoneThatCanBeGraspedIsNotPushed) {
  const Blocked bench;
  const Models models = make_models(bench.catalogue, bench.robot, CellLayout{});
  BuildOptions options;
  options.search.horizon = 1;
  WorldEstimate world;
  world.site = SiteStatus::kFree;
  world.loose.push_back({bench.stone.stone, bench.stone.T_W_O, bench.stone.T_W_O});
  const RunMemory memory = make_memory(options);
  add_resting_stacks(models, options, memory.friction, world);
  EXPECT_TRUE(std::holds_alternative<Place>(choose_action(world, memory, models, options).action));
}

/// The blocked stone beside another stone in the box's place.
struct BesideASlab : Blocked {
  Obstacle box;
  StoneIndex neighbour{6};
  WorldEstimate world;

  BesideASlab() : box(layout.obstacles.front()) {
    Stone slab;
    slab.name = "slab";
    slab.mesh = slab.scan = box.pieces.front();
    slab.pieces = box.pieces;
    slab.mass = mass_properties(slab.scan, slab.density);
    neighbour = StoneIndex(catalogue.stones.size());
    catalogue.stones.push_back(slab);
    layout.obstacles.clear();
    world.site = SiteStatus::kFree;
    world.loose = {{stone.stone, stone.T_W_O, stone.T_W_O}, {neighbour, box.T_W_O, box.T_W_O}};
  }
};

TEST(PushFree, WhereAStoneCannotBePushedItsNeighbourIs) {
  BesideASlab bench;
  ASSERT_TRUE(bench.found);
  const Models models = make_models(bench.catalogue, bench.robot, bench.layout);
  const BuildOptions options;
  const Listener nobody;
  const Situation situation = make_situation(bench.world, models, options, nobody);
  RunMemory memory = make_memory(options);
  memory.not_pushed.insert(bench.stone.stone);
  EXPECT_FALSE(push_free(situation, memory, Neighbours::kLasting)) << "the neighbour may be taken first";
  const auto push = push_free(situation, memory, Neighbours::kAll);
  ASSERT_TRUE(push);
  EXPECT_EQ(push->stone.stone, bench.neighbour);
  ASSERT_FALSE(push->p_W_shifts.empty());
  for (const Eigen::Vector2d& shift : push->p_W_shifts) {
    bench.layout.obstacles = {bench.box};
    bench.layout.obstacles[0].T_W_O.pretranslate(Eigen::Vector3d(shift.x(), shift.y(), 0.0));
    EXPECT_TRUE(bench.held_at(bench.stone));
  }
}

TEST(PushFree, AStoneThatWouldTurnAgainstTheStackIsPushedLast) {
  BesideASlab bench;
  ASSERT_TRUE(bench.found);
  const StoneIndex stacked(bench.catalogue.stones.size());
  bench.catalogue.stones.push_back(bench.catalogue[bench.neighbour]);
  bench.catalogue.stones.back().name = "stacked slab";
  const Models models = make_models(bench.catalogue, bench.robot, bench.layout);
  const BuildOptions options;
  const Listener nobody;
  const RunMemory memory = make_memory(options);
  RunMemory neighbour_stays = memory;
  neighbour_stays.not_pushed.insert(bench.neighbour);
  const auto pushed = [&](const RunMemory& by) {
    const Situation situation = make_situation(bench.world, models, options, nobody);
    const auto push = push_free(situation, by, Neighbours::kAll);
    return push ? push->stone.stone : kNoStone;
  };
  EXPECT_EQ(pushed(memory), bench.stone.stone) << "no stack is near";
  // A slab of the stack 6 mm beside the stone, where its pushes lead past: as it lies it keeps off the slab.
  const double azimuth = 1.25 * M_PI;
  const Eigen::Vector2d towards(std::cos(azimuth), std::sin(azimuth));
  const Stone& stone = bench.catalogue[bench.stone.stone];
  const Eigen::Vector2d p_W_M = (bench.stone.T_W_O * stone.mass.p_O_M).head<2>();
  double far = 0.0;
  for (const auto& p_O : stone.scan.vertices)
    far = std::max(far, towards.dot((bench.stone.T_W_O * p_O).head<2>() - p_W_M));
  Pose T_W_O = bench.box.T_W_O;
  T_W_O.linear() = Eigen::AngleAxisd(azimuth, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  T_W_O.translation().head<2>() = p_W_M + (far + 0.006 + 0.03) * towards;
  bench.world.stack = {{stacked, T_W_O, T_W_O}};
  EXPECT_EQ(pushed(memory), bench.neighbour);
  EXPECT_EQ(pushed(neighbour_stays), bench.stone.stone) << "rather than nothing";
}

TEST(PushFree, AStoneThatThePlanLeavesOutIsGivenRoomFirst) {
  BesideASlab bench;
  ASSERT_TRUE(bench.found);
  const Models models = make_models(bench.catalogue, bench.robot, bench.layout);
  BuildOptions options;
  const RunMemory memory = make_memory(options);
  add_resting_stacks(models, options, memory.friction, bench.world);
  const auto action = [&] { return choose_action(bench.world, memory, models, options).action; };
  EXPECT_TRUE(std::holds_alternative<Push>(action())) << name_of(action());
  options.max_stones = 1;
  EXPECT_TRUE(std::holds_alternative<Place>(action())) << "no stone is left out of what was asked for";
}

TEST(PushFree, TheLoopPushesAndPlacesTheStone) {
  const Blocked bench;
  ASSERT_TRUE(bench.found);
  SimulationOptions world_options;
  world_options.seed = 7;
  const StoneIndex other = bench.stone.stone == 1_stone ? 2_stone : 1_stone;
  SimulatedCell world(bench.catalogue.stones, {bench.stone.stone, other}, bench.robot, bench.layout,
                      world_options);
  const Eigen::Vector2d away = bench.layout.field_centre + Eigen::Vector2d(-0.15, 0.15);
  world.place(other, bench.lying(other, rest_poses(bench.catalogue[other]).front(), away).T_W_O);
  world.place(bench.stone.stone, bench.stone.T_W_O);
  BuildOptions options;
  options.search.horizon = 1;
  Cell cell = world.cell();
  const RunResult result = build_tower(cell, bench.catalogue, bench.robot, options);
  const std::string message = test::words(result.events, bench.catalogue);
  const auto pushed =
      std::find_if(result.placements.begin(), result.placements.end(),
                   [](const auto& record) { return record.outcome == PlacementRecord::Outcome::kPushed; });
  ASSERT_NE(pushed, result.placements.end()) << message;
  ASSERT_TRUE(pushed->T_W_O_measured) << message;
  const Eigen::Vector3d& p_O_M = bench.catalogue[bench.stone.stone].mass.p_O_M;  // it turns about that, too
  const Eigen::Vector3d before = bench.stone.T_W_O * p_O_M;
  const Eigen::Vector3d planned = pushed->planned.T_W_O * p_O_M - before;
  const Eigen::Vector3d moved = *pushed->T_W_O_measured * p_O_M - before;
  EXPECT_LT((moved - planned).norm(), 0.4 * planned.norm()) << message;
  EXPECT_EQ(result.height, 2) << message;
}

/// A program that ends while the gripper stands behind the stone, near the table.
TEST(PushFree, ARunThatEndsInTheMidstOfAPushGoesOn) {
  const Blocked bench;
  ASSERT_TRUE(bench.found);
  const std::string folder = test::temporary_folder() + "killed_push";
  const auto perform = [&](bool goes_on, RunResult* result) {
    SimulationOptions world_options;
    world_options.seed = 7;
    SimulatedCell world(bench.catalogue.stones, {bench.stone.stone}, bench.robot, bench.layout, world_options,
                        goes_on ? folder : std::string());
    if (!goes_on) world.place(bench.stone.stone, bench.stone.T_W_O);
    world.keep_in(folder);
    Journal journal(folder + "/journal.jsonl");
    const Cell devices = world.cell();
    test::MortalArm arm(devices.arm);
    arm.before = [] {};
    arm.after = [&] {
      if (!goes_on && journal.step().rfind("push", 0) == 0) throw test::Killed();
    };
    Cell cell{arm, devices.gripper, devices.force_torque, devices.camera, devices.clock, devices.layout};
    BuildOptions options;
    options.search.horizon = 1;
    BuildHooks hooks;
    hooks.journal = &journal;
    *result = build_resumable(cell, bench.catalogue, bench.robot, options, hooks, folder, goes_on);
  };
  RunResult result;
  ASSERT_THROW(perform(false, &result), test::Killed);
  perform(true, &result);
  EXPECT_EQ(result.height, 1) << result.ended << "\n" << test::words(result.events, bench.catalogue);
}

/// Ends the program half way up from a pushed stone; afterwards keeps the first motion.
struct RisingArm : test::MortalArm {
  const Journal& journal;
  bool dies;
  JointPath first;
  RisingArm(Arm& a, const Journal& j, bool mortal) : MortalArm(a), journal(j), dies(mortal) {
    before = after = [] {};
  }
  MotionResult follow(const JointTrajectory& t) override {
    if (!dies && first.empty()) first = {t.q.front(), t.q.back()};
    if (!dies || journal.step().rfind("rise", 0) != 0) return MortalArm::follow(t);
    const RobotModel robot = read_robot("ur10");
    const TimingLimits limits = timing_limits(robot, MotionOptions());
    (void)arm.follow(
        time_path({t.q.front(), sample(t, 0.5 * t.duration()).q}, limits, robot, CellLayout().T_F_T));
    throw test::Killed();
  }
};

TEST(PushFree, ARunThatEndsHalfWayUpFromAPushGoesStraightOnUp) {
  const Blocked bench;
  ASSERT_TRUE(bench.found);
  const std::string folder = test::temporary_folder() + "killed_rise";
  JointPath first;
  for (const bool goes_on : {false, true}) {
    SimulationOptions world_options;
    world_options.seed = 7;
    SimulatedCell world(bench.catalogue.stones, {bench.stone.stone}, bench.robot, bench.layout, world_options,
                        goes_on ? folder : std::string());
    if (!goes_on) world.place(bench.stone.stone, bench.stone.T_W_O);
    world.keep_in(folder);
    Journal journal(folder + "/journal.jsonl");
    const Cell devices = world.cell();
    RisingArm arm(devices.arm, journal, !goes_on);
    Cell cell{arm, devices.gripper, devices.force_torque, devices.camera, devices.clock, devices.layout};
    BuildOptions options;
    options.search.horizon = 1;
    BuildHooks hooks;
    hooks.journal = &journal;
    if (!goes_on) {
      ASSERT_THROW((void)build_resumable(cell, bench.catalogue, bench.robot, options, hooks, folder, false),
                   test::Killed);
      continue;
    }
    const RunResult result =
        build_resumable(cell, bench.catalogue, bench.robot, options, hooks, folder, true);
    EXPECT_EQ(result.height, 1) << result.ended;
    first = arm.first;
  }
  ASSERT_EQ(first.size(), 2U);
  const auto tip = [&](const Joints& q) -> Eigen::Vector3d {
    return (forward(bench.robot, q) * bench.layout.T_F_T).translation();
  };
  const Eigen::Vector3d moved = tip(first[1]) - tip(first[0]);
  EXPECT_LT(moved.head<2>().norm(), 0.003) << "not over to where the plan would have it rise";
  EXPECT_GT(moved.z(), 0.02);
}

}  // namespace
}  // namespace stonestack::stacking
