#include "stacking/model_unrecognised.hpp"

#include <gtest/gtest.h>

#include <filesystem>

#include "rooms.hpp"
#include "search/search_context.hpp"
#include "stacking/heard.hpp"
#include "stacking/journal.hpp"
#include "stacking/resume_point.hpp"
#include "stacking/saved_states.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stacking/scene_tasks.hpp"
#include "temporary_folder.hpp"
#include "unknown_pile.hpp"

/// Runs whose stones nobody scanned, with a model that does not show what lies there.
namespace stonestack::stacking {
namespace {

using namespace simulation;

/// Two stones lie in the field. The program has a model of the first, and one of a stone that is nowhere.
struct WrongModel {
  Catalogue truth = read_catalogue(data_path("stones"));
  RobotModel robot = read_robot("ur10");
  SimulatedCell world{truth.stones, {1_stone, 3_stone}, robot, CellLayout{}, simulation()};
  std::string folder = stonestack::test::states_folder(stonestack::test::temporary_folder(), "anew");
  Catalogue known;
  std::vector<Stone> modelled;
  RunResult result;

  explicit WrongModel(bool unseen) {
    std::filesystem::remove_all(stones());
    Stone second = truth[5_stone];
    second.name = "stone_2";
    for (const Stone& stone : {truth[1_stone], second}) write_stone(stones(), stone);
    known = read_catalogue(stones());
    Journal journal(folder + "/journal.jsonl");
    BuildHooks hooks;
    hooks.journal = &journal;
    hooks.states_folder = folder;
    Cell cell = world.cell();
    BuildOptions options;
    options.unseen = unseen;
    options.save_states = true;
    options.search.horizon = 2;
    result = build_resumable(cell, known, robot, options, hooks, {}, false,
                             [&](const Stone& stone, const ModelledStone&) {
                               write_stone(stones(), stone);
                               modelled.push_back(stone);
                             });
  }
  [[nodiscard]] std::string stones() const { return folder + "/stones"; }
  static SimulationOptions simulation() {
    SimulationOptions options;
    options.seed = 5;
    options.clearance = 0.02;
    return options;
  }
  [[nodiscard]] std::string story() const {
    Catalogue all = known;
    all.stones.insert(all.stones.end(), modelled.begin(), modelled.end());
    return stonestack::test::words(result.events, all);
  }
};

TEST(ModelUnrecognised, AStoneThatNoModelShowsBecomesAnotherStoneOfTheRun) {
  const WrongModel run(true);
  ASSERT_EQ(run.modelled.size(), 1U) << run.story();
  EXPECT_EQ(run.modelled[0].name, "stone_3");
  ASSERT_TRUE(run.modelled[0].surface.has_value()) << "most of its underside is a guess, and says so";
  const StoneIndex lost(run.known.index("stone_2"));
  const auto told = all_of<StoneModelled>(run.result.events);
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].lost, std::vector<StoneIndex>{lost});
  EXPECT_NEAR(run.modelled[0].mass.mass, run.known[lost].mass.mass, 1e-9) << "of the one that is lost";
  const double volume_is = volume(run.truth[3_stone].scan);
  EXPECT_NEAR(volume(run.modelled[0].scan), volume_is, 0.3 * volume_is);
  bool handled = false;
  for (const PlacementRecord& record : run.result.placements) handled |= record.stone == "stone_3";
  EXPECT_TRUE(handled) << run.story();

  // The catalogue has the new stone now; the run began without it.
  const Replay again = replay_run({run.folder, "", ""});
  EXPECT_EQ(again.difference, "");
  EXPECT_TRUE(again.complete);
  EXPECT_EQ(again.same, again.recorded);
}

TEST(ModelUnrecognised, NotWhereTheStonesWereScanned) {
  const WrongModel run(false);
  EXPECT_TRUE(run.modelled.empty());
  EXPECT_TRUE(all_of<ModellingBegun>(run.result.events).empty());
  EXPECT_EQ(run.result.height, 1);
}

