#include <cmath>
#include <numbers>
#include <sstream>
#include <utility>

#include "bench_command.hpp"
#include "geometry/depth_render.hpp"
#include "stonestack/geometry/mesh.hpp"

namespace stonestack::bench {
namespace {

/// Rotation by rows and translation in mm.
std::pair<json, json> bop_pose(const Pose& T) {
  json R = json::array(), t = json::array();
  for (int i = 0; i < 9; ++i) R.push_back(T.linear()(i / 3, i % 3));
  for (int i = 0; i < 3; ++i) t.push_back(1000 * T.translation()(i));
  return {R, t};
}

/// The rendered scene and the stones in it as a data set of the BOP layout, in millimetres.
json write_bop(const std::string& folder, const json& rendered) {
  json truth = json::array();
  for (const json& stone : rendered["stones"]) {
    const std::string name = stone["stone"];
    const int id = name.back() - '0';
    const Mesh mesh = read_mesh(concat(STONESTACK_SOURCE_DIR, "/data/stones/", name, "/mesh.ply"));
    write_mesh(concat(folder, "/bop/models/obj_00000", id, ".ply"), scaled(mesh, 1000));
    const auto [R, t] = bop_pose(pose_of(stone["T_C_O"]));
    truth.push_back({{"obj_id", id}, {"cam_R_m2c", R}, {"cam_t_m2c", t}});
  }
  const std::string scene = folder + "/bop/test/000002";
  fs::create_directories(scene + "/depth");
  fs::copy_file(folder + "/scene/depth.png", scene + "/depth/000007.png");
  const json camera = {{"cam_K", {475, 0, 319.5, 0, 475, 239.5, 0, 0, 1}}, {"depth_scale", 0.125}};
  write_file(scene + "/scene_camera.json", json{{"7", camera}}.dump());
  write_file(scene + "/scene_gt.json", json{{"7", truth}}.dump());
  return truth;
}

TEST_F(BenchCommand, ScoresADataSetOfTheBopLayout) {
  const Outcome rendered =
      run_stonestack("render --out scene --seed 3 --stones limestone_1,limestone_4 --json");
  ASSERT_EQ(rendered.code, 0) << rendered.err;
  const json truth = write_bop(folder_, rendered.data());
  write("bop/models/models_info.json", R"({"1": {"diameter": 120.0}, "4": {}})");
  const Outcome scored = run("detection --bop bop --bop-csv results.csv --json");
  ASSERT_EQ(scored.code, 0) << scored.err;
  const json all = rows_of(scored.data(), "true poses found by default").back();
  EXPECT_EQ(all["object"], "all");
  EXPECT_EQ(all["present"], 2);
  EXPECT_EQ(all["within_5_deg_5_mm"], 2);
  EXPECT_EQ(all["mssd_recall_percent"], 100.0);
  EXPECT_EQ(all["mspd_recall_percent"], 100.0);
  EXPECT_EQ(all["add_s_recall_percent"], 100.0);
  EXPECT_EQ(all["add_s_below_5_mm"], 2);
  EXPECT_EQ(all["reported_where_absent"], 0);
  std::istringstream lines(read_file(folder_ + "/results.csv", 1 << 20));
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line, "scene_id,im_id,obj_id,score,R,t,time");
  int count = 0;
  for (; std::getline(lines, line); ++count) {
    int scene = 0, image = 0, object = 0;
    double score = 0, R[9], t[3];
    ASSERT_EQ(std::sscanf(line.c_str(), "%d,%d,%d,%lf,%lf %lf %lf %lf %lf %lf %lf %lf %lf,%lf %lf %lf,",
                          &scene, &image, &object, &score, R, R + 1, R + 2, R + 3, R + 4, R + 5, R + 6, R + 7,
                          R + 8, t, t + 1, t + 2),
              16)
        << line;
    EXPECT_EQ(scene, 2);
    EXPECT_EQ(image, 7);
    const json& there = truth[object == truth[0]["obj_id"] ? 0 : 1];
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(t[i], there["cam_t_m2c"][i].get<double>(), 2.0) << "mm";
    for (int i = 0; i < 9; ++i) EXPECT_NEAR(R[i], there["cam_R_m2c"][i].get<double>(), 0.04);
  }
  EXPECT_EQ(count, 2);
  const auto without_the_first = [&] {
    write("bop/test/000002/scene_gt.json", json{{"7", {truth[1]}}}.dump());
    return rows_of(run("detection --bop bop --json").data(), "true poses found by default").back();
  };
  EXPECT_EQ(without_the_first()["reported_where_absent"], 1) << "it is there, and the truth says otherwise";
  write("bop/test/000002/present_without_pose.json", json{{"7", {truth[0]["obj_id"]}}}.dump());
  EXPECT_EQ(without_the_first()["reported_where_absent"], 0) << "it counts neither for nor against";
  write("bop/test/000002/present_without_pose.json", R"({"7": ["one"]})");
  expect_refusal("detection --bop bop", 3, {"present_without_pose.json", "image 7"});
  fs::remove(folder_ + "/bop/test/000002/present_without_pose.json");
  write("bop/test/000002/scene_gt.json", json{{"7", truth}}.dump());
  write("bop/test_targets_bop19.json", R"([{"scene_id": 2, "im_id": 7, "obj_id": 4, "inst_count": 1}])");
  const json of_target = run("detection --bop bop --json").data();
  EXPECT_EQ(rows_of(of_target, "default")[0]["images"], 1);
  EXPECT_EQ(rows_of(of_target, "default")[0]["detections"], 1);
  EXPECT_EQ(rows_of(of_target, "true poses found by default").back()["present"], 1)
      << "the other is no target";
  EXPECT_EQ(run("detection --bop bop --bop-csv own_bop-test.csv --methods paper,default").code, 0);
  EXPECT_TRUE(fs::exists(folder_ + "/paper-own_bop-test.csv"));
  EXPECT_TRUE(fs::exists(folder_ + "/default-own_bop-test.csv"));
  expect_refusal("detection --bop bop --bop-split train", 3, {"bop/train", "--bop-split"});
  expect_refusal("detection --bop nowhere", 3, {"nowhere/models"});
  write("bop/test_targets_bop19.json", R"([{"scene_id": 2, "im_id": 7, "obj_id": 9, "inst_count": 1}])");
  expect_refusal("detection --bop bop", 3, {"test_targets_bop19.json", "object 9"});
}

/// A lumpy stone that half a turn about z leaves as it is, and no other motion does.
Mesh twofold_stone() {
  Mesh mesh = make_sphere(1.0, 4);
  for (Eigen::Vector3d& v : mesh.vertices) {
    const double x = v.x(), y = v.y(), z = v.z();
    const double bumps = 0.10 * std::sin(7 * x * y + 4 * z) + 0.08 * std::cos(6 * x * x - 5 * z);
    v = (0.05 * (1.0 + bumps + 0.15 * x * y + 0.12 * z)) * v.cwiseProduct(Eigen::Vector3d(1.2, 0.9, 0.7));
  }
  return mesh;
}

/// An image of the stone on a table, as a data set of the BOP layout.
void write_twofold(const std::string& folder, const Mesh& stone) {
  write_mesh(folder + "/bop/models/obj_000001.ply", scaled(stone, 1000));
  RayScene world;
  world.add(make_box({1.6, 1.6, 0.02}), make_pose(Eigen::Vector3d(0, 0, -0.01)));
  world.add(stone, make_pose(Eigen::Vector3d(0.01, 0.02, 0.034),
                             Eigen::Quaterniond(Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitZ()))));
  world.commit();
  const Eigen::Quaterniond down(Eigen::AngleAxisd(std::numbers::pi - 0.35, Eigen::Vector3d::UnitX()));
  const CameraIntrinsics camera;
  const Pose T_W_C = make_pose(down * Eigen::Vector3d(0, 0, -0.55), down);
  const std::string scene = folder + "/bop/test/000002";
  fs::create_directories(scene + "/depth");
  write_depth_png(scene + "/depth/000007.png", render(world, camera, T_W_C).depth, 0.000125);
  const json in_file = {{"cam_K", {camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1}},
                        {"depth_scale", 0.125}};
  write_file(scene + "/scene_camera.json", json{{"7", in_file}}.dump());
}

