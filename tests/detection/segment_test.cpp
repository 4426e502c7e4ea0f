#include "stonestack/detection/segment.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "stonestack/core/error.hpp"
#include "test_scene.hpp"

namespace stonestack::detection {
namespace {

using namespace test;

/// A mesh that stands on the table.
struct Standing {
  Mesh mesh;
  Pose T_W_O;
};

/// View of things on a table of 1.6 m, and which thing each pixel shows (1, 2, ...).
struct TrueView {
  DepthView view;
  std::vector<int> truth;
};

TrueView see(const std::vector<Standing>& things, const Pose& T_W_C, double sigma = 0.0006) {
  RayScene world;
  world.add(make_box({1.6, 1.6, 0.02}), make_pose({0, 0, -0.01}));
  for (const Standing& thing : things) world.add(thing.mesh, thing.T_W_O);
  world.commit();
  const RenderedView seen = render(world, CameraIntrinsics{}, T_W_C);
  return {{with_noise(seen.depth, sigma, 7), T_W_C}, seen.instance};
}

/// Share of the things that have a segment with an IoU of 0.75.
double share_right(const TrueView& seen, const std::vector<int>& labels, int things) {
  int right = 0;
  for (int thing = 1; thing <= things; ++thing) {
    std::map<int, int> shared, size;
    int pixels = 0;
    for (std::size_t i = 0; i < labels.size(); ++i) {
      const bool is_thing = seen.truth[i] == thing && seen.view.image.z[i] > 0;
      pixels += is_thing ? 1 : 0;
      ++size[labels[i]];
      if (is_thing) ++shared[labels[i]];
    }
    right += std::any_of(shared.begin(), shared.end(), [&](const auto& entry) {
      return entry.first > 0 && entry.second > 0.75 * (pixels + size[entry.first] - entry.second);
    });
  }
  return static_cast<double>(right) / things;
}

Standing box_at(const Eigen::Vector3d& size, double x, double y, double z = 0.0, double turn = 0.0) {
  return {make_box(size), make_pose({x, y, z + 0.5 * size.z()},
                                    Eigen::Quaterniond(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitZ())))};
}

TEST(Segment, PartsStonesThatTouch) {
  std::vector<Standing> stones;
  for (int k = 0; k < 3; ++k) {
    const Stone stone = make_test_stone(k + 1);
    const double angle = 2.1 * k;
    stones.push_back({stone.scan, on_table(stone, Eigen::Quaterniond::Identity(), 0.075 * std::cos(angle),
                                           0.075 * std::sin(angle))});
  }
  const TrueView seen = see(stones, make_camera_pose(0.3, 0.4));
  const Segmentation found = segment(seen.view.image);
  ASSERT_EQ(found.objects.size(), 3u) << found.note;
  EXPECT_EQ(share_right(seen, found.labels.at(0), 3), 1.0);
  for (const SegmentedObject& object : found.objects) {
    EXPECT_GT(object.confidence, 0.5);
    EXPECT_EQ(object.cloud_C.points.size(), object.cloud_C.normals.size());
    EXPECT_FALSE(object.cut_off);
  }
}

TEST(Segment, PartsABoxFromTheOneItStandsOnAndMeasuresBoth) {
  const TrueView seen =
      see({box_at({0.20, 0.14, 0.06}, 0, 0), box_at({0.08, 0.06, 0.05}, 0.02, 0, 0.06, 0.4)},
          make_camera_pose(0.5, 0));
  const Segmentation found = segment(seen.view.image);
  ASSERT_EQ(found.objects.size(), 2u);
  EXPECT_EQ(share_right(seen, found.labels[0], 2), 1.0);
  EXPECT_NEAR(found.objects[0].size.z(), 0.06, 0.006) << "height of the lower one above the table";
  EXPECT_NEAR(found.objects[1].size.z(), 0.11, 0.006) << "height of the upper one above the table";
  EXPECT_NEAR(found.objects[1].size.x(), 0.08, 0.03);
}

TEST(Segment, JoinsWhatAnObjectInFrontDivides) {
  const TrueView seen = see({box_at({0.30, 0.08, 0.08}, 0, 0.05), box_at({0.04, 0.04, 0.20}, 0, -0.12)},
                            make_camera_pose(0.9, -M_PI / 2));
  const Segmentation found = segment(seen.view.image);
  EXPECT_EQ(found.objects.size(), 2u);
  EXPECT_EQ(share_right(seen, found.labels[0], 2), 1.0);
}

TEST(Segment, JoinsTheInsideOfAVesselAndItsOutside) {
  Mesh cup;  // 64 sides, open above
  constexpr int kSides = 64;
  for (int k = 0; k < kSides; ++k)
    for (const auto& [radius, z] : {std::pair(0.050, 0.0), {0.050, 0.10}, {0.046, 0.10}, {0.046, 0.004}})
      cup.vertices.emplace_back(radius * std::cos(2 * M_PI * k / kSides),
                                radius * std::sin(2 * M_PI * k / kSides), z);
  for (int k = 0; k < kSides; ++k)
    for (int ring = 0; ring < 3; ++ring) {
      const int a = 4 * k + ring, b = 4 * ((k + 1) % kSides) + ring;
      cup.faces.emplace_back(a, b, b + 1);
      cup.faces.emplace_back(a, b + 1, a + 1);
    }
  const TrueView seen = see({{cup, make_pose({0, 0, 0})}}, make_camera_pose(0.8, 0.2));
  const Segmentation found = segment(seen.view.image);
  ASSERT_EQ(found.objects.size(), 1u);
  EXPECT_EQ(share_right(seen, found.labels[0], 1), 1.0);
}

TEST(Segment, JoinsViewsOfOneSceneAndKeepsObjectsApart) {
  const std::vector<Standing> things = {box_at({0.10, 0.08, 0.06}, -0.08, 0),
                                        box_at({0.09, 0.09, 0.09}, 0.08, 0.01),
                                        box_at({0.05, 0.05, 0.04}, -0.07, 0, 0.06, 0.5)};
  const TrueView one = see(things, make_camera_pose(0.5, 0)), two = see(things, make_camera_pose(0.5, 2.0));
  const std::vector<DepthView> views{one.view, two.view};
  const Segmentation found = segment(views);
  ASSERT_EQ(found.objects.size(), 3u);
  ASSERT_EQ(found.labels.size(), 2u);
  EXPECT_EQ(share_right(one, found.labels[0], 3), 1.0);
  EXPECT_EQ(share_right(two, found.labels[1], 3), 1.0);
  for (const SegmentedObject& object : found.objects) EXPECT_EQ(object.views, 2);
}

TEST(Segment, ABlankViewAmongOthersIsPassedOver) {
  const std::vector<Standing> things = {box_at({0.10, 0.08, 0.06}, -0.08, 0),
                                        box_at({0.09, 0.09, 0.09}, 0.08, 0.01)};
  const TrueView one = see(things, make_camera_pose(0.5, 0)), two = see(things, make_camera_pose(0.5, 2.0));
  const std::vector<DepthView> whole{one.view, two.view};
  const Segmentation all = segment(whole);
  for (std::size_t blank = 0; blank < 3; ++blank) {
    std::vector<DepthView> views = whole;
    views.insert(views.begin() + static_cast<std::ptrdiff_t>(blank), one.view);
    views[blank].image.z.assign(one.view.image.z.size(), 0.0F);
    const Segmentation found = segment(views);
    ASSERT_EQ(found.objects.size(), 2u) << found.note;
    ASSERT_EQ(found.labels.size(), 3u);
    EXPECT_EQ(std::count(found.labels[blank].begin(), found.labels[blank].end(), 0),
              static_cast<std::ptrdiff_t>(one.view.image.z.size()));
    EXPECT_EQ(share_right(one, found.labels[blank == 0 ? 1 : 0], 2), 1.0);
    EXPECT_EQ(share_right(two, found.labels[blank == 2 ? 1 : 2], 2), 1.0);
    EXPECT_EQ(found.objects[0].views, 2);
    EXPECT_NEAR(found.objects[0].size.z(), all.objects[0].size.z(), 0.002) << "above the table";
    EXPECT_NE(found.note.find(concat("view ", blank + 1)), std::string::npos) << found.note;
  }
}

TEST(Segment, SaysWhyThereIsNoObject) {
  const TrueView bare = see({}, make_camera_pose(0.3, 0));
  const Segmentation nothing = segment(bare.view.image);
  EXPECT_TRUE(nothing.objects.empty());
  EXPECT_TRUE(nothing.table_C);
  EXPECT_NE(nothing.note.find("nothing stands on the table"), std::string::npos) << nothing.note;

  DepthImage empty = bare.view.image;
  std::fill(empty.z.begin(), empty.z.end(), std::numeric_limits<float>::quiet_NaN());
  EXPECT_NE(segment(empty).note.find("no pixel has a depth"), std::string::npos) << segment(empty).note;
  empty.z.clear();
  EXPECT_NE(segment(empty).note.find("empty"), std::string::npos) << segment(empty).note;
  EXPECT_THROW((void)segment(std::span<const DepthView>{}), InvalidArgument);
}

TEST(Segment, SaysThatThereIsNoTable) {
  DepthImage bowl = see({}, make_camera_pose(0.3, 0)).view.image;  // a paraboloid: no part of it is flat
  for (int v = 0; v < bowl.camera.height; ++v)
    for (int u = 0; u < bowl.camera.width; ++u)
      bowl.z[static_cast<std::size_t>(v * bowl.camera.width + u)] =
          static_cast<float>(1.2 - 8e-6 * (std::pow(u - 320.0, 2) + std::pow(v - 240.0, 2)));
  const Segmentation found = segment(bowl);
  EXPECT_TRUE(found.objects.empty());
  EXPECT_NE(found.note.find("no plane"), std::string::npos) << found.note;
}

TEST(Segment, GivesAHeapThatLooksLikeOneObjectLittleConfidence) {
  // Two boxes flush with each other: no groove shows where they meet.
  const TrueView seen = see({box_at({0.45, 0.20, 0.10}, -0.2245, 0), box_at({0.45, 0.20, 0.10}, 0.2245, 0)},
                            make_camera_pose(0.3, 0, 1.2));
  const Segmentation found = segment(seen.view.image);
  ASSERT_EQ(found.objects.size(), 1u);
  EXPECT_LT(found.objects[0].confidence, 0.3) << "twice as long as an object usually is";
}

}  // namespace
}  // namespace stonestack::detection
