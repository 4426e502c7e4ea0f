// `stonestack search` on a cloud alone: the frame, the tower and the site that it finds, against the truth of
// the simulated scene.
#include <optional>

#include "commands.hpp"
#include "geometry/depth_render.hpp"
#include "simulation/sensor_noise.hpp"
#include "stonestack/geometry/cloud.hpp"
#include "stonestack/stone/catalogue.hpp"
#include "stonestack/stone/scene_file.hpp"

namespace stonestack::apps {
namespace {

using ::testing::Not;

/// A rendered scene of loose stones, with the truth, and its cloud stripped of everything else.
class SearchCloud : public Commands {
 protected:
  /// Renders `stones` scattered about the middle of the field.
  void scatter(const std::string& stones) {
    const Outcome scene = run("render --out scene --seed 3 --json --stones " + stones);
    ASSERT_EQ(scene.code, 0) << scene.err;
    const json data = scene.data();
    T_W_C_ = pose_of(data["T_W_C"]);
    for (const auto& item : data["stones"])
      truth_.push_back({item["stone"].get<std::string>(), pose_of(item["T_W_O"])});
    cloud_ = read_cloud(folder_ + "/scene/cloud.ply");
    fs::remove_all(folder_ + "/scene");
  }
  /// Plans a tower at (x, y) and takes the picture again with it standing there.
  void add_tower(const std::string& stones, double x, double y) {
    const Outcome planned = run(concat("search --stones ", stones, " --levels 2 --site ", x, ',', y,
                                       " --out tower.yaml --set search.rounds=1"));
    ASSERT_EQ(planned.code, 0) << planned.err;
    for (const NamedPose& item : read_scene_file(folder_ + "/tower.yaml").stack) {
      tower_.push_back(item.stone);
      truth_.push_back(item);
    }
    fs::remove(folder_ + "/tower.yaml");
    const Catalogue catalogue = read_catalogue(STONESTACK_SOURCE_DIR "/data/stones");
    RayScene world;
    world.add(make_box({3.0, 3.0, 0.02}), make_pose(Eigen::Vector3d(0.7, 0, -0.01)));
    for (const NamedPose& item : truth_) world.add(catalogue[catalogue.index(item.stone)].scan, item.T_W_O);
    world.commit();
    const SensorModel sensor = read_sensor("sr300");
    Random random = Random::stream(1, "search cloud");
    cloud_ = to_cloud(add_noise(render(world, sensor.camera, T_W_C_), T_W_C_, sensor, random));
  }
  /// A catalogue without one stone; returns the option that names it.
  [[nodiscard]] std::string catalogue_without(const std::string& stone) const {
    const std::string path = folder_ + "/without_" + stone;
    fs::copy(STONESTACK_SOURCE_DIR "/data/stones", path, fs::copy_options::recursive);
    fs::remove_all(path + "/" + stone);
    return " --catalogue " + path;
  }
  template <class Change>
  void write_changed(const std::string& name, const Cloud& cloud, const Change& change) const {
    Cloud changed = cloud;
    for (auto& p : changed.points) p = change(p);
    write_cloud(folder_ + "/" + name, changed);
  }
  [[nodiscard]] Pose truth_of(const std::string& stone) const {
    for (const NamedPose& item : truth_)
      if (item.stone == stone) return item.T_W_O;
    ADD_FAILURE() << "there is no " << stone;
    return Pose::Identity();
  }
  /// The poses of a list in the result are those of the scene, T_V_W being where its world lies in the
  /// result's.
  void expect_true_poses(const json& list, const Pose& T_V_W) const {
    for (const auto& item : list) {
      const auto off = difference(pose_of(item["T_W_O"]), T_V_W * truth_of(item["stone"]));
      EXPECT_LT(off.translation, 0.004) << item["stone"];
      EXPECT_LT(off.angle, 0.05) << item["stone"];
    }
  }
  [[nodiscard]] static std::vector<std::string> names(const json& list) {
    std::vector<std::string> result;
    for (const auto& item : list) result.push_back(item["stone"]);
    return result;
  }