/// The pose in the last line of a BOP result file.
Pose pose_in_csv(const std::string& csv) {
  double R[9], t[3];
  const std::string line = csv.substr(csv.find('\n') + 1);
  EXPECT_EQ(std::sscanf(line.c_str(), "2,7,1,%*f,%lf %lf %lf %lf %lf %lf %lf %lf %lf,%lf %lf %lf,", R, R + 1,
                        R + 2, R + 3, R + 4, R + 5, R + 6, R + 7, R + 8, t, t + 1, t + 2),
            12)
      << csv;
  Pose T = Pose::Identity();
  T.linear() = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(R);
  T.translation() = 0.001 * Eigen::Vector3d(t[0], t[1], t[2]);
  return T;
}

TEST_F(BenchCommand, ASymmetricObjectMayBeFoundTurnedByItsSymmetry) {
  write_twofold(folder_, twofold_stone());
  const std::string command = "detection --bop bop --bop-csv found.csv --json";
  const Outcome found = run(command);
  ASSERT_EQ(found.code, 0) << found.err;
  ASSERT_EQ(rows_of(found.data(), "default")[0]["detections"], 1) << found.out;
  // The truth is what was found, turned by the symmetry: the two look the same.
  const Pose half =
      make_pose(Eigen::Vector3d::Zero(),
                Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ())));
  const auto [R, t] = bop_pose(pose_in_csv(read_file(folder_ + "/found.csv", 1 << 20)) * half);
  const json entry = {{"obj_id", 1}, {"cam_R_m2c", R}, {"cam_t_m2c", t}};
  write("bop/test/000002/scene_gt.json", json{{"7", {entry}}}.dump());
  const auto score = [&](const std::string& info) {
    write("bop/models/models_info.json", info);
    const Outcome scored = run(command);
    EXPECT_EQ(scored.code, 0) << scored.err;
    return rows_of(scored.data(), "true poses found by default")[0];
  };
  const json of_mesh = score(R"({"1": {}})");
  EXPECT_EQ(of_mesh["symmetries"], "2 poses") << "no object has any in the file: the mesh shows it";
  EXPECT_EQ(of_mesh["within_5_deg_5_mm"], 1);
  EXPECT_EQ(of_mesh["mssd_recall_percent"], 100.0);
  const std::string other =
      R"("2": {"symmetries_discrete": [[-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]]})";
  const json none = score(concat(R"({"1": {}, )", other, "}"));
  EXPECT_EQ(none["symmetries"], "none");
  EXPECT_EQ(none["within_5_deg_5_mm"], 0);
  EXPECT_LT(none["mssd_recall_percent"].get<double>(), 20.0);
  EXPECT_EQ(none["add_s_recall_percent"], 100.0);
  const json discrete = score(
      R"({"1": {"diameter": 120, "symmetries_discrete": [[-1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]]}})");
  EXPECT_EQ(discrete["symmetries"], "2 poses");
  EXPECT_EQ(discrete["within_5_deg_5_mm"], 1);
  EXPECT_EQ(discrete["mssd_recall_percent"], 100.0);
  EXPECT_EQ(discrete["mspd_recall_percent"], 100.0);
  const json continuous =
      score(R"({"1": {"symmetries_continuous": [{"axis": [0, 0, 1], "offset": [0, 0, 0]}]}})");
  EXPECT_EQ(continuous["within_5_deg_5_mm"], 1);
  EXPECT_EQ(continuous["mssd_recall_percent"], 100.0);
  write("bop/models/models_info.json", concat("{", other, "}"));
  const Outcome unknown = run(command);
  EXPECT_THAT(unknown.err, HasSubstr("symmetries are unknown"));
  const json by_distance = rows_of(unknown.data(), "true poses found by default")[0];
  EXPECT_EQ(by_distance["add_s_recall_percent"], 100.0);
  EXPECT_TRUE(by_distance["mssd_recall_percent"].is_null());
  EXPECT_TRUE(by_distance["within_5_deg_5_mm"].is_null());
}

TEST_F(BenchCommand, RefusesSymmetriesThatAreNone) {
  write_twofold(folder_, twofold_stone());
  const auto refused = [&](const std::string& info, const std::vector<std::string>& parts) {
    write("bop/models/models_info.json", info);
    expect_refusal("detection --bop bop", 3, parts);
  };
  refused(R"({"1": {"symmetries_discrete": [[1, 0, 0]]}})",
          {"models_info.json", "symmetries_discrete", "16"});
  refused(R"({"1": {"symmetries_discrete": [[2, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]]}})",
          {"no rotation"});
  refused(R"({"1": {"symmetries_continuous": [{"axis": [0, 0, 0], "offset": [0, 0, 0]}]}})",
          {"axis without direction"});
  refused(R"({"1": {"diameter": -3}})", {"diameter"});
}

}  // namespace
}  // namespace stonestack::bench
