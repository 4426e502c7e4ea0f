#include "stonestack/kinematics/hand_eye.hpp"

#include <gmock/gmock.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "temporary_folder.hpp"

namespace stonestack::kinematics {
namespace {

using testing::HasSubstr;

const Pose kTrue = make_pose({0.03, -0.06, 0.08}, Eigen::Quaterniond(0.95, 0.05, -0.1, 0.25));

HandEyeFile stations(int count = 15) {
  const CameraMount mount = CameraMount::kOnHand;
  return {mount, simulate_hand_eye(kTrue, mount, count, {}, Random::stream(5, "hand eye")), ""};
}

/// Calibrations, and files in a folder of the test's own.
class HandEyeReports : public testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder_); }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::string folder_ = test::temporary_folder() + concat("hand_eye_calibration_", ::getpid());
};

TEST_F(HandEyeReports, GoodStationsGiveTheChosenMethodWithoutDoubt) {
  const HandEyeCalibration done = calibrate_stations(stations(), {"daniilidis", ""});
  EXPECT_EQ(done.chosen.method, "daniilidis");
  EXPECT_EQ(done.uncertainty, "");
  EXPECT_TRUE(done.warnings.empty());
  const auto data = nlohmann::json::parse(calibration_json(done));
  EXPECT_EQ(data.at("schema"), "stonestack.calibrate/1");
  EXPECT_EQ(data.at("pairs"), 15);
  EXPECT_EQ(data.at("method"), "daniilidis");
  EXPECT_EQ(data.at("solutions").size(), 4U);
  EXPECT_NEAR(data.at("T_A_C").at("y"), -0.06, 0.005);
  EXPECT_EQ(data.at("T_A_C").at("x"), done.chosen.T_A_C.translation().x());
  EXPECT_FALSE(data.contains("check"));
  const std::string table = calibration_table(done), with_errors = calibration_table(done, kTrue);
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 5) << "a heading and four methods";
  EXPECT_THAT(table, testing::Not(HasSubstr("error")));
  EXPECT_THAT(with_errors, HasSubstr("error mm, deg"));
  EXPECT_THROW((void)calibrate_stations(stations(), {"none", ""}), InvalidArgument);
}

TEST_F(HandEyeReports, RefusesStationsThatDoNotBelongTogether) {
  HandEyeFile shuffled = stations();
  for (std::size_t i = 0; i + 1 < shuffled.pairs.size(); ++i)
    std::swap(shuffled.pairs[i].T_C_B, shuffled.pairs[i + 1].T_C_B);
  const HandEyeCalibration done = calibrate_stations(shuffled);
  EXPECT_NE(done.uncertainty, "");
  EXPECT_EQ(done.warnings, std::vector<std::string>{done.uncertainty});
}

TEST_F(HandEyeReports, ComparesAFileAndFindsThatItIsInverted) {
  const std::string good = folder_ + "/good.yaml", inverse = folder_ + "/inverse.yaml";
  HandEyeCalibration done = calibrate_stations(stations());
  write_calibration(good, done);
  done.chosen.T_A_C = done.chosen.T_A_C.inverse();
  write_calibration(inverse, done, good);
  EXPECT_EQ(read_easy_handeye(inverse).parameters, read_easy_handeye(good).parameters);
  const HandEyeCalibration same = calibrate_stations(stations(), {"joint", good});
  ASSERT_TRUE(same.check.has_value());
  EXPECT_LT(same.check->off.translation, 1e-9);
  EXPECT_TRUE(same.warnings.empty());
  EXPECT_THAT(to_text(*same.check), HasSubstr(good + ": residual "));
  const HandEyeCalibration turned = calibrate_stations(stations(), {"joint", inverse});
  EXPECT_TRUE(turned.check->inverted);
  ASSERT_EQ(turned.warnings.size(), 1U);
  EXPECT_THAT(turned.warnings.front(), HasSubstr("inverse.yaml: the transformation is inverted"));
  EXPECT_EQ(nlohmann::json::parse(calibration_json(turned)).at("check").at("inverted"), true);
  HandEyeFile beside = stations();
  beside.mount = CameraMount::kOnBase;
  EXPECT_THROW((void)calibrate_stations(beside, {"joint", good}), FileError);
}

TEST_F(HandEyeReports, AFileWithTooFewStationsIsNamed) {
  const std::string path = folder_ + "/pairs.yaml";
  write_hand_eye_pairs(path, stations(2));
  try {
    (void)calibrate_stations(read_hand_eye_pairs(path));
    FAIL() << "two stations fix nothing";
  } catch (const FileError& problem) {
    EXPECT_THAT(problem.what(), testing::StartsWith(path + ": "));
    EXPECT_THAT(problem.what(), HasSubstr("record more stations"));
  }
  EXPECT_THROW((void)calibrate_stations(stations(2)), InvalidArgument) << "simulated ones are the caller's";
}

}  // namespace
}  // namespace stonestack::kinematics
