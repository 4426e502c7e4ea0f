#include "geometry/sensor_model.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "temporary_folder.hpp"

namespace stonestack::geometry {
namespace {

using testing::HasSubstr;

/// Error of reading a changed copy of the file of the D435; empty if there is none.
std::string refusal(const std::string& from, const std::string& to) {
  std::string text = read_file(data_path("sensors/d435.yaml"), 1 << 20);
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
  const std::string path = test::temporary_folder() + "sensor.yaml";
  write_file(path, text);
  try {
    (void)read_sensor(path);
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), HasSubstr(path));
    return error.what();
  }
  return "";
}

TEST(SensorModel, EveryFileThatComesWithStonestackIsOne) {
  const auto names = sensor_names();
  EXPECT_THAT(names, testing::IsSupersetOf(
                         {"azure", "d415", "d435", "f200", "ideal", "kinect1", "l515", "sr300", "xtion"}));
  for (const std::string& name : names) {
    const SensorModel sensor = read_sensor(name);
    EXPECT_EQ(sensor.name, name);
    EXPECT_LT(sensor.nearest, 0.62) << name << ": stones are seen from there";
    // Of a depth at 0.7 m: from a tenth of a millimetre to 4 mm.
    const double sigma = sensor.sigma + 0.49 * sensor.sigma_square +
                         0.49 * sensor.stereo_subpixel / (sensor.camera.fx * sensor.stereo_baseline);
    if (name != "ideal") {
      EXPECT_GT(sigma, 1e-4) << name;
      EXPECT_LT(sigma, 4e-3) << name;
    }
  }
}

TEST(SensorModel, AFileIsRefusedByWhatIsWrongInIt) {
  EXPECT_EQ(refusal("unit: 0.001", "unit: 0.002"), "") << "another count is none of its faults";
  EXPECT_THAT(refusal("unit: 0.001", ""), HasSubstr("unit is missing"));
  EXPECT_THAT(refusal("unit: 0.001", "unit: 5"), HasSubstr("unit"));
  EXPECT_THAT(refusal("unit: 0.001", "unit: .nan"), HasSubstr("unit"));
  EXPECT_THAT(refusal("disparity_step: 0", "disparity_stop: 0"), HasSubstr("disparity_stop"));
  EXPECT_THAT(refusal("sensor/1", "sensor/9"), HasSubstr("sensor/9"));
  EXPECT_THAT(refusal("farthest: 3.0", "farthest: 0.1"), HasSubstr("range.farthest"));
  EXPECT_THAT(refusal("cx: 423.5", "cx: 900"), HasSubstr("principal point"));
  EXPECT_THAT(refusal("flying: 0.3", "flying: 0.9"), HasSubstr("edge.flying"));
  try {
    (void)read_sensor("kinect");
    FAIL();
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), HasSubstr("kinect1"));
  }
}

TEST(SensorModel, ItsLensGoesWithTheSizeOfTheImage) {
  const SensorModel sensor = read_sensor("kinect1");  // 640 x 480, 580 px
  const CameraIntrinsics half = nominal_lens(sensor, 320, 240);
  EXPECT_NEAR(half.fx, 290.0, 1e-9);
  EXPECT_NEAR(half.cx, 159.5, 1e-9);
  EXPECT_NEAR(half.cy, 119.5, 1e-9);
  const CameraIntrinsics wide = nominal_lens(sensor, 640, 360);  // 60 rows less above and below
  EXPECT_NEAR(wide.fy, 580.0, 1e-9);
  EXPECT_NEAR(wide.cy, 179.5, 1e-9);
}

}  // namespace
}  // namespace stonestack::geometry
