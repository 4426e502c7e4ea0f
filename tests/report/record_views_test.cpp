// Recordings of a camera alone, played from a folder, and what stands in record.json.
#include "report/record_views.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "geometry/bop_folder.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "temporary_folder.hpp"

namespace stonestack::report {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::ThrowsMessage;

class RecordViews : public testing::Test {
 protected:
  void SetUp() override {
    fs::remove_all(root);
    BopFolder played(root + "/played");
    for (int i = 0; i < 3; ++i) played.add(picture(i), 10.0 + 0.5 * i, std::nullopt);
    write_file(
        root + "/cell.yaml",
        "arm: {address: 192.0.2.1}\ncamera: {driver: recorded, recorded: {path: " + root + "/played}}\n");
    order.cell = read_cell(root + "/cell.yaml");
    order.out = root + "/views";
    order.version = "1.2.3 (abc)";
    order.frames = 3;
  }
  void TearDown() override { fs::remove_all(root); }

  /// 8 x 6 pixels, 1 mm a count, half of them without depth.
  [[nodiscard]] static DepthImage picture(int n) {
    CameraIntrinsics camera;
    camera.width = 8, camera.height = 6, camera.fx = camera.fy = 10, camera.cx = 3.5, camera.cy = 2.5;
    DepthImage image{camera, {}};
    for (int i = 0; i < 48; ++i)
      image.z.push_back(i % 2 == 0 ? 0.0F : static_cast<float>(0.001 * (700 + 10 * n + i)));
    return image;
  }
  [[nodiscard]] json noted() const { return json::parse(read_file(order.out + "/record.json", 1 << 20)); }

