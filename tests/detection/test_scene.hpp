#pragma once
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "geometry/depth_render.hpp"
#include "rooms.hpp"
#include "stonestack/core/random.hpp"
#include "stonestack/detection/detect_stones.hpp"

/// Stones and depth images for the tests of this room.
namespace stonestack::test {

/// An irregular stone, 13 to 18 cm long: an ellipsoid with waves and flat cuts. `mesh` has 1280 faces, `scan`
/// 20480.
[[nodiscard]] Stone make_test_stone(int seed);

/// Makes the first `Count` test stones and their models once for all tests of a suite.
template <int Count>
class StonesOnce : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    stones().clear();
    for (int seed = 1; seed <= Count; ++seed) stones().push_back(make_test_stone(seed));
    models() = std::make_unique<DetectionModels>(stones());
  }
  static void TearDownTestSuite() { models().reset(); }
  static std::vector<Stone>& stones() {
    static std::vector<Stone> all;
    return all;
  }
  static std::unique_ptr<DetectionModels>& models() {
    static std::unique_ptr<DetectionModels> all;
    return all;
  }
};

/// A stone standing somewhere.
struct StandingStone {
  const Stone* stone = nullptr;
  Pose T_W_O = Pose::Identity();
};

/// The rotation `R_W_O` with the lowest vertex of the scan on the table at (x, y).
[[nodiscard]] Pose on_table(const Stone& stone, const Eigen::Quaterniond& R_W_O, double x, double y);

/// A camera 0.7 m from the origin of W, `tilt` off the vertical, looking at it.
[[nodiscard]] Pose make_camera_pose(double tilt, double azimuth, double distance = 0.7);

/// The scans on a table of 1.6 m, seen without noise.
[[nodiscard]] DepthImage look_at(const std::vector<StandingStone>& stones, const Pose& T_W_C,
                                 const CameraIntrinsics& camera = {});

/// Adds Gaussian noise of `sigma` (at 1 m, growing with z^2, never below 0.4 of it), holes and blends at
/// edges.
[[nodiscard]] DepthImage with_noise(const DepthImage& image, double sigma, std::uint64_t seed);

/// Four of five test stones apart on the table, in random orientations; the last is never in a scene.
class FourOfFive : public StonesOnce<5> {
 protected:
  struct Scene {
    Pose T_W_C;
    std::vector<Pose> T_W_O;
    DepthImage image;
  };
  static Scene make_scene(std::uint64_t seed);
  /// Within 5 mm and 5 deg.
  static bool right(const Detection& d, const Scene& scene);
};

}  // namespace stonestack::test