  std::vector<NamedPose> truth_;
  std::vector<std::string> tower_;  ///< from the table up
  Pose T_W_C_ = Pose::Identity();
  Cloud cloud_;
};

constexpr const char* kQuick = " --set search.rounds=1 --set search.horizon=1 --json";

TEST_F(SearchCloud, FindsTheTowerInACloudAlone) {
  ASSERT_NO_FATAL_FAILURE(scatter("limestone_1,limestone_3"));
  ASSERT_NO_FATAL_FAILURE(add_tower("limestone_2,limestone_4", 0.58, -0.10));
  write_cloud(folder_ + "/scene.ply", cloud_);
  const Outcome outcome = run(concat("search scene.ply", kQuick));
  // Neither loose stone fits on this tower: no pose is proposed, least of all one on the bare table.
  ASSERT_EQ(outcome.code, 5) << outcome.err;
  const json found = outcome.data();
  EXPECT_EQ(found["frame"]["defined_by"], "table");
  EXPECT_THAT(outcome.err, HasSubstr("frame: the table that is seen is z = 0"));
  // The frame: on the table, upright, the camera above its origin.
  const Pose T_V_C = pose_of(found["frame"]["T_W_C"]), T_V_W = T_V_C * T_W_C_.inverse();
  EXPECT_GT(T_V_W.linear()(2, 2), std::cos(0.01));
  EXPECT_NEAR((T_V_W * Eigen::Vector3d(0.7, -0.18, 0)).z(), 0.0, 0.002);
  EXPECT_LT(T_V_C.translation().head<2>().norm(), 1e-9);
  // What stands on what.
  EXPECT_EQ(names(found["stack"]), tower_);
  EXPECT_THAT(names(found["loose"]), testing::ElementsAre("limestone_1", "limestone_3"));
  expect_true_poses(found["stack"], T_V_W);
  expect_true_poses(found["loose"], T_V_W);
  const Eigen::Vector3d site = T_V_W * truth_of(tower_.front()).translation();
  EXPECT_LT((Eigen::Vector2d(found["site"]["x"], found["site"]["y"]) - site.head<2>()).norm(), 0.01);
  EXPECT_TRUE(found["placements"].empty());
}

TEST_F(SearchCloud, RefusesATowerOfWhichAStoneIsNotRecognised) {
  ASSERT_NO_FATAL_FAILURE(scatter("limestone_1,limestone_3"));
  ASSERT_NO_FATAL_FAILURE(add_tower("limestone_2,limestone_4", 0.58, -0.10));
  write_cloud(folder_ + "/scene.ply", cloud_);
  const std::string base = tower_.front(), top = tower_.back();
  const auto expect_refused = [&](const std::string& catalogue, const std::vector<std::string>& parts) {
    const Outcome outcome = run("search scene.ply --json" + catalogue);
    EXPECT_EQ(outcome.code, 5) << outcome.err;
    EXPECT_EQ(outcome.out, "") << "no proposal";
    for (const std::string& part : parts) EXPECT_THAT(outcome.err, HasSubstr(part));
    EXPECT_THAT(outcome.err, Not(HasSubstr("nothing stands")));
  };
  expect_refused(catalogue_without(base), {"scene.ply: " + top, "above the table",
                                           "no stone that was recognised carries it", "--site"});
  // "on BASE" where the base was recognised below it, else where the whole of it stands
  expect_refused(catalogue_without(top), {"scene.ply: something ", "was not recognised"});
  // Neither of them: what stands there is something all the same.
  fs::remove_all(folder_ + "/without_" + base + "/" + top);
  expect_refused(" --catalogue without_" + base,
                 {"something at (", "was not recognised and may be part of a tower"});
}

TEST_F(SearchCloud, PutsTheFirstStoneOnAFreePlaceInView) {
  ASSERT_NO_FATAL_FAILURE(scatter("limestone_1,limestone_3,limestone_5"));
  write_changed("mm.ply", cloud_, [](const Eigen::Vector3f& p) { return Eigen::Vector3f(1000 * p); });
  const Outcome metres = run(concat("search mm.ply", kQuick));
  EXPECT_EQ(metres.code, 4);
  EXPECT_THAT(metres.err, HasSubstr("are these millimetres? (--units"));
  const Outcome outcome = run(concat("search mm.ply --units mm", kQuick));
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const json found = outcome.data();
  EXPECT_THAT(found["next"].get<std::string>(), HasSubstr("search mm.ply --units mm --out tower.yaml"));
  EXPECT_EQ(found["frame"]["defined_by"], "table");
  EXPECT_TRUE(found["stack"].empty());
  const Pose T_V_W = pose_of(found["frame"]["T_W_C"]) * T_W_C_.inverse();
  expect_true_poses(found["loose"], T_V_W);
  EXPECT_EQ(found["loose"].size(), 3u);
  const Eigen::Vector3d site(found["site"]["x"], found["site"]["y"], 0.0);
  const Eigen::Vector3d placed = pose_of(found["placements"][0]["T_W_O"]).translation();
  EXPECT_LT((placed - site).head<2>().norm(), 0.03);
  EXPECT_LT(placed.z(), 0.09) << "on the table";
  for (const NamedPose& item : truth_)
    EXPECT_GT((T_V_W * item.T_W_O.translation() - site).head<2>().norm(), 0.10)
        << "too near to " << item.stone;
  const Eigen::Vector3d p_C = pose_of(found["frame"]["T_W_C"]).inverse() * site;
  EXPECT_LT(std::abs(p_C.x() / p_C.z()), 0.55);
  EXPECT_LT(std::abs(p_C.y() / p_C.z()), 0.40);
  EXPECT_LT((T_V_W.inverse() * site - Eigen::Vector3d(0.7, -0.18, 0)).norm(), 0.35) << "far from the middle";
}

TEST_F(SearchCloud, RecognisesACloudInTheWorldFrame) {
  ASSERT_NO_FATAL_FAILURE(scatter("limestone_1,limestone_3"));
  ASSERT_NO_FATAL_FAILURE(add_tower("limestone_2,limestone_4", 0.58, -0.10));
  write_changed("world.ply", without_gaps(cloud_),
                [&](const Eigen::Vector3f& p) { return Eigen::Vector3f(T_W_C_.cast<float>() * p); });
  const Outcome outcome = run(concat("search world.ply", kQuick));
  ASSERT_EQ(outcome.code, 5) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("taken as in the world frame"));
  const json found = outcome.data();
  EXPECT_EQ(found["frame"]["defined_by"], "world_cloud");
  EXPECT_EQ(names(found["stack"]), tower_);
  expect_true_poses(found["stack"], Pose::Identity());
  expect_true_poses(found["loose"], Pose::Identity());
  EXPECT_NEAR(found["site"]["x"], truth_of(tower_.front()).translation().x(), 0.01);
  EXPECT_NEAR(found["site"]["y"], truth_of(tower_.front()).translation().y(), 0.01);
  // One whose table lies elsewhere is not in it.
  write_changed("high.ply", without_gaps(cloud_), [&](const Eigen::Vector3f& p) {
    return Eigen::Vector3f(T_W_C_.cast<float>() * p + 0.05F * Eigen::Vector3f::UnitZ());
  });
  expect_refusal("search high.ply", 3, {"high.ply", "its table lies at z = 0.05"});
  // An arm is asked only where its place in that frame is known.
  expect_refusal("search world.ply --robot ur10", 2, {"world.ply", "--world"});
}

TEST_F(SearchCloud, AsksNoArmWhosePlaceIsUnknown) {
  ASSERT_NO_FATAL_FAILURE(scatter("limestone_1"));
  write_cloud(folder_ + "/scene.ply", cloud_);
  expect_refusal("search scene.ply --robot ur10", 2, {"scene.ply", "--robot", "--camera-pose"});
}

TEST_F(SearchCloud, NamesTheRemedyForOpenGlsAxesBeforeAnyLongWork) {
  ASSERT_NO_FATAL_FAILURE(scatter("limestone_1"));
  const auto opengl = [](const Eigen::Vector3f& p) { return Eigen::Vector3f(p.x(), -p.y(), -p.z()); };
  write_changed("gl.ply", without_gaps(cloud_), opengl);
  write_changed("gl_rows.ply", cloud_, opengl);
  write("gl.yaml", "schema: stonestack.scene/1\ncloud: gl_rows.ply\n");
  for (const std::string command :
       {"search gl.ply", "detect gl.ply", "search gl_rows.ply", "detect gl_rows.ply", "detect gl.yaml"}) {
    expect_refusal(command, 3, {"OpenGL", "sign of y and z", "z runs from -"});
    EXPECT_THAT(read_file(folder_ + "/err", 1 << 20), Not(HasSubstr("preparing"))) << command;
  }
  // A scene further away, as PCL's tutorial has it, with z from -2.06 to -0.50.
  Cloud far;
  for (int i = 0; i < 60; ++i)
    for (int k = 0; k < 60; ++k)
      far.points.emplace_back(0.01F * i - 0.3F, 0.01F * k - 0.3F, -0.5F - 1.56F / 59 * k);
  far.width = static_cast<int>(far.points.size()), far.height = 1;
  write_cloud(folder_ + "/far.ply", far);
  expect_refusal("search far.ply", 3, {"far.ply", "z runs from -2.06 to -0.5 m", "OpenGL"});
}

TEST_F(SearchCloud, KeepsToTheBudgetFromTheFirstFileOn) {
  ASSERT_NO_FATAL_FAILURE(scatter("limestone_1"));
  write_cloud(folder_ + "/scene.ply", cloud_);
  const Outcome outcome = run("search scene.ply --budget 0.000001 --json");
  EXPECT_EQ(outcome.code, 5) << outcome.err;
  EXPECT_THAT(outcome.err, HasSubstr("the time was over"));
  EXPECT_THAT(outcome.err, Not(HasSubstr("frame:"))) << "it went on to the view";
  const json found = outcome.data();
  EXPECT_TRUE(found["placements"].empty());
  EXPECT_THAT(found["reason"].get<std::string>(), HasSubstr("the time was over"));
  EXPECT_FALSE(found["repeatable"].get<bool>());
}

}  // namespace
}  // namespace stonestack::apps
