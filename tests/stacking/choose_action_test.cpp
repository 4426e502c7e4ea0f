#include "stacking/choose_action.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/constants.hpp"
#include "stacking/arrangement.hpp"
#include "stacking/choose_placement.hpp"
#include "stacking/heard.hpp"
#include "stacking/learn.hpp"
#include "stacking/state_file.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "temporary_folder.hpp"

/// Decisions without a cell: states that runs saved, and what is changed in them.
namespace stonestack::stacking {
namespace {

const Catalogue& limestones() {
  static const Catalogue catalogue = read_catalogue(data_path("stones"));
  return catalogue;
}
const RobotModel& ur10() {
  static const RobotModel robot = read_robot("ur10");
  return robot;
}
const Models& models() {
  static const Models made = make_models(limestones(), ur10(), CellLayout{});
  return made;
}

std::string state_path(const std::string& name) {
  return std::string(STONESTACK_SOURCE_DIR "/tests/data/states/") + name + ".json";
}

State read(const std::string& name) {
  State state = read_state(state_path(name), limestones());
  add_resting_stacks(models(), state.options, state.memory.friction, state.world);
  return state;
}

Decision decide(const State& state) {
  return choose_action(state.world, state.memory, models(), state.options);
}

TEST(ChooseAction, PlacesByWhatTheSearchFound) {
  const State state = read("place");
  const Decision decision = decide(state);
  const auto* place = std::get_if<Place>(&decision.action);
  ASSERT_NE(place, nullptr) << name_of(decision.action);
  ASSERT_FALSE(place->candidates.empty());
  EXPECT_TRUE(holds(state.world.loose, place->candidates.front().stone));
  ASSERT_TRUE(decision.memory.search.has_value());
  EXPECT_FALSE(decision.memory.search->found.best.empty());
}

TEST(ChooseAction, IsPure) {
  const State state = read("place");
  const std::string once = decision_json(decide(state), limestones());
  EXPECT_EQ(decision_json(decide(state), limestones()), once);
}

TEST(ChooseAction, ReorientsWhereNoGraspServesBothEnds) {
  const Decision decision = decide(read("reorient"));
  const auto* reorient = std::get_if<Reorient>(&decision.action);
  ASSERT_NE(reorient, nullptr) << name_of(decision.action) << "\n" << test::words(decision.why, limestones());
  EXPECT_EQ(reorient->candidates.front().stone, 1_stone);
}

TEST(ChooseAction, ClearsTheBaseFirst) {
  const State state = read("clear_base");
  const Decision decision = decide(state);
  const auto* clear = std::get_if<ClearBase>(&decision.action);
  ASSERT_NE(clear, nullptr) << name_of(decision.action);
  EXPECT_EQ(clear->stray.stone, 1_stone);
  EXPECT_EQ(clear->level, 0U);
  EXPECT_FALSE(clear->T_W_O_down.empty());

  State often = state;
  often.memory.cleared = 4;
  EXPECT_FALSE(std::holds_alternative<ClearBase>(decide(often).action)) << "not for ever";
}

TEST(ChooseAction, PushesThenUnstacksWhereNoMotionClearsTheBase) {
  State state = read("unstack");
  const Decision first = decide(state);
  const auto* push = std::get_if<Push>(&first.action);
  ASSERT_NE(push, nullptr) << name_of(first.action);
  EXPECT_EQ(push->stone.stone, 1_stone);
  EXPECT_FALSE(push->p_W_shifts.empty());

  state.memory.not_pushed.insert(1_stone);
  const Decision decision = decide(state);
  const auto* unstack = std::get_if<Unstack>(&decision.action);
  ASSERT_NE(unstack, nullptr) << name_of(decision.action);
  EXPECT_EQ(unstack->top.stone, state.world.stack.back().stone);
  const auto why = all_of<UnstackToFree>(decision.why);
  ASSERT_EQ(why.size(), 1U);
  EXPECT_EQ(why[0].freed, 1_stone);

  State never = state;
  never.options.max_unstacked = 0;
  EXPECT_FALSE(std::holds_alternative<Unstack>(decide(never).action));
}

TEST(ChooseAction, StopsWhenAllStonesArePlaced) {
  const Decision decision = decide(read("stop"));
  const auto* stop = std::get_if<Stop>(&decision.action);
  ASSERT_NE(stop, nullptr) << name_of(decision.action);
  EXPECT_EQ(stop->end, RunEnd::kAllPlaced);
}

TEST(ChooseAction, StopsAtTheHeightThatWasAskedFor) {
  State state = read("place");
  ASSERT_FALSE(state.world.stack.empty());
  state.options.max_stones = static_cast<int>(state.world.stack.size());
  const Decision decision = decide(state);
  ASSERT_TRUE(std::holds_alternative<Stop>(decision.action)) << name_of(decision.action);
  EXPECT_EQ(std::get<Stop>(decision.action).end, RunEnd::kHeightReached);
}

TEST(ChooseAction, NothingIsPlannedAboveTheHeightThatWasAskedFor) {
  State state = read("place");
  state.memory.plan.reset();
  state.memory.search.reset();
  state.options.search.rounds = 1;  // quick
  state.options.search.horizon = 2;
  const auto stones_after_next = [](const State& before) {
    const Decision decision = decide(before);
    const auto* place = std::get_if<Place>(&decision.action);
    return place == nullptr ? std::size_t{99} : place->candidates.front().then.size();
  };
  EXPECT_EQ(stones_after_next(state), 1U);
  state.options.max_stones = static_cast<int>(state.world.stack.size()) + 1;
  EXPECT_EQ(stones_after_next(state), 0U);
}

TEST(ChooseAction, StopsAfterAFailureBeforeAllElse) {
  State state = read("clear_base");
  state.memory.failure = Failure{RunEnd::kPlacementFailed, "it fell"};
  const Decision decision = decide(state);
  ASSERT_TRUE(std::holds_alternative<Stop>(decision.action));
  EXPECT_EQ(std::get<Stop>(decision.action).end, RunEnd::kPlacementFailed);
  EXPECT_EQ(std::get<Stop>(decision.action).reason, "it fell");
}

TEST(ChooseAction, ViewsTheOldPlaceThenTheSiteThenGivesUp) {
  State state = read("stop");
  const StoneIndex gone = state.world.stack.back().stone;
  state.memory.last_seen[gone] = {0.7, -0.2, 0.03};
  state.world.stack.pop_back();
  Decision decision = decide(state);
  ASSERT_TRUE(std::holds_alternative<LookAgain>(decision.action)) << name_of(decision.action);
  EXPECT_EQ(std::get<LookAgain>(decision.action).stone, gone);
  EXPECT_EQ(std::get<LookAgain>(decision.action).where, LookAgain::Where::kWhereItWas);
  EXPECT_DOUBLE_EQ(std::get<LookAgain>(decision.action).p_W_target.y(), -0.2);
  state.memory.sought_where_it_was.insert(gone);
  decision = decide(state);
  ASSERT_TRUE(std::holds_alternative<LookAgain>(decision.action));
  EXPECT_EQ(std::get<LookAgain>(decision.action).where, LookAgain::Where::kBesideSite);
  state.memory.sought_beside_site = 4;
  EXPECT_FALSE(std::holds_alternative<LookAgain>(decide(state).action));
}

TEST(ChooseAction, WithoutAStoneInSightARunEnds) {
  State state = read("place");
  state.world.stack.clear();
  state.world.loose.clear();
  state.memory = make_memory(state.options);
  const Decision decision = decide(state);
  ASSERT_TRUE(std::holds_alternative<Stop>(decision.action));
  EXPECT_EQ(std::get<Stop>(decision.action).end, RunEnd::kNothingSeen);
}

TEST(ChooseAction, NothingIsSetDownOnWhatIsNotRecognised) {
  State state = read("place");
  Obstacle object;
  object.name = "unknown object 1";
  object.pieces = {make_box({0.10, 0.10, 0.08})};
  const Eigen::Vector2d site = state.world.layout.site;
  object.T_W_O = make_pose({site.x() + 0.02, site.y(), 0.04});
  state.world.layout.obstacles = {object};
  ASSERT_FALSE(std::holds_alternative<Stop>(decide(state).action)) << "a tower stands there";
  state.world.stack.clear();
  state.memory.last_seen.clear();
  add_resting_stacks(models(), state.options, state.memory.friction, state.world);
  const Decision decision = decide(state);
  const auto* stop = std::get_if<Stop>(&decision.action);
  ASSERT_NE(stop, nullptr) << name_of(decision.action);
  EXPECT_EQ(stop->end, RunEnd::kNoPose);
  EXPECT_NE(stop->reason.find("unknown object 1 lies at the site"), std::string::npos) << stop->reason;
  object.T_W_O = make_pose({site.x(), site.y(), 0.9});  // a shelf above
  Obstacle table;
  table.name = "table";
  table.pieces = {make_box({2.0, 2.0, 0.1})};
  table.T_W_O = make_pose({site.x(), site.y(), -0.05});
  state.world.layout.obstacles = {object, table};
  EXPECT_FALSE(std::holds_alternative<Stop>(decide(state).action)) << "neither lies at the site";
}

TEST(ChooseAction, ModelsWhatIsNotRecognisedWhereAnAwaitedStoneIsNotSeen) {
  State state = read("place");
  state.options.search.horizon = 1;  // quick
  std::vector<StoneIndex> absent;    // the state has four of the six stones of the catalogue
  for (const StoneIndex stone : first_stones(limestones().stones.size()))
    if (!holds(state.world.stack, stone) && !holds(state.world.loose, stone)) absent.push_back(stone);
  ASSERT_GE(absent.size(), 2U);
  const StoneIndex lost = absent[0];
  ASSERT_TRUE(std::holds_alternative<Place>(decide(state).action)) << "none is awaited";
  state.memory.awaited = {state.world.loose.front().stone, lost};
  const Decision decision = decide(state);
  const auto* model = std::get_if<ModelAnew>(&decision.action);
  ASSERT_NE(model, nullptr) << name_of(decision.action);
  EXPECT_EQ(model->lost, std::vector<StoneIndex>{lost});
  State reached = state;
  reached.options.max_stones = static_cast<int>(state.world.stack.size());
  EXPECT_TRUE(std::holds_alternative<Stop>(decide(reached).action));
  state.memory = remember_modelled(state.memory, ModelAnew{{lost}}, {}, models());
  EXPECT_TRUE(std::holds_alternative<Place>(decide(state).action)) << "once is enough";
  state.memory.awaited.insert(absent[1]);
  EXPECT_TRUE(std::holds_alternative<ModelAnew>(decide(state).action));
  state.memory.modelled_anew = 4;
  EXPECT_TRUE(std::holds_alternative<Place>(decide(state).action)) << "not without end";
}

/// The next view may displace what was predicted from one: more than one search in vain is not made for it.
TEST(ChooseAction, OnAPredictionOneSearchInVainIsTheLast) {
  State state = read("place");
  state.options.search.horizon = 1;
  state.memory.search.reset();
  state.memory.plan.reset();
  const auto on = [&](Basis basis) {
    return choose_action(state.world, state.memory, models(), state.options, {}, basis);
  };
  EXPECT_TRUE(on(Basis::kPredicted).memory.search.has_value());
  state.options.search.min_margin = 1.0;  // nothing bears that
  const Decision predicted = on(Basis::kPredicted);
  EXPECT_TRUE(std::holds_alternative<Stop>(predicted.action)) << name_of(predicted.action);
  EXPECT_FALSE(predicted.memory.search.has_value());
  EXPECT_EQ(all_of<SearchedAtFriction>(predicted.why).size(), 1U);
  const Decision observed = on(Basis::kObserved);
  EXPECT_TRUE(observed.memory.search.has_value());
  EXPECT_GT(all_of<SearchedAtFriction>(observed.why).size(), 1U);
}

/// A base of the tower that was set down just now, by a model that the camera made.
struct ModelledBase {
  Catalogue catalogue = limestones();
  State state = read("place");
  StoneIndex base = state.world.stack.front().stone;
  Models models;

