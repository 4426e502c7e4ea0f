#include "simulation/sensor_noise.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include "stonestack/core/error.hpp"

namespace stonestack::simulation {
namespace {

/// A view made by formula: depth(u, v), and one normal for all; the camera's axes are the world's.
RenderedView make_view(const std::function<double(int, int)>& depth,
                       const Eigen::Vector3d& normal = -Eigen::Vector3d::UnitZ()) {
  RenderedView view;
  const auto& camera = view.depth.camera;
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      const double z = depth(u, v);
      view.depth.z.push_back(static_cast<float>(z));
      view.instance.push_back(z > 0 ? 0 : -1);
      view.normal_W.push_back(normal.cast<float>());
    }
  return view;
}

RenderedView flat(double z) {
  return make_view([z](int, int) { return z; });
}

struct Moments {
  double mean = 0, sigma = 0, holes = 0;
};
/// Of measured minus true depth, in the image's middle third, where the rays are nearly perpendicular.
Moments moments(const RenderedView& view, const DepthImage& image) {
  double sum = 0, squares = 0, count = 0, holes = 0;
  for (int v = 160; v < 320; ++v)
    for (int u = 213; u < 427; ++u) {
      const double z = image.at(u, v);
      if (z <= 0) {
        ++holes;
        continue;
      }
      const double e = z - view.depth.at(u, v);
      sum += e;
      squares += e * e;
      ++count;
    }
  const double mean = sum / count;
  return {mean, std::sqrt(squares / count - mean * mean), holes / (holes + count)};
}

TEST(SensorNoise, IdealSensorOnlyCountsAndClips) {
  const auto view = make_view([](int u, int) { return u < 200 ? 0.19 : u < 400 ? 0.70003 : 1.51; });
  Random random(1);
  const auto image = add_noise(view, Pose::Identity(), read_sensor("ideal"), random);
  EXPECT_EQ(image.at(100, 100), 0.0F);
  EXPECT_NEAR(image.at(300, 100), 0.7, 1e-6);
  EXPECT_EQ(image.at(500, 100), 0.0F);
}

TEST(SensorNoise, Sr300SigmaGrowsWithDepthAsModelled) {
  auto model = read_sensor("sr300");
  model.bias = 0;
  for (const double z : {0.4, 0.7, 1.0, 1.3}) {
    Random random(5);
    const auto m = moments(flat(z), add_noise(flat(z), Pose::Identity(), model, random));
    EXPECT_NEAR(m.sigma, 0.0004 + 0.001 * z * z, 0.00004) << "at " << z << " m";
    EXPECT_NEAR(m.mean, 0.0, 0.00002) << "at " << z << " m";
  }
}

TEST(SensorNoise, BiasStaysFromFrameToFrameAndHasItsSize) {
  auto model = read_sensor("sr300");
  double squares = 0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 6; ++seed) {
    model.bias_seed = seed;
    constexpr int kFrames = 5;
    Eigen::ArrayXd mean = Eigen::ArrayXd::Zero(36), seen = Eigen::ArrayXd::Zero(36);
    Random random(seed);
    for (int f = 0; f < kFrames; ++f) {
      const auto image = add_noise(flat(0.7), Pose::Identity(), model, random);
      for (int i = 0; i < 36; ++i)
        if (const double z = image.at(140 + 70 * (i % 6), 120 + 40 * (i / 6)); z > 0) {
          mean[i] += z - 0.7;
          seen[i] += 1;
        }
    }
    for (int i = 0; i < 36; ++i)
      if (seen[i] > kFrames / 2) {
        squares += std::pow(mean[i] / seen[i], 2);
        ++count;
      }
  }
  // Five frames leave a fifth of the frame noise's variance (0.9 mm) beside the bias.
  EXPECT_NEAR(std::sqrt(squares / count), std::sqrt(0.0005 * 0.0005 + 0.0009 * 0.0009 / 5), 0.0001);
}