  const std::string root =
      test::temporary_folder() + testing::UnitTest::GetInstance()->current_test_info()->name();
  ViewsOrder order;
};

TEST_F(RecordViews, ACameraAloneIsRecordedWithoutPoses) {
  const RecordedViews done = record_views(order, {});
  EXPECT_EQ(done.ended, "done");
  ASSERT_EQ(done.views.size(), 3U);
  EXPECT_FALSE(done.views[0].q) << "of a recorded camera the arm is elsewhere, whatever its address";
  EXPECT_FALSE(done.views[0].T_W_C);
  EXPECT_DOUBLE_EQ(done.views[0].depth_share, 0.5);
  const DepthSequence sequence = read_depth_sequence(order.out);
  ASSERT_EQ(sequence.records.size(), 3U);
  EXPECT_EQ(read_depth(sequence.records[2]).z, picture(2).z) << "every count";
  EXPECT_DOUBLE_EQ(sequence.records[2].unit, 0.001);
  EXPECT_DOUBLE_EQ(sequence.records[2].time, 11.0);
  const json note = noted();
  EXPECT_EQ(note, json::parse(views_json(done)));
  EXPECT_EQ(note["schema"], "stonestack.record/1");
  EXPECT_EQ(note["version"], "1.2.3 (abc)");
  EXPECT_EQ(note["cell"]["name"], root + "/cell.yaml");
  EXPECT_EQ(note["cell"]["simulated"], false);
  EXPECT_EQ(note["cell"]["robot"], "ur10");
  EXPECT_TRUE(note["cell"].contains("T_T_C"));
  EXPECT_EQ(note["camera"]["name"], "recorded");
  EXPECT_EQ(note["camera"]["width"], 8);
  EXPECT_EQ(note["camera"]["distortion"], "none");
  EXPECT_EQ(note["camera"]["k"].size(), 5U);
  ASSERT_EQ(note["frames"].size(), 3U);
  EXPECT_EQ(note["frames"][2]["image"], 2);
  EXPECT_EQ(note["frames"][2]["number"], 3);
  EXPECT_EQ(note["frames"][2]["time"], 11.0);
  EXPECT_FALSE(note["frames"][2].contains("q"));
  EXPECT_THAT(views_table(done), AllOf(HasSubstr("unknown: no arm"), HasSubstr("3 of 3 frames of 8 x 6")));
}

TEST_F(RecordViews, AnErrorLeavesTheFramesBeforeIt) {
  order.frames = 5;
  EXPECT_THAT([&] { (void)record_views(order, {}); },
              ThrowsMessage<DeviceError>(HasSubstr("is over after 3 frames")));
  EXPECT_EQ(read_depth_sequence(order.out).records.size(), 3U);
  const json note = noted();
  EXPECT_EQ(note["asked"], 5);
  EXPECT_EQ(note["frames"].size(), 3U);
  EXPECT_THAT(note["ended"].get<std::string>(), HasSubstr("is over after 3 frames"));
}

TEST_F(RecordViews, AFullFolderIsRefusedUnlessAskedFor) {
  (void)record_views(order, {});
  EXPECT_THAT([&] { (void)record_views(order, {}); },
              ThrowsMessage<InvalidArgument>(AllOf(HasSubstr("is not empty"), HasSubstr("--force"))));
  write_file(order.out + "/notes.txt", "mine");
  order.frames = 1;
  order.replace = true;
  (void)record_views(order, {});
  EXPECT_EQ(read_depth_sequence(order.out).records.size(), 1U);
  EXPECT_FALSE(fs::exists(order.out + "/depth/000001.png")) << "of the recording that was replaced";
  EXPECT_TRUE(fs::exists(order.out + "/notes.txt"));
}

TEST_F(RecordViews, ARecordingIsReplacedOnlyByAnother) {
  (void)record_views(order, {});
  fs::remove_all(root + "/played");
  order.replace = true;
  EXPECT_THROW((void)record_views(order, {}), FileError);
  EXPECT_EQ(read_depth_sequence(order.out).records.size(), 3U) << "no frame was taken";
}

TEST_F(RecordViews, DepthImagesOfSomebodyElseAreKept) {
  order.out = root + "/played";  // a data set without record.json
  order.replace = true;
  EXPECT_THAT([&] { (void)record_views(order, {}); },
              ThrowsMessage<InvalidArgument>(HasSubstr("that stonestack did not record")));
  EXPECT_EQ(read_depth_sequence(order.out).records.size(), 3U);
}

TEST_F(RecordViews, ACameraThatFailsAtOnceLeavesNoFolder) {
  fs::remove_all(root + "/played");
  EXPECT_THROW((void)record_views(order, {}), FileError);
  EXPECT_FALSE(fs::exists(order.out));
}

/// An arm, a camera and a clock that a test drives.
struct MovedByHand : DepthCamera, Clock {
  double time = 0.0, speed = 0.0;  // s, rad/s of every joint
  [[nodiscard]] double now() const override { return time; }
  [[nodiscard]] DepthFrame capture() override {
    time += 0.1;
    DepthFrame frame{picture, ++number, time, time};
    return frame;
  }
  WatchedCell cell() {
    return {*this,
            [this] {
              return JointReading{Joints::Constant(speed * time), time};
            },
            *this, [this](double seconds) { time += std::max(0.0, seconds); }, read_robot("ur10")};
  }
  DepthImage picture;
  long number = 0;
};

TEST_F(RecordViews, AnArmThatMovesDuringTheExposureGivesNoPose) {
  MovedByHand devices;
  devices.picture = picture(0);
  RecordedViews record;
  record.folder = order.out;
  order.every = 2.0;
  const RecordedViews still = record_cell(order, devices.cell(), record);
  ASSERT_EQ(still.views.size(), 3U);
  const CellLayout layout;
  const Pose T_W_C = forward(read_robot("ur10"), Joints::Zero()) * layout.T_F_T * layout.T_T_C;
  ASSERT_TRUE(still.views[0].T_W_C);
  EXPECT_TRUE(still.views[0].T_W_C->isApprox(T_W_C, 1e-12));
  EXPECT_NEAR(still.views[2].time - still.views[0].time, 4.0, 1e-9) << "two pauses";
  devices.speed = 0.05;
  record.folder = order.out + "_moved";
  const RecordedViews moved = record_cell(order, devices.cell(), record);
  EXPECT_NEAR(moved.views[0].moved, 0.005, 1e-9);
  EXPECT_TRUE(moved.views[0].q);
  EXPECT_FALSE(moved.views[0].T_W_C);
  EXPECT_FALSE(read_depth_sequence(record.folder).records[0].T_W_C);
  EXPECT_THAT(views_table(moved), HasSubstr("unknown: the arm moved"));
}

}  // namespace
}  // namespace stonestack::report