  explicit ModelledBase(bool by_camera = true) : models(make_models(catalogue, ur10(), CellLayout{})) {
    const std::size_t vertices = limestones()[base].scan.vertices.size();
    if (by_camera)
      catalogue.stones[static_cast<std::size_t>(base.value())].surface =
          SurfaceKnowledge{std::vector<double>(vertices, 0.001), std::vector<char>(vertices, 0), {}};
    state.memory.awaited = {base, state.world.loose.front().stone};
    state.options.search.horizon = 1;  // quick
  }
  /// It rests by its model at no friction.
  void let_fall() {
    for (RestingStack& resting : state.world.resting) resting.stack.reset();
  }
  [[nodiscard]] Action action() const {
    return choose_action(state.world, state.memory, models, state.options).action;
  }
  [[nodiscard]] bool models_base() const {
    const Action chosen = action();
    const auto* model = std::get_if<ModelAnew>(&chosen);
    return model != nullptr && model->in_sight && model->lost == std::vector<StoneIndex>{base};
  }
};

TEST(ChooseAction, ABaseThatRestsAsItsModelCannotIsModelledWhereItStands) {
  ModelledBase in;
  ASSERT_EQ(in.state.world.stack.size(), 1U);
  ASSERT_TRUE(std::holds_alternative<Place>(in.action())) << "it rests as it was planned";
  in.let_fall();
  EXPECT_TRUE(in.models_base());
  in.state.memory.records.front().stone = "another stone";
  EXPECT_FALSE(in.models_base()) << "something was done since it was set down";

  ModelledBase scanned(false);
  scanned.let_fall();
  EXPECT_FALSE(scanned.models_base()) << "a scan is no guess";

  ModelledBase once;
  once.let_fall();
  once.state.memory = remember_modelled(once.state.memory, ModelAnew{{once.base}, true}, {}, once.models);
  EXPECT_FALSE(once.models_base()) << "nothing was made of it";
  EXPECT_TRUE(std::holds_alternative<Place>(once.action())) << "it stands, so it is built upon as it is seen";

  ModelledBase of_wall;
  of_wall.let_fall();
  of_wall.models.wall = read_wall_target("2+1");
  of_wall.state.memory.wall = WallPlanned{Pose::Identity(), {{of_wall.base, 0}}};
  EXPECT_FALSE(of_wall.models_base()) << "no course is planned for another stone";
}

TEST(ChooseAction, ABaseThatIsInclinedOtherwiseThanItsModelRestsIsModelledWhereItStands) {
  const auto models_when_turned = [](double angle, const Eigen::Vector3d& axis) {
    ModelledBase in;
    Pose& T_W_O = *in.state.memory.records.front().T_W_O_measured;
    T_W_O.linear() = Eigen::AngleAxisd(angle, axis) * T_W_O.linear();
    return in.models_base();
  };
  EXPECT_FALSE(models_when_turned(0.08, Eigen::Vector3d::UnitX()));
  EXPECT_TRUE(models_when_turned(0.25, Eigen::Vector3d::UnitX()));
  EXPECT_FALSE(models_when_turned(0.25, Eigen::Vector3d::UnitZ())) << "it slid, and is as its model";
}

TEST(ChooseAction, ATopStoneThatRestsAsItsModelCannotIsModelledWhereItStands) {
  State state = read("stop");
  state.options.max_stones = 5;
  Catalogue catalogue = limestones();
  const StoneIndex top = state.world.stack.back().stone;
  const std::size_t vertices = limestones()[top].scan.vertices.size();
  catalogue.stones[static_cast<std::size_t>(top.value())].surface =
      SurfaceKnowledge{std::vector<double>(vertices, 0.001), std::vector<char>(vertices, 0), {}};
  state.memory.awaited = {top};
  const Models by_camera = make_models(catalogue, ur10(), CellLayout{});
  const auto modelled = [&] {
    const Action chosen = choose_action(state.world, state.memory, by_camera, state.options).action;
    const auto* model = std::get_if<ModelAnew>(&chosen);
    return model != nullptr && model->in_sight && model->lost == std::vector<StoneIndex>{top};
  };
  Pose& T_W_O = *state.memory.records.back().T_W_O_measured;
  T_W_O.linear() = Eigen::AngleAxisd(0.25, Eigen::Vector3d::UnitX()) * T_W_O.linear();
  EXPECT_FALSE(modelled()) << "by its model it rests as it does";
  for (RestingStack& resting : state.world.resting) resting.stack.reset();
  EXPECT_TRUE(modelled());
  Pose& T_W_base = state.world.stack.front().T_W_O_at_rest;
  T_W_base.linear() = Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitX()) * T_W_base.linear();
  EXPECT_FALSE(modelled()) << "it is a stone below that cannot rest";
}

TEST(ExpectedModelled, OnTheTowerAtTheSiteOrInTheField) {
  const State state = read("place");
  const PlacedStone base{state.world.stack.front().stone, state.world.stack.front().T_W_O_at_rest};
  const Eigen::Vector2d site = state.world.layout.site;
  StoneIndex made;  // not in the world yet
  for (const StoneIndex stone : first_stones(limestones().stones.size()))
    if (!holds(state.world.stack, stone) && !holds(state.world.loose, stone)) made = stone;
  const auto expected = [&](const WorldEstimate& world, const Eigen::Vector3d& p_W, const Models& of) {
    return expected_modelled(world, make_memory(state.options), ModelAnew{{made}}, {{made, make_pose(p_W)}},
                             of);
  };
  const Eigen::Vector3d above(base.T_W_O.translation().x(), base.T_W_O.translation().y(), 0.11);
  EXPECT_TRUE(holds(expected(state.world, above, models()).stack, made));
  EXPECT_TRUE(holds(expected(state.world, {0.7, -0.3, 0.03}, models()).loose, made));
  EXPECT_FALSE(holds(expected(state.world, {0.7, -0.3, 0.03}, models()).stack, made));
  WorldEstimate cleared = state.world;
  cleared.stack.clear();
  EXPECT_TRUE(holds(expected(cleared, {site.x(), site.y(), 0.03}, models()).stack, made));
  EXPECT_TRUE(holds(expected(cleared, {0.7, -0.3, 0.03}, models()).loose, made));
  Models of_wall = models();
  of_wall.wall.emplace();
  EXPECT_TRUE(holds(expected(state.world, above, of_wall).loose, made)) << "a wall has no place for it";
  const Expectation instead = expected_modelled(
      state.world, make_memory(state.options), ModelAnew{{base.stone}, true}, {{made, base.T_W_O}}, models());
  EXPECT_TRUE(holds(instead.stack, made));
  EXPECT_FALSE(holds(instead.stack, base.stone));
}

TEST(ExpectedAfter, AStoneThatWasBroughtToTheSiteIsANewTop) {
  const State state = read("place");
  RunMemory memory = make_memory(state.options);
  EXPECT_FALSE(expected_after(state.world, memory, Stop{}).was_built);
  Attempt attempt;
  attempt.action = Place{};
  attempt.expected_stack = state.world.stack;
  memory.attempt = attempt;
  EXPECT_TRUE(expected_after(state.world, memory, Stop{}).new_top);
  EXPECT_TRUE(expected_after(state.world, memory, Stop{}).was_built);
  memory.attempt->action = Unstack{};
  memory.attempt->below = at_rest(state.world).stack;
  EXPECT_FALSE(expected_after(state.world, memory, Stop{}).new_top);
  EXPECT_FALSE(expected_after(state.world, memory, Stop{}).was_built);
  memory.records = state.memory.records;
  ASSERT_FALSE(memory.records.empty());
  EXPECT_TRUE(expected_after(state.world, memory, Stop{}).was_built) << "before";
}

TEST(ChooseAction, AStoneWhoseModelWasWrongIsNotLookedForAnyMore) {
  const ModelledBase in;
  const PlacedStone instead{2_stone, in.state.world.stack.front().T_W_O_at_rest};
  ASSERT_NE(in.base, instead.stone);
  const RunMemory memory =
      remember_modelled(in.state.memory, ModelAnew{{in.base}, true}, {instead}, in.models);
  EXPECT_TRUE(memory.disproved.contains(in.base));
  EXPECT_FALSE(memory.last_seen.contains(in.base)) << "no view is taken to find it";
  EXPECT_TRUE(memory.awaited.contains(instead.stone));
  EXPECT_EQ(expected_after(in.state.world, memory, Stop{}).disproved, memory.disproved);
  const RunMemory lost = remember_modelled(in.state.memory, ModelAnew{{in.base}}, {instead}, in.models);
  EXPECT_TRUE(lost.disproved.empty()) << "one that is out of sight may come to light again";
}

TEST(ChooseAction, AnObjectThatTwiceWeighedTooLittleForStoneIsLeftWhereItLies) {
  State state = read("place");
  Catalogue catalogue = limestones();
  const Models by_camera = make_models(catalogue, ur10(), CellLayout{});
  const auto placed = std::get<Place>(decide(state).action).candidates.front();
  const StoneIndex light = placed.stone;
  const auto pick = [&](double weight) {
    Attempt attempt;
    attempt.action = Place{{placed}};
    attempt.placement = placed;
    attempt.done.status = ExecutionResult::Status::kNotPicked;
    attempt.done.weight = weight;
    state.memory.attempt = attempt;
    state.memory = learn(state.memory, state.world, by_camera, state.options, {});
    return choose_action(state.world, state.memory, by_camera, state.options).action;
  };
  const auto places_it = [&](const Action& action) {
    const auto* place = std::get_if<Place>(&action);
    return place != nullptr && place->candidates.front().stone == light;
  };
  (void)pick(1.0);
  (void)pick(1.0);
  EXPECT_TRUE(state.memory.disproved.empty()) << "a scanned stone slipped";
  Stone& modelled = catalogue.stones[static_cast<std::size_t>(light.value())];
  const std::size_t vertices = modelled.scan.vertices.size();
  modelled.surface =
      SurfaceKnowledge{std::vector<double>(vertices, 0.001), std::vector<char>(vertices, 0), {}};
  (void)pick(kGravity * modelled.mass.mass);
  EXPECT_TRUE(state.memory.too_light.empty());
  (void)pick(1.0);
  EXPECT_TRUE(state.memory.disproved.empty()) << "it may have slipped once";
  EXPECT_FALSE(places_it(pick(1.0)));
  EXPECT_TRUE(state.memory.disproved.contains(light));
  EXPECT_FALSE(state.memory.last_seen.contains(light));
  EXPECT_FALSE(holds(expected_again(state.world, state.memory).loose, light)) << "but for an object";
  ASSERT_FALSE(state.memory.p_W_objects.empty());
}

TEST(ChooseAction, ObjectsThatLieThereWhileAllStonesAreSeenAreNoStones) {
  State state = read("place");
  Obstacle thing;
  thing.pieces = {make_box({0.06, 0.04, 0.05})};
  thing.T_W_O = Eigen::Translation3d(0.4, -0.1, 0.025);
  state.world.layout.obstacles = {thing};
  state.memory.awaited = {state.world.loose.front().stone};
  RunMemory memory = learn(state.memory, state.world, models(), state.options, {});
  ASSERT_EQ(memory.p_W_objects.size(), 1U);
  EXPECT_LT((memory.p_W_objects[0] - Eigen::Vector2d(0.4, -0.1)).norm(), 1e-9);
  state.world.layout.obstacles[0].T_W_O.translation().x() = 0.5;
  for (const StoneIndex stone : first_stones(limestones().stones.size())) memory.awaited.insert(stone);
  memory = learn(memory, state.world, models(), state.options, {});
  ASSERT_EQ(memory.p_W_objects.size(), 1U);
  EXPECT_NEAR(memory.p_W_objects[0].x(), 0.4, 1e-9)
      << "what lies there now may be the stone that is not seen";
}

/// The tower of "stop" without its top stone, which lies where nothing lifts it.
State with_top_out_of_reach() {
  State state = read("stop");
  const StoneEstimate top = state.world.stack.back();  // lies in the field again, where nothing lifts it
  state.world.stack.pop_back();
  Pose T_W_O = top.T_W_O_at_rest;
  T_W_O.translation().head<2>() = state.world.layout.field_centre;
  T_W_O.translation().z() -= 1.0;  // below the table
  state.world.loose = {{top.stone, T_W_O, T_W_O}};
  state.memory.last_seen.clear();
  state.options.max_unstacked = 0;
  return state;
}

/// Grasps that failed twice are tried again before a run ends, and only then.
TEST(ChooseAction, RetriesFailedGraspsBeforeItStops) {
  State state = with_top_out_of_reach();
  std::vector<Pose>& failed = state.memory.failed_grasps[state.world.loose.front().stone];
  failed = {Pose::Identity()};
  EXPECT_TRUE(all_of<GraspsRetried>(decide(state).why).empty()) << "it was not left out";
  failed.push_back(Pose::Identity());
  const Decision decision = decide(state);
  ASSERT_TRUE(std::holds_alternative<Stop>(decision.action)) << name_of(decision.action);
  EXPECT_EQ(std::get<Stop>(decision.action).end, RunEnd::kNoPose);
  EXPECT_EQ(all_of<GraspsRetried>(decision.why).size(), 1U);
  EXPECT_TRUE(decision.memory.failed_grasps.empty());
}

TEST(ChooseAction, LeavesOutGraspsThatFailedTwice) {
  RunMemory memory;
  const auto beside = [](double x) { return make_pose({x, 0.0, 0.0}); };
  memory.failed_grasps[1_stone] = {beside(0.0), beside(0.2)};
  EXPECT_TRUE(failed_twice(memory, 1_stone).empty());
  memory.failed_grasps[1_stone].push_back(beside(0.005));
  ASSERT_EQ(failed_twice(memory, 1_stone).size(), 1U);
  EXPECT_NEAR(failed_twice(memory, 1_stone).front().translation().x(), 0.005, 1e-12);
  EXPECT_TRUE(failed_twice(memory, 2_stone).empty());
}

/// A stone on which nothing fits, and that came to rest otherwise than planned, would do so again.
TEST(ChooseAction, GivesUpWhereTheTopStoneLiesAndWhereItWasMeantToLie) {
  State state = with_top_out_of_reach();
  const StoneEstimate& top = state.world.stack.back();
  const auto record = std::find_if(state.memory.records.begin(), state.memory.records.end(),
                                   [&](const auto& r) { return r.planned.stone == top.stone; });
  ASSERT_NE(record, state.memory.records.end());
  record->planned.T_W_O.translation().x() += 0.05;
  const auto gives_up = [&](const Pose& T_W_O) {
    const Decision decision = decide(state);
    return std::any_of(decision.memory.given_up.begin(), decision.memory.given_up.end(), [&](const auto& up) {
      return up.stone == top.stone && difference(up.T_W_O, T_W_O).translation < 1e-6;
    });
  };
  EXPECT_TRUE(gives_up(top.T_W_O_at_rest));
  EXPECT_TRUE(gives_up(record->planned.T_W_O));
  record->outcome = PlacementRecord::Outcome::kUnstacked;
  EXPECT_FALSE(gives_up(record->planned.T_W_O));
}

TEST(StateFile, IsReadAsItWasWritten) {
  for (const char* name : {"place", "reorient", "clear_base", "unstack", "stop"}) {
    const State state = read(name);
    const std::string path = test::temporary_folder() + "state_again.json";
    write_state(path, state.world, state.memory, models(), state.options);
    const State again = read_state(path, limestones());
    ASSERT_EQ(again.world.stack.size(), state.world.stack.size());
    for (std::size_t i = 0; i < again.world.stack.size(); ++i) {
      EXPECT_EQ(again.world.stack[i].stone, state.world.stack[i].stone);
      EXPECT_LT(difference(again.world.stack[i].T_W_O_seen, state.world.stack[i].T_W_O_seen).translation,
                1e-12);
    }
    write_state(path + ".2", again.world, again.memory, models(), again.options);
    const auto rounded = [](const std::string& file) {  // whose last digits may differ
      nlohmann::json flat = nlohmann::json::parse(read_file(file, 1 << 24)).flatten();
      for (auto& value : flat)
        if (value.is_number_float()) value = std::round(1e9 * value.get<double>());
      return flat;
    };
    EXPECT_EQ(rounded(path), rounded(path + ".2"));
    EXPECT_DOUBLE_EQ(again.options.search.min_margin, state.options.search.min_margin);
    std::filesystem::remove(path);
    std::filesystem::remove(path + ".2");
  }
}

TEST(StateFile, KeepsWhatIsNoStoneAndWhatWasModelledAnew) {
  State state = read("place");
  state.memory.awaited = {2_stone};
  state.memory.disproved = {1_stone};
  state.memory.modelled_anew = 3;
  state.memory.p_W_objects = {{0.4, -0.1}};
  const std::string path = test::temporary_folder() + "state_modelled.json";
  write_state(path, state.world, state.memory, models(), state.options);
  const State again = read_state(path, limestones());
  EXPECT_EQ(again.memory.awaited, state.memory.awaited);
  EXPECT_EQ(again.memory.disproved, state.memory.disproved);
  EXPECT_EQ(again.memory.modelled_anew, state.memory.modelled_anew);
  ASSERT_EQ(again.memory.p_W_objects.size(), 1U);
  EXPECT_LT((again.memory.p_W_objects[0] - state.memory.p_W_objects[0]).norm(), 1e-12);
  std::filesystem::remove(path);
}

TEST(StateFile, KeepsWhatWasComparedWithAPlan) {
  State state = read("place");
  const Decision decision = decide(state);
  const SearchResult& found = decision.memory.search->found;
  Alternative other;
  other.stone = found.best.front().stone;
  other.terms = {{"margin", 0.125}};
  other.predicted_success = 0.75;
  other.why_not = "falls too often";
  state.memory = decision.memory;
  state.memory.search->found.others = {other};
  state.memory.plan = FollowedPlan{found.best.front(), 1, 0, Route::kDirect, {other, other}};
  state.memory.plan->placement.then_compared = {{other}, {}};
  const std::string path = test::temporary_folder() + "state_compared.json";
  write_state(path, state.world, state.memory, models(), state.options);
  const RunMemory again = read_state(path, limestones()).memory;
  std::filesystem::remove(path);
  ASSERT_EQ(again.search->found.others.size(), 1U);
  EXPECT_EQ(again.search->found.others[0].terms, other.terms);
  ASSERT_EQ(again.plan->compared.size(), 2U);
  EXPECT_EQ(again.plan->compared[1].why_not, other.why_not);
  EXPECT_EQ(again.plan->compared[1].predicted_success, 0.75);
  ASSERT_EQ(again.plan->placement.then_compared.size(), 2U);
  EXPECT_EQ(again.plan->placement.then_compared[0][0].stone, other.stone);
}

TEST(StateFile, AFileThatIsNoStateIsRefusedByName) {
  const std::string path = test::temporary_folder() + "no_state.json";
  for (const char* text :
       {"", "{}", "[1]", R"({"schema": "stonestack.run/1"})", R"({"schema": "stonestack.state/1"})"}) {
    write_file(path, text);
    EXPECT_THROW(static_cast<void>(read_state(path, limestones())), FileError) << text;
  }
  EXPECT_THROW(static_cast<void>(read_state(path + ".gone", limestones())), FileError);
  std::filesystem::remove(path);
}

}  // namespace
}  // namespace stonestack::stacking
