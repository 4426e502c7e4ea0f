#include "stacking/model_field.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/quantile.hpp"
#include "geometry/convex_pieces.hpp"
#include "geometry/surface_tree.hpp"
#include "motion/collision.hpp"
#include "motion/regrasp.hpp"
#include "rooms.hpp"
#include "stacking/arrangement.hpp"
#include "stacking/survey.hpp"
#include "stacking/turn_stone.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/simulation/simulated_cell.hpp"
#include "stonestack/stone/catalogue.hpp"

namespace stonestack::stacking {
namespace {

using namespace report;

/// A UR10 over a field with one stone, without errors.
struct IdealCell {
  Catalogue catalogue = read_catalogue(data_path("stones"));
  RobotModel robot = read_robot("ur10");
  SimulatedCell world{catalogue.stones, {StoneIndex(0)}, robot, CellLayout{}, options_of_cell("ideal")};
  Cell cell = world.cell();

  [[nodiscard]] Eigen::Vector3d middle() const {
    return {cell.layout.field_centre.x(), cell.layout.field_centre.y(), 0.04};
  }
  [[nodiscard]] PlanningScene scene() const { return make_planning_scene(cell.layout, robot, {}, {}); }
};

TEST(Survey, EachViewShowsWhatTheOnesBeforeDidNot) {
  IdealCell in;
  const Eigen::Vector3d p_W = in.middle();
  const auto views = survey(in.cell, in.scene(), dome_over(p_W), p_W, 4, 0.55, {});
  ASSERT_EQ(views.size(), 4U);
  for (std::size_t a = 0; a < views.size(); ++a) {
    const Eigen::Vector3d axis = views[a].view.T_W_C.linear().col(2);
    const Eigen::Vector3d to_target = (p_W - views[a].view.T_W_C.translation()).normalized();
    EXPECT_GT(axis.dot(to_target), 0.999) << "the camera looks at the field";
    for (std::size_t b = 0; b < a; ++b)
      EXPECT_LT(axis.dot(views[b].view.T_W_C.linear().col(2)), std::cos(0.5)) << a << " and " << b;
  }
}

// Models weigh what a view tells of surface by the square of the cosine, and count it as seen from 0.15 to
// 0.3 on, by the distance.
TEST(Survey, SixViewsShowAllUprightSides) {
  IdealCell in;
  const Eigen::Vector3d p_W = in.middle();
  const auto views = survey(in.cell, in.scene(), dome_over(p_W), p_W, 6, 0.55, {});
  for (double azimuth = 0.0; azimuth < 6.28; azimuth += 0.1) {
    const Eigen::Vector3d n_W(std::cos(azimuth), std::sin(azimuth), 0.0);
    double told = 0.0;
    for (const SurveyView& taken : views)
      told += std::pow(std::max(0.0, -n_W.dot(taken.view.T_W_C.linear().col(2))), 2);
    EXPECT_GT(told, 0.4) << "the side towards " << azimuth << " rad";
  }
}

TEST(Survey, NothingThatIsWantedNeedsNoMoreThanOneLook) {
  IdealCell in;
  const Eigen::Vector3d p_W = in.middle();
  const std::vector<SurfaceElement> top{{p_W, Eigen::Vector3d::UnitZ(), 1.0}};
  EXPECT_EQ(survey(in.cell, in.scene(), top, p_W, 4, 0.55, {}).size(), 1U);
}

/// Two stones that are modelled in a cell with moderate errors.
struct TwoStones {
  static constexpr double kMovedApart = 0.06;  // m
  Catalogue catalogue = read_catalogue(data_path("stones"));
  std::vector<StoneIndex> present{StoneIndex(1), StoneIndex(3)};
  std::vector<Pose> T_W_O_first;  ///< true
  std::vector<Pose> T_W_O_last;
  ModelledField field;

