// Poses of 20 small scenes that may not drift. Regenerate, with the reason in the commit:
//   STONESTACK_WRITE_GOLDEN=1 test_detection --gtest_filter='Golden.*'
#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>

#include "core/constants.hpp"
#include "detection/test_scene.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::detection {
namespace {

constexpr double kSameShift = 2e-5;            // m: another compiler rounds differently, no more
constexpr double kSameAngle = 0.02 * kDegree;  // rad
constexpr int kScenes = 20, kStones = 4;       // two of the four in each scene

const std::string kPath = std::string(STONESTACK_SOURCE_DIR) + "/tests/detection/golden/poses.txt";

/// A camera of a quarter of the pixels: the same stones at a quarter of the time.
CameraIntrinsics small_camera() {
  CameraIntrinsics camera;
  camera.width = 320, camera.height = 240;
  camera.fx = camera.fy = 237.5;
  camera.cx = 159.5, camera.cy = 119.5;
  return camera;
}

struct GoldenScene {
  DepthImage image;
  std::vector<std::pair<StoneIndex, Pose>> truth;  ///< stone, T_C_O
};

GoldenScene make_scene(const std::vector<Stone>& stones, int number) {
  Random random = Random::stream(static_cast<std::uint64_t>(number), "golden scene");
  const Pose T_W_C = test::make_camera_pose(random.uniform(0.1, 0.8), random.uniform(0.0, 6.28), 0.6);
  const int first = static_cast<int>(random.index(kStones));
  const int other = (first + 1 + static_cast<int>(random.index(kStones - 1))) % kStones;
  GoldenScene scene;
  std::vector<test::StandingStone> standing;
  for (const auto& [stone, x] : {std::pair{StoneIndex(first), -0.1}, std::pair{StoneIndex(other), 0.1}}) {
    const Stone& s = at(stones, stone);
    const Pose T_W_O = test::on_table(s, random.rotation(), x, random.uniform(-0.05, 0.05));
    standing.push_back({&s, T_W_O});
    scene.truth.emplace_back(stone, T_W_C.inverse() * T_W_O);
  }
  scene.image = test::with_noise(test::look_at(standing, T_W_C, small_camera()), 0.0006,
                                 static_cast<std::uint64_t>(number));
  return scene;
}

std::string line_of(int scene, const Detection& d) {
  std::ostringstream out;
  out.precision(9);
  const Eigen::Quaterniond q(d.T_C_O.linear());
  const Eigen::Vector3d& p = d.T_C_O.translation();
  out << scene << ' ' << d.stone << ' ' << p.x() << ' ' << p.y() << ' ' << p.z() << ' ' << q.x() << ' '
      << q.y() << ' ' << q.z() << ' ' << q.w();
  return out.str();
}

/// Poses of the file by (scene, stone).
std::map<std::pair<int, int>, Pose> read_golden() {
  std::ifstream file(kPath);
  std::map<std::pair<int, int>, Pose> poses;
  int scene = 0, stone = 0;
  double v[7];
  while (file >> scene >> stone >> v[0] >> v[1] >> v[2] >> v[3] >> v[4] >> v[5] >> v[6])
    poses[{scene, stone}] = make_pose({v[0], v[1], v[2]}, Eigen::Quaterniond(v[6], v[3], v[4], v[5]));
  return poses;
}

TEST(Golden, PosesOfTwentyScenesDoNotDrift) {
  std::vector<Stone> stones;
  for (int seed = 11; seed < 11 + kStones; ++seed) stones.push_back(test::make_test_stone(seed));
  const DetectionModels models(stones);
  const bool write = std::getenv("STONESTACK_WRITE_GOLDEN") != nullptr;
  auto golden = read_golden();
  std::string text;
  int right = 0;
  for (int number = 1; number <= kScenes; ++number) {
    const GoldenScene scene = make_scene(stones, number);
    for (const auto& d : detect_stones(scene.image, models).detections) {
      text += line_of(number, d) + "\n";
      for (const auto& [stone, T_C_O] : scene.truth)
        if (stone == d.stone && difference(T_C_O, d.T_C_O).translation < 0.003 &&
            difference(T_C_O, d.T_C_O).angle < 3 * kDegree)
          ++right;
      if (write) continue;
      const auto known = golden.find({number, d.stone.value()});
      ASSERT_NE(known, golden.end()) << "new: scene " << number << ", stone " << d.stone;
      EXPECT_LT(difference(known->second, d.T_C_O).translation, kSameShift) << "scene " << number;
      EXPECT_LT(difference(known->second, d.T_C_O).angle, kSameAngle) << "scene " << number;
      golden.erase(known);
    }
  }
  EXPECT_GE(right, 2 * kScenes - 2) << "golden poses must be right, too";
  if (write)
    std::ofstream(kPath) << text;
  else
    EXPECT_TRUE(golden.empty()) << golden.size() << " poses are no longer found";
}

}  // namespace
}  // namespace stonestack::detection
