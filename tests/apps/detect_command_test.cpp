// What `stonestack detect` makes of the files that people have, right and wrong.
#include <cmath>
#include <set>
#include <tuple>

#include "commands.hpp"
#include "stonestack/geometry/cloud.hpp"

namespace stonestack {
namespace {

/// Two stones on a table, rendered, and its cloud in every frame and unit that a user may have it in.
class DetectCommand : public Commands {
 protected:
  void SetUp() override {
    Commands::SetUp();
    ASSERT_EQ(run("render --out scene --seed 3 --stones limestone_1,limestone_4").code, 0);
    cloud_ = read_cloud(folder_ + "/scene/cloud.ply");
    heap_ = without_gaps(cloud_);
  }
  template <class Change>
  void write_changed(const std::string& name, Cloud cloud, const Change& change) const {
    for (auto& p : cloud.points) p = change(p);
    write_cloud(folder_ + "/" + name, cloud);
  }
  void write_points(const std::string& name, std::vector<Eigen::Vector3f> points) const {
    Cloud cloud;
    cloud.width = static_cast<int>(points.size());
    cloud.height = 1;
    cloud.points = std::move(points);
    write_cloud(folder_ + "/" + name, cloud);
  }

  Cloud cloud_, heap_;
};

TEST_F(DetectCommand, TakesACloudAsTheCameraSeesItButNotItsMirrorImage) {
  const auto mirrored = [](const Eigen::Vector3f& p) { return Eigen::Vector3f(-p.x(), p.y(), p.z()); };
  write_cloud(folder_ + "/heap.ply", heap_);
  const Outcome found = run("detect heap.ply --json");
  EXPECT_EQ(found.code, 0) << found.err;
  EXPECT_EQ(found.data()["detections"].size(), 2u) << "a cloud without rows is in the camera frame, too";
  write_changed("mirror.ply", cloud_, mirrored);
  expect_refusal("detect mirror.ply", 3, {"mirror.ply", "mirrored"});
  write("mirror.yaml", "schema: stonestack.scene/1\ncloud: mirror.ply\n");
  expect_refusal("detect mirror.yaml", 3, {"mirror.ply", "mirrored"});
  write_changed("mirrored_heap.ply", heap_, mirrored);
  EXPECT_EQ(run("detect mirrored_heap.ply").code, 4);
}

TEST_F(DetectCommand, AsksForTheUnitOfMillimetresAndTakesThem) {
  write_changed("mm.ply", heap_, [](const Eigen::Vector3f& p) { return Eigen::Vector3f(1000 * p); });
  const Outcome large = run("detect mm.ply");
  EXPECT_EQ(large.code, 4);
  EXPECT_THAT(large.err, HasSubstr("the middle one is 6")) << "names the depth";
  EXPECT_THAT(large.err, HasSubstr("millimetres? (--units"));
  EXPECT_EQ(run("detect mm.ply --units mm --json").data()["detections"].size(), 2u);
}

TEST_F(DetectCommand, TakesAThinnedCloud) {
  std::set<std::tuple<int, int, int>> cells;  // one point each 3 mm, as a voxel filter leaves them
  std::vector<Eigen::Vector3f> thin;
  const auto cell = [](float x) { return static_cast<int>(std::floor(x / 0.003F)); };
  for (const auto& p : heap_.points)
    if (cells.emplace(cell(p.x()), cell(p.y()), cell(p.z())).second) thin.push_back(p);
  write_points("thin.ply", thin);
  const Outcome found = run("detect thin.ply --json");
  EXPECT_EQ(found.data()["detections"].size(), 2u) << found.err;
}

TEST_F(DetectCommand, ReportsThatPointsMakeNoSurface) {
  std::vector<Eigen::Vector3f> dust;
  for (int i = 0; i < 3000; ++i)
    dust.emplace_back(0.1F * std::sin(1.7F * i), 0.1F * std::cos(2.3F * i), 0.7F + 0.2F * std::sin(3.1F * i));
  write_points("dust.ply", dust);
  expect_refusal("detect dust.ply -q", 4, {"dust.ply", "on a surface"});
  write_points("one.ply", {{0.0F, 0.0F, 0.7F}});
  expect_refusal("detect one.ply -q", 4, {"one.ply", "of 1 the middle one is 0.7 m"});
}

TEST_F(DetectCommand, RefusesAFrameThatIsNeitherTheCamerasNorTheWorlds) {
  write_changed("forward.ply", heap_, [](const Eigen::Vector3f& p) {  // x forward, z up, as ROS's base has it
    return Eigen::Vector3f(p.z(), -p.x(), -p.y());
  });
  expect_refusal("detect forward.ply -q", 3, {"forward.ply", "behind the camera", "optical frame"});
  expect_refusal("detect forward.ply --world -q", 3, {"forward.ply", "leans", "optical frame"});
}

TEST_F(DetectCommand, PlacesStonesOfAWorldCloudInTheWorld) {
  const Outcome scene = run("render --out world --seed 3 --stones limestone_1 --json");
  const Pose T_W_C = pose_of(scene.data()["T_W_C"]);
  write_changed("world.ply", without_gaps(read_cloud(folder_ + "/world/cloud.ply")),
                [&](const Eigen::Vector3f& p) { return Eigen::Vector3f(T_W_C.cast<float>() * p); });
  const Outcome found = run("detect world.ply");
  EXPECT_EQ(found.code, 0) << found.err;
  EXPECT_THAT(found.out, HasSubstr("position in the world frame"));
  const auto at = found.out.find("limestone_1");
  ASSERT_NE(at, std::string::npos);
  double score = 0, inliers = 0, visible = 0, x = 0, y = 0, z = 0;
  ASSERT_EQ(std::sscanf(found.out.c_str() + at, "limestone_1 %lf %lf %lf %lf %lf %lf", &score, &inliers,
                        &visible, &x, &y, &z),
            6);
  const Pose truth = pose_of(scene.data()["stones"][0]["T_W_O"]);
  EXPECT_LT((Eigen::Vector3d(x, y, z) - truth.translation()).norm(), 0.003);
}

TEST_F(DetectCommand, UsesEveryOptionOrRefusesIt) {
  expect_refusal("detect scene/cloud.ply --depth-unit 0.001", 2, {"cloud.ply", "--depth-unit"});
  expect_refusal("detect scene/scene.yaml --distortion brown_conrady:0,0,0,0,0", 2, {"scene.yaml"});
  expect_refusal("detect scene/scene.yaml --units mm", 2, {"scene.yaml", "--units"});
  expect_refusal("detect scene/depth.png --camera 475,475,319.5,239.5 --depth-unit 0.000125 --frame 2", 2,
                 {"depth.png", "--frame"});
  fs::create_directories(folder_ + "/open3d/depth");
  fs::copy_file(folder_ + "/scene/depth.png", folder_ + "/open3d/depth/1.png");
  write("open3d/camera_intrinsic.json", R"({"intrinsic_matrix": [475, 0, 0, 0, 475, 0, 319.5, 239.5, 1]})");
  const auto depth_of = [&](const std::string& lens) -> Eigen::Vector3d {
    const Outcome found = run("detect open3d --depth-unit 0.000125 --json --stones limestone_1 " + lens);
    EXPECT_EQ(found.code, 0) << found.err;
    return pose_of(found.data()["detections"][0]["T_C_O"]).translation();
  };
  const double off =
      (depth_of("--distortion inverse_brown_conrady:0.1,0.2,0.003,0.003,-0.1") - depth_of("")).norm();
  EXPECT_GT(off, 2e-4) << "the lens of a recording that names only the pinhole";
}

TEST_F(DetectCommand, RefusesACameraOfWhichTheImageIsNot) {
  expect_refusal("detect scene/depth.png --camera 475,475,1e9,239.5 --depth-unit 0.000125", 3,
                 {"depth.png", "640 x 480", "fx,fy,cx,cy"});
  expect_refusal("detect scene/depth.png --camera 475,475,319.5,-400 --depth-unit 0.000125", 3, {"-400"});
}

TEST_F(DetectCommand, JoinsSeveralViewsOfWhichItKnowsTheCameraPoses) {
  const Outcome other = run("render --out other --seed 3 --stones limestone_1,limestone_4 --tilt 35 --json");
  ASSERT_EQ(other.code, 0) << other.err;
  const Outcome found = run("detect scene/scene.yaml other/scene.yaml --json");
  ASSERT_EQ(found.data()["detections"].size(), 2u) << found.err;
  EXPECT_NE(found.data()["detections"], run("detect scene/scene.yaml --json").data()["detections"]);
  const auto truth = other.data()["stones"];
  const json found_data = found.data();
  for (const auto& d : found_data["detections"]) {
    const bool first = truth[0]["stone"] == d["stone"];
    const Pose T_W_O = pose_of(truth[first ? 0 : 1]["T_W_O"]);
    EXPECT_LT(difference(pose_of(d["T_W_O"]), T_W_O).translation, 0.003) << d["stone"];
  }
  expect_refusal("detect scene/scene.yaml other/cloud.ply", 3, {"other/cloud.ply", "has no camera pose"});
  expect_refusal("detect scene/scene.yaml other/cloud.ply --camera-pose scene/scene.yaml", 2,
                 {"2 scenes and 1 poses"});
}

TEST_F(DetectCommand, TracesWhatItSawThoughItFoundNothing) {
  std::vector<Eigen::Vector3f> plane;
  for (int i = 0; i < 200; ++i)
    for (int k = 0; k < 200; ++k) plane.emplace_back(0.002F * i - 0.2F, 0.002F * k - 0.2F, 0.8F);
  write_points("table.ply", plane);
  expect_refusal("detect table.ply --trace trace -q", 4, {"nothing unknown stands on the table"});
  EXPECT_TRUE(fs::exists(folder_ + "/trace/turn_1/stages.json"));
}

TEST_F(DetectCommand, ExplainsWhyAStoneWasNotFoundAndDrawsIt) {
  const Outcome told = run("detect scene/scene.yaml --explain limestone_2,limestone_4");
  EXPECT_EQ(told.code, 0) << told.err;
  EXPECT_THAT(told.out, HasSubstr("limestone_4: found: "));
  EXPECT_THAT(told.out, HasSubstr("limestone_2: "));
  EXPECT_TRUE(fs::exists(folder_ + "/explain_limestone_4.png"));
  const Outcome data = run("detect scene/scene.yaml --explain limestone_2 --trace trace --json");
  const json explained = data.data()["explanations"][0];
  EXPECT_EQ(explained["stone"], "limestone_2");
  EXPECT_NE(explained["stage"], "found");
  EXPECT_EQ(fs::exists(folder_ + "/trace/explain_limestone_2.png"), explained.contains("best"));
  expect_refusal("detect scene/scene.yaml --explain limestone_77", 2, {"limestone_77"});
}

TEST_F(DetectCommand, TakesCountLensAndRangeOfAKnownSensor) {
  const Outcome whole =
      run("detect scene/depth.png --camera 475,475,319.5,239.5 --depth-unit 0.000125 --json");
  const Outcome named = run("detect scene/depth.png --sensor sr300 --json");
  EXPECT_EQ(named.code, 0) << named.err;
  EXPECT_THAT(named.err, HasSubstr("nominal lens of sr300"));
  EXPECT_EQ(named.data()["detections"], whole.data()["detections"]);
  std::string far = read_file(std::string(STONESTACK_SOURCE_DIR) + "/data/sensors/sr300.yaml", 1 << 20);
  far.replace(far.find("nearest: 0.2"), 12, "nearest: 1.2");  // further than the table
  write("far.yaml", far);
  const Outcome none = run("detect scene/depth.png --sensor far.yaml --json");
  EXPECT_NE(none.code, 0) << none.out;
  expect_refusal("detect scene/depth.png --sensor kinect9", 3, {"kinect9", "kinect1"});
}

TEST_F(DetectCommand, WarnsOfADepthUnitThatIsALittleOff) {
  const std::string camera = "--camera 475,475,319.5,239.5 --json --depth-unit ";
  const Outcome right = run("detect scene/depth.png " + camera + "0.000125");
  EXPECT_EQ(right.data()["note"], "") << right.out;
  const Outcome doubtful = run("detect scene/depth.png " + camera + "0.00013");
  EXPECT_EQ(doubtful.code, 0) << doubtful.err;
  EXPECT_THAT(doubtful.err, HasSubstr("depth unit"));
  EXPECT_NEAR(doubtful.data()["depth_scale"]["factor"].get<double>(), 1.04, 0.012);
  const Outcome wrong = run("detect scene/depth.png " + camera + "0.0001375");
  EXPECT_EQ(wrong.code, 4) << wrong.out;
  EXPECT_TRUE(wrong.data()["detections"].empty());
}

TEST_F(DetectCommand, ThePapersMethodIsASetOfOptionsThatOthersOverride) {
  write("stonestack.yaml", "detection: {method: paper, descriptor: shot}");  // shot is the plain default
  const auto settings = [&](const std::string& more) {
    return run("config show --expert --origin " + more).out;
  };
  EXPECT_THAT(settings(""), HasSubstr("detection.descriptor: shot  # project file"));
  EXPECT_THAT(settings(""), HasSubstr("detection.matching: kdtree  # detection.method"));
  EXPECT_THAT(settings(""), HasSubstr("detection.sweep: false  # detection.method"));
  EXPECT_THAT(settings("--set detection.descriptor=iss"),
              HasSubstr("detection.descriptor: iss  # flag --set"));
  EXPECT_THAT(settings("--set detection.method=default"), HasSubstr("detection.matching: exact  # default"));
  fs::remove(folder_ + "/stonestack.yaml");
  EXPECT_THAT(settings("--set detection.method=paper"),
              HasSubstr("detection.descriptor: rops  # detection.method"));

  const auto matches = [&](const std::string& more) {
    const std::string trace = concat("trace", std::hash<std::string>()(more));
    const Outcome found = run("detect scene/scene.yaml -q --method paper " + more + " --trace " + trace);
    EXPECT_TRUE(found.code == 0 || found.code == 4) << more << found.err;  // ISS keypoints are few
    return json::parse(read_file(folder_ + "/" + trace + "/turn_1/stages.json", 64 << 20))["matches"];
  };
  const json rops = matches("");
  EXPECT_NE(rops, matches("--set detection.descriptor=shot"));
  EXPECT_NE(rops, matches("--set detection.keypoints=iss"));
}

TEST_F(DetectCommand, RefusesAnEmptyDepthRange) {
  expect_refusal("detect scene/scene.yaml --set detection.nearest=1 --set detection.farthest=0.5", 2,
                 {"nearest", "farthest"});
}

TEST_F(DetectCommand, WarnsOfPosesThatOnlyThePapersInlierRatioAccepted) {
  write_changed("mirrored.ply", heap_,
                [](const Eigen::Vector3f& p) { return Eigen::Vector3f(-p.x(), p.y(), p.z()); });
  const Outcome found =
      run("detect mirrored.ply --method paper --set detection.accept_inlier_ratio=0.5 --json");
  const json data = found.data();
  bool doubtful = false;
  for (const auto& d : data["detections"]) doubtful = doubtful || d["score"].get<double>() < 0.85;
  ASSERT_TRUE(doubtful) << found.out;
  EXPECT_THAT(found.err, HasSubstr("says that the pose is wrong"));
}

}  // namespace
}  // namespace stonestack