  explicit TwoStones(const Catalogue& known = {}) {
    const RobotModel robot = read_robot("ur10");
    SimulationOptions simulation = options_of_cell("mild");
    simulation.seed = 5;
    SimulatedCell world(catalogue.stones, present, robot, CellLayout{}, simulation);
    T_W_O_first = world.truth().T_W_O;
    // Further apart, so that neither falls or rolls against the other.
    const Eigen::Vector3d between =
        at(T_W_O_first, present[0]).translation() - at(T_W_O_first, present[1]).translation();
    Pose& T_W_O = at(T_W_O_first, present[0]);
    T_W_O.pretranslate(kMovedApart * Eigen::Vector3d(between.x(), between.y(), 0.0).normalized());
    world.place(present[0], T_W_O);
    Cell cell = world.cell();
    ModelFieldOptions options;
    options.known = &known;
    field = model_field(cell, robot, options);
    T_W_O_last = world.truth().T_W_O;
  }
  /// The stone that a model is of: the one that lay, or lies, nearest.
  [[nodiscard]] StoneIndex stone_of(const ModelledStone& made) const {
    const Pose& T_W_O = made.T_W_O_first ? *made.T_W_O_first : *made.T_W_O;
    const auto distance = [&](StoneIndex stone) {
      const Pose& is = at(made.T_W_O_first ? T_W_O_first : T_W_O_last, stone);
      return (is.translation() - T_W_O.translation()).norm();
    };
    return distance(present[0]) < distance(present[1]) ? present[0] : present[1];
  }
  /// Median distance of a model's surface from the true stone, pose and shape together [m].
  [[nodiscard]] double off(const Stone& model, StoneIndex is, const Pose& T_W_O_true,
                           const Pose& T_W_O) const {
    const SurfaceTree truth(catalogue[is].scan);
    std::vector<double> off;
    for (const auto& v : model.scan.vertices)
      off.push_back(std::abs(truth.nearest(T_W_O_true.inverse() * T_W_O * v).distance));
    return quantile(off, 0.5);
  }
};

// Whether a stone falls over as planned hangs on the last digits, so nothing here does.
TEST(ModelField, StonesThatNobodyScannedAreModelledTurnedAndWeighed) {
  const TwoStones in;
  EXPECT_EQ(in.field.stopped, "");
  ASSERT_EQ(in.field.stones.size(), 2U);
  ASSERT_EQ(in.field.catalogue.stones.size(), 2U);
  EXPECT_LT(in.field.apart_after, in.field.apart_before + 1e-9);
  for (std::size_t k = 0; k < 2; ++k) {
    const ModelledStone& made = in.field.stones[k];
    const Stone& model = in.field.catalogue.stones[k];
    SCOPED_TRACE(made.name + ": " + made.note);
    ASSERT_TRUE(made.T_W_O_first || made.T_W_O);
    const StoneIndex is = in.stone_of(made);
    EXPECT_EQ(made.name, model.name);
    EXPECT_TRUE(is_closed(model.scan));
    EXPECT_GT(made.seen_share, made.turned ? 0.55 : 0.4);
    if (made.T_W_O_first) {
      EXPECT_LT(in.off(model, is, at(in.T_W_O_first, is), *made.T_W_O_first), 0.004);
    }
    if (made.T_W_O) {
      EXPECT_LT((at(in.T_W_O_last, is).translation() - made.T_W_O->translation()).norm(), 0.012);
      EXPECT_LT(in.off(model, is, at(in.T_W_O_last, is), *made.T_W_O), 0.004);
    }
    EXPECT_TRUE(made.T_W_O || !made.note.empty());
    ASSERT_TRUE(made.mass.has_value());
    EXPECT_NEAR(*made.mass / in.catalogue[is].mass.mass, 1.0, 0.05);
  }
}

TEST(ModelField, StonesThatAreKnownAreRecognisedAndLeftAsTheyLie) {
  Catalogue known;
  const Catalogue all = read_catalogue(data_path("stones"));
  known.stones = {all[1_stone], all[5_stone]};
  known.stones[1].name = "stone_7";  // which is not there
  const TwoStones in(known);
  EXPECT_EQ(in.field.stopped, "");
  ASSERT_EQ(in.field.stones.size(), 2U);
  const ModelledStone& recognised = in.field.stones[0];
  EXPECT_TRUE(recognised.known);
  EXPECT_EQ(recognised.name, all[1_stone].name);
  EXPECT_EQ(in.field.catalogue.stones[0].scan.vertices, all[1_stone].scan.vertices);
  EXPECT_FALSE(recognised.mass.has_value()) << "it was not lifted";
  ASSERT_TRUE(recognised.T_W_O && recognised.T_W_O_first);
  EXPECT_LT(in.off(all[1_stone], 1_stone, at(in.T_W_O_last, 1_stone), *recognised.T_W_O), 0.002);
  EXPECT_LT(difference(at(in.T_W_O_first, 1_stone), at(in.T_W_O_last, 1_stone)).translation, 0.001);
  EXPECT_FALSE(in.field.stones[1].known);
  EXPECT_EQ(in.field.stones[1].name, "stone_8") << "no name of a known stone, there or not";
  EXPECT_TRUE(in.field.stones[1].mass.has_value());
}

/// A stone as it rests, of which the upper half was seen.
StoneCandidate seen_from_above(const Stone& stone) {
  StoneCandidate candidate;
  candidate.stone = stone;
  candidate.stone.T_O_file = Pose::Identity();
  candidate.T_W_O = Pose(rest_poses(stone).front().R_W_O);
  candidate.model.mesh = stone.scan;
  double seen = 0.0;
  for (const Eigen::Vector3d& n : vertex_normals(stone.scan)) {
    candidate.model.seen.push_back((candidate.T_W_O.linear() * n).z() > 0.0 ? 1 : 0);
    seen += candidate.model.seen.back();
  }
  candidate.model.sigma.assign(candidate.model.seen.size(), 0.001);
  candidate.model.seen_share = seen / static_cast<double>(candidate.model.seen.size());
  return candidate;
}

// Upside down it would show all that is unseen, and share too little with what was seen to be joined with it.
TEST(WaysToShow, ASideThatCanBeJoinedComesBeforeOneThatShowsMore) {
  int chosen = 0;  // the side that can be joined, where the stone could be turned upside down, too
  for (const Stone& stone : read_catalogue(data_path("stones")).stones) {
    const StoneCandidate candidate = seen_from_above(stone);
    std::vector<double> turned;  // rad, from upwards now to upwards then
    for (const TurnTo& way : ways_to_show(candidate))
      turned.push_back(std::acos(
          std::clamp((way.R_W_O_rest * (candidate.T_W_O.linear().transpose() * Eigen::Vector3d::UnitZ())).z(),
                     -1.0, 1.0)));
    ASSERT_FALSE(turned.empty()) << stone.name;
    const bool upside_down = std::any_of(turned.begin(), turned.end(), [](double by) { return by > 2.6; });
    chosen += upside_down && turned.front() < 2.3 ? 1 : 0;
  }
  EXPECT_GE(chosen, 3);
}

TEST(WaysToShow, AWayThatMayFallBackComesLast) {
  const Stone flat = model_stone(make_box({0.14, 0.10, 0.04}), "flat", "a test", {}).stone;
  const auto ways = ways_to_show(seen_from_above(flat));
  const auto is_certain = [](const TurnTo& way) { return way.certain; };
  EXPECT_TRUE(std::is_partitioned(ways.begin(), ways.end(), is_certain));
  ASSERT_FALSE(ways.empty());
  EXPECT_TRUE(ways.front().certain);
  EXPECT_FALSE(ways.back().certain);
}

TEST(WaysToShow, AWayThatWasTriedIsNotTriedAgain) {
  StoneCandidate candidate = seen_from_above(read_catalogue(data_path("stones"))[0_stone]);
  const auto ways = ways_to_show(candidate);
  ASSERT_FALSE(ways.empty());
  const Eigen::Vector3d up = ways.front().R_W_O.conjugate() * Eigen::Vector3d::UnitZ();
  candidate.up_tried.push_back(up);
  for (const TurnTo& way : ways_to_show(candidate))
    EXPECT_GT(std::acos(std::clamp(up.dot(way.R_W_O.conjugate() * Eigen::Vector3d::UnitZ()), -1.0, 1.0)),
              0.29);
}

TEST(ModelField, AStoneThatNoGraspTurnsIsWeighed) {
  Mesh corners;  // of a low frustum
  for (const double x : {-1.0, 1.0})
    for (const double y : {-1.0, 1.0}) {
      corners.vertices.emplace_back(0.050 * x, 0.070 * y, 0.0);
      corners.vertices.emplace_back(0.045 * x, 0.065 * y, 0.024);
    }
  const Stone low = model_stone(convex_hull(corners), "low", "a test", {}).stone;
  SimulationOptions simulation = options_of_cell("ideal");
  simulation.seed = 3;
  SimulatedCell world({low}, {0_stone}, read_robot("ur10"), CellLayout{}, simulation);
  Cell cell = world.cell();
  const ModelledField field = model_field(cell, read_robot("ur10"));
  ASSERT_EQ(field.stones.size(), 1U);
  EXPECT_FALSE(field.stones[0].turned);
  EXPECT_EQ(field.stones[0].note, "no grasp sets it down on another side");
  ASSERT_TRUE(field.stones[0].mass.has_value());
  EXPECT_NEAR(*field.stones[0].mass / low.mass.mass, 1.0, 0.05);
  ASSERT_TRUE(field.stones[0].T_W_O.has_value());
  EXPECT_LT((field.stones[0].T_W_O->translation() - world.truth().T_W_O[0].translation()).norm(), 0.01);
}

/// Notes how near a motion comes to the site.
class WatchedArm : public Arm {
 public:
  WatchedArm(Arm& arm, const PlanningScene& with_site) : arm_(arm), checker_(with_site) {}