/// Its own model says nothing: what is made of it rests as it does, and is where it is.
TEST(ModelUnrecognised, AStoneInSightIsModelledWhereItStands) {
  const Catalogue truth = read_catalogue(data_path("stones"));
  const RobotModel robot = read_robot("ur10");
  SimulatedCell cell{truth.stones, {1_stone, 3_stone}, robot, CellLayout{}, WrongModel::simulation()};
  const Truth lying = cell.truth();
  Pose T_W_O = at(lying.T_W_O, 1_stone);
  T_W_O.translation().head<2>() = CellLayout{}.site;
  cell.place(1_stone, T_W_O);
  const BuildOptions options;
  const Models models = make_models(truth, robot, CellLayout{});
  const DetectionModels detection(truth.stones, options.detection);
  StageSeconds seconds;
  Workcell workcell{cell.cell(), models, detection, options, seconds, [](const Event&) {}, {}};
  Expectation first;
  first.first = true;
  const WorldEstimate world = observe(workcell, first, [](const WorldEstimate&) {}).world;
  ASSERT_EQ(world.stack.size(), 1U);
  ASSERT_EQ(world.stack.front().stone, 1_stone);

  const ModelledField field =
      model_unrecognised(workcell, world, make_memory(options), ModelAnew{{1_stone}, true}, nullptr);
  ASSERT_EQ(field.stones.size(), 1U) << (field.left_out.empty() ? "" : field.left_out.front());
  const Stone& made = field.catalogue.stones.front();
  const Pose& T_W_O_made = *field.stones.front().T_W_O;
  const Eigen::Vector3d p_W_M = T_W_O * truth[1_stone].mass.p_O_M;
  EXPECT_LT((T_W_O_made * made.mass.p_O_M - p_W_M).norm(), 0.012);
  const double volume_is = volume(truth[1_stone].scan);
  EXPECT_NEAR(volume(made.scan), volume_is, 0.3 * volume_is);
  EXPECT_NEAR(made.mass.mass, truth[1_stone].mass.mass, 1e-9) << "that of the stone, which was weighed";
  const search::StandingStack standing =
      search::settled_stack(make_contact_shapes({made}), Stack{{{0_stone, T_W_O_made}}}, {}, true);
  EXPECT_TRUE(standing.stack.has_value()) << standing.reason;
  if (standing.stack) {
    EXPECT_LT(difference(standing.stack->stones[0].T_W_O, T_W_O_made).angle, 0.03);
  }
}

TEST(ModelUnrecognised, OneObjectIsOneStone) {
  stonestack::test::UnknownPile pile({2_stone, 4_stone, 5_stone});
  const ModelledField field = model_unrecognised(pile.workcell, pile.observed(), make_memory(pile.options),
                                                 ModelAnew{{1_stone, 2_stone}}, nullptr);
  ASSERT_FALSE(field.stones.empty()) << (field.left_out.empty() ? "" : field.left_out.front());
  for (std::size_t i = 0; i < field.stones.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const auto middle = [&](std::size_t k) {
        return Eigen::Vector3d(*field.stones[k].T_W_O * field.catalogue.stones[k].mass.p_O_M);
      };
      EXPECT_GT((middle(i) - middle(j)).norm(), 0.03);
    }
}

/// It stands 0.4 rad beside how its model rests there, whose underside is a guess.
TEST(ModelUnrecognised, AStoneOnAnotherGetsAnUndersideOnWhichItRests) {
  Catalogue known;
  known.stones.push_back(model_stone(make_box({0.09, 0.08, 0.05}), "base", "a box", {}).stone);
  Mesh pebble = make_sphere(1.0, 4);  // whose lower half nobody saw
  for (Eigen::Vector3d& p : pebble.vertices) p = p.cwiseProduct(Eigen::Vector3d(0.045, 0.035, 0.025));
  known.stones.push_back(model_stone(pebble, "top", "a pebble", {}).stone);
  Stone& guess = known.stones.back();
  SurfaceKnowledge surface;
  for (const Eigen::Vector3d& p : guess.scan.vertices) surface.seen.push_back(p.z() > 0.0 ? 1 : 0);
  surface.sigma.assign(surface.seen.size(), 0.001);
  guess.surface = surface;
  const RobotModel robot = read_robot("ur10");
  SimulatedCell cell{known.stones, {0_stone}, robot, CellLayout{}, WrongModel::simulation()};
  const BuildOptions options;
  const Models models = make_models(known, robot, CellLayout{});
  const DetectionModels detection(known.stones, options.detection);
  StageSeconds seconds;
  Workcell workcell{cell.cell(), models, detection, options, seconds, [](const Event&) {}, {}};
  const Pose T_W_base = make_pose({0.0, 0.0, 0.025});
  Pose T_W_top = make_pose({0.0, 0.0, 0.08});
  T_W_top.rotate(Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitY()));
  double lowest = 1.0;
  for (const Eigen::Vector3d& p : guess.scan.vertices) lowest = std::min(lowest, (T_W_top * p).z());
  T_W_top.pretranslate(Eigen::Vector3d(0.0, 0.0, 0.05 - lowest));
  WorldEstimate world;
  world.stack = {{0_stone, T_W_base, T_W_base}, {1_stone, T_W_top, T_W_top}};
  const auto rests = [&](const Stone& top, const Pose& T_W_O) {
    const search::StandingStack standing = search::settled_stack(
        make_contact_shapes({known[0_stone], top}), Stack{{{0_stone, T_W_base}, {1_stone, T_W_O}}}, {}, true);
    return standing.stack && difference(standing.stack->stones[1].T_W_O, T_W_O).angle < 0.05;
  };
  ASSERT_FALSE(rests(guess, T_W_top)) << "by its model it tips over";
  const ModelledField field =
      model_unrecognised(workcell, world, make_memory(options), ModelAnew{{1_stone}, true}, nullptr);
  ASSERT_EQ(field.stones.size(), 1U) << (field.left_out.empty() ? "" : field.left_out.front());
  const Stone& made = field.catalogue.stones.front();
  EXPECT_TRUE(rests(made, *field.stones.front().T_W_O));
  EXPECT_NEAR(made.mass.mass, guess.mass.mass, 1e-9);
  EXPECT_TRUE(made.surface.has_value());
}

}  // namespace
}  // namespace stonestack::stacking