TEST(SensorNoise, GrazingSurfacesAreNoisierAndThenVanish) {
  auto model = read_sensor("sr300");
  model.bias = 0;
  const auto tilted = [](double degrees) {
    const double a = degrees * 0.017453292519943295;
    return make_view([](int, int) { return 0.7; }, {std::sin(a), 0, -std::cos(a)});
  };
  const auto sigma = [&](double degrees) {
    Random random(2);
    return moments(tilted(degrees), add_noise(tilted(degrees), Pose::Identity(), model, random));
  };
  EXPECT_GT(sigma(60).sigma, 1.5 * sigma(0).sigma);
  EXPECT_LT(sigma(60).sigma, 3.5 * sigma(0).sigma);
  EXPECT_GT(sigma(89).holes, 0.5);
}

TEST(SensorNoise, EdgesFlyVanishAndCastAShadowAwayFromTheProjector) {
  // A wall 0.5 m away that covers the left half, before another at 0.8 m: the projector stands to the right
  // of the camera, so the strip behind a RIGHT edge is lit and the one behind a LEFT edge is dark.
  const auto view = make_view([](int u, int) { return u > 250 && u < 390 ? 0.5 : 0.8; });
  Random random(4);
  const auto image = add_noise(view, Pose::Identity(), read_sensor("sr300"), random);
  const double strip = 475 * 0.026 * (1 / 0.5 - 1 / 0.8);  // px of disparity between the walls
  int dark_left = 0, dark_right = 0, flying = 0, edge = 0;
  for (int v = 0; v < 480; ++v) {
    for (int k = 2; k < static_cast<int>(strip) - 2; ++k) {
      dark_left += image.at(250 - k, v) == 0 ? 1 : 0;
      dark_right += image.at(390 + k, v) == 0 ? 1 : 0;
    }
    for (const int u : {389, 390}) {
      ++edge;
      const float z = image.at(u, v);
      flying += z > 0.52F && z < 0.78F ? 1 : 0;
    }
  }
  const double cells = 480 * (static_cast<int>(strip) - 4);
  EXPECT_GT(dark_left / cells, 0.95);
  EXPECT_LT(dark_right / cells, 0.05);
  EXPECT_NEAR(flying / static_cast<double>(edge), 0.30 * 0.26 / 0.30, 0.06);
}

/// Share of pixels without depth, mean of some frames of a flat wall.
double hole_share(const SensorModel& model, int frames) {
  const RenderedView view = flat(0.7);
  Random random(9);
  double holes = 0;
  for (int frame = 0; frame < frames; ++frame) {
    const DepthImage image = add_noise(view, Pose::Identity(), model, random);
    holes += static_cast<double>(std::count(image.z.begin(), image.z.end(), 0.0F));
  }
  return holes / (frames * 640.0 * 480.0);
}

TEST(SensorNoise, HolesHaveTheirShare) {
  SensorModel model = read_sensor("sr300");
  // Single pixels, and six ellipses a frame: half axes uniform in 0.5 to 1.5 times the radius, so the mean
  // area is that of the circle.
  const double specks = 0.004, patches = 6 * 3.14159265 * 6.0 * 6.0 / (640.0 * 480.0);
  EXPECT_NEAR(hole_share(model, 20), specks + patches, 0.0006);
  model.blobs = 0;
  EXPECT_NEAR(hole_share(model, 4), specks, 0.0002);
  model.hole_share = 0;
  EXPECT_EQ(hole_share(model, 1), 0.0);
}

TEST(SensorNoise, D435IsCorrelatedAndFollowsTheStereoLaw) {
  auto model = read_sensor("d435");
  model.bias = 0;
  model.unit = 1e-6;  // counts of 1 mm hide the law
  const auto view = flat(0.7);
  Random random(6);
  const auto image = add_noise(view, Pose::Identity(), model, random);
  const auto m = moments(view, image);
  EXPECT_NEAR(m.sigma, 0.08 * 0.49 / (475 * 0.05), 0.0002);
  double product = 0;
  int count = 0;
  for (int v = 160; v < 320; ++v)
    for (int u = 213; u < 427; ++u)
      if (image.at(u, v) > 0 && image.at(u + 1, v) > 0) {
        product += (image.at(u, v) - 0.7) * (image.at(u + 1, v) - 0.7);
        ++count;
      }
  EXPECT_GT(product / count / (m.sigma * m.sigma), 0.7);
}