  [[nodiscard]] ArmState state() override { return arm_.state(); }
  [[nodiscard]] MotionResult follow(const JointTrajectory& trajectory) override {
    watch(trajectory);
    return arm_.follow(trajectory);
  }
  [[nodiscard]] MotionResult follow_guarded(const GuardedMotion& motion) override {
    watch(motion.trajectory);
    return arm_.follow_guarded(motion);
  }
  void stop() override { arm_.stop(); }
  void set_payload(double mass, const Eigen::Vector3d& p_F_com) override { arm_.set_payload(mass, p_F_com); }

  [[nodiscard]] int entered() const { return entered_; }
  [[nodiscard]] int motions() const { return motions_; }

 private:
  void watch(const JointTrajectory& trajectory) {
    ++motions_;
    entered_ += std::any_of(trajectory.q.begin(), trajectory.q.end(), [&](const Joints& q) {
      return checker_.clearance(q).distance < -0.005;  // m
    });
  }

  Arm& arm_;
  CollisionChecker checker_;
  int motions_ = 0, entered_ = 0;
};

/// The views show the field alone, and stones near the site are turned and seen from above.
TEST(ModelField, NothingEntersTheSiteAsLongAsNobodyHasSeenIt) {
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  const RobotModel robot = read_robot("ur10");
  CellLayout layout;
  layout.site = {0.70, 0.24};
  SimulatedCell world(catalogue.stones, {1_stone}, robot, layout, options_of_cell("ideal"));
  Pose T_W_O = world.truth().T_W_O[1];
  T_W_O.translation().head<2>() = Eigen::Vector2d(0.72, 0.03);
  world.place(1_stone, T_W_O);
  Cell real = world.cell();
  PlanningScene site = make_planning_scene(real.layout, robot, {}, {});
  site.table_z = -1.0;
  site.objects = {unseen_site(real.layout)};
  WatchedArm arm(real.arm, site);
  Cell cell{arm, real.gripper, real.force_torque, real.camera, real.clock, real.layout};
  ModelFieldOptions options;
  options.first_views = 3;
  const ModelledField field = model_field(cell, robot, options);
  EXPECT_EQ(field.stopped, "");
  EXPECT_EQ(field.stones.size(), 1U);
  EXPECT_GT(arm.motions(), 10);
  EXPECT_EQ(arm.entered(), 0);
}

TEST(ModelField, ThingsTooLightForStoneAreNone) {
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  SimulationOptions simulation = options_of_cell("ideal");
  simulation.foreign_objects = 1;  // of wood's density
  simulation.seed = 5;
  SimulatedCell world(catalogue.stones, {1_stone}, read_robot("ur10"), CellLayout{}, simulation);
  Cell cell = world.cell();
  const ModelledField field = model_field(cell, read_robot("ur10"));
  ASSERT_EQ(field.stones.size(), 1U);
  ASSERT_EQ(field.catalogue.stones.size(), 1U);
  EXPECT_NEAR(*field.stones[0].mass, catalogue[1_stone].mass.mass, 0.1);
  ASSERT_EQ(field.left_out.size(), 1U);
  EXPECT_NE(field.left_out[0].find("kg/m^3: no stone"), std::string::npos) << field.left_out[0];
}

TEST(ModelField, FewPointsHaveAHull) {
  detection::Cloud cloud;
  for (const double x : {0.3, 0.3, 0.304}) {
    cloud.points.emplace_back(x, 0.1, 0.02);
    const Mesh hull = hull_to_table(cloud, Pose::Identity());
    EXPECT_GT(volume(hull), 0.0);
    const Eigen::AlignedBox3d box = bounds(hull);
    EXPECT_NEAR(box.max().z(), 0.02, 1e-6);
    EXPECT_NEAR(box.min().z(), 0.0, 1e-9);
  }
}

TEST(ModelField, NamesGoOnAfterThoseThatAreTaken) {
  EXPECT_EQ(modelled_name({}), "stone_1");
  EXPECT_EQ(modelled_name({"stone_2", "limestone_9", "stone_x", "stone_12b", "my_stone_40"}), "stone_3");
}

TEST(ModelField, AnEmptyFieldGivesNoStone) {
  const Catalogue catalogue = read_catalogue(data_path("stones"));
  const RobotModel robot = read_robot("ur10");
  SimulatedCell world(catalogue.stones, {}, robot, CellLayout{}, options_of_cell("ideal"));
  Cell cell = world.cell();
  ModelFieldOptions options;
  options.first_views = 2;
  const ModelledField field = model_field(cell, robot, options);
  EXPECT_TRUE(field.catalogue.stones.empty());
  EXPECT_EQ(field.views, 2);
}

}  // namespace
}  // namespace stonestack::stacking