TEST(SensorNoise, SameSeedSameImage) {
  Random first(11), again(11), other(12);
  const auto a = add_noise(flat(0.7), Pose::Identity(), read_sensor("sr300"), first);
  EXPECT_EQ(a.z, add_noise(flat(0.7), Pose::Identity(), read_sensor("sr300"), again).z);
  EXPECT_NE(a.z, add_noise(flat(0.7), Pose::Identity(), read_sensor("sr300"), other).z);
}

TEST(SensorNoise, DisparitiesOfAStructuredLightCameraComeInSteps) {
  SensorModel model = read_sensor("kinect1");
  for (const double z : {0.6, 1.0, 1.8}) {
    Random random(3);
    const auto image = add_noise(flat(z), Pose::Identity(), model, random);
    std::set<float> depths;
    for (const float depth : image.z)
      if (std::abs(depth - z) < 0.02) depths.insert(depth);
    ASSERT_GT(depths.size(), 2U) << z;
    double step = 1.0;
    for (auto depth = std::next(depths.begin()); depth != depths.end(); ++depth)
      step = std::min(step, static_cast<double>(*depth - *std::prev(depth)));
    // An eighth of a pixel at 475 px and 75 mm: 3.51 mm at 1 m, with the square of the depth; counts of 1 mm.
    EXPECT_NEAR(step, 0.00351 * z * z, 0.0011) << z;
  }
}

/// Root of the mean square about a plane in 9 x 9 pixels, median over windows, m.
double plane_noise(const DepthImage& image) {
  std::vector<double> found;
  for (int v = 20; v < 460; v += 12)
    for (int u = 20; u < 620; u += 12) {
      double sum = 0, along_u = 0, along_v = 0, squares = 0;
      bool whole = true;
      for (int j = -4; j <= 4 && whole; ++j)
        for (int i = -4; i <= 4; ++i) {
          const double z = image.at(u + i, v + j);
          whole = whole && z > 0;
          sum += z;
          along_u += i * z;
          along_v += j * z;
          squares += z * z;
        }
      const double fitted = sum * sum / 81 + (along_u * along_u + along_v * along_v) / (81 * 60 / 9.0);
      if (whole) found.push_back(std::sqrt(std::max(0.0, squares - fitted) / 81));
    }
  std::nth_element(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(found.size() / 2), found.end());
  return found[found.size() / 2];
}

// Medians of recordings with a RealSense F200 (docs/measurements.md, Depth camera).
TEST(SensorNoise, F200IsAsNoisyAsItsRecordings) {
  for (const auto& [z, recorded] : {std::pair{0.6, 0.00035}, {0.7, 0.00042}, {0.8, 0.00047}}) {
    Random random(3);
    const auto image = add_noise(flat(z), Pose::Identity(), read_sensor("f200"), random);
    EXPECT_NEAR(plane_noise(image), recorded, 0.12 * recorded) << "at " << z << " m";
  }
}

TEST(SensorNoise, F200SmearsEdgesAsItsRecordings) {
  // A box edge in front of a table; the recordings have 3.2 floating pixels a crossing and, beside the
  // shadow, about three holes.
  const auto step = make_view([](int u, int) { return u < 320 ? 0.60 : 0.70; });
  auto model = read_sensor("f200");
  model.shadow_baseline = 0.0;
  model.hole_share = 0.0;
  model.blobs = 0;
  Random random(3);
  const auto image = add_noise(step, Pose::Identity(), model, random);
  double floating = 0, holes = 0;
  for (int v = 0; v < 480; ++v)
    for (int u = 300; u < 340; ++u) {
      const double z = image.at(u, v);
      if (z <= 0) ++holes;
      if (z > 0.604 && z < 0.696) ++floating;
    }
  EXPECT_NEAR(floating / 480, 3.2, 1.0);
  EXPECT_NEAR(holes / 480, 3.0, 1.0);
}

}  // namespace
}  // namespace stonestack::simulation
