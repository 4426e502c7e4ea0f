#include "stonestack/kinematics/hand_eye.hpp"

#include <gtest/gtest.h>

#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "core/constants.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"

namespace stonestack::kinematics {
namespace {

const Pose kHandEyeTrue = make_pose({0.03, -0.06, 0.08}, Eigen::Quaterniond(0.95, 0.05, -0.1, 0.25));

std::vector<HandEyePair> stations(CameraMount mount, const HandEyeNoise& noise, std::uint64_t seed,
                                  int count = 15) {
  return simulate_hand_eye(kHandEyeTrue, mount, count, noise, Random::stream(seed, "hand eye"));
}

TEST(HandEye, EveryMethodIsExactWithoutNoiseOnHandAndOnBase) {
  for (const auto mount : {CameraMount::kOnHand, CameraMount::kOnBase}) {
    const auto result = calibrate_hand_eye(stations(mount, {0, 0, 0, 0}, 1, 6), mount);
    std::set<std::string> methods;
    for (const auto& s : result.solutions) {
      methods.insert(s.method);
      EXPECT_LT(difference(s.T_A_C, kHandEyeTrue).translation, 1e-7) << s.method << " " << to_text(mount);
      EXPECT_LT(difference(s.T_A_C, kHandEyeTrue).angle, 1e-6) << s.method << " " << to_text(mount);
      EXPECT_LT(s.residual.translation, 1e-7) << s.method;
    }
    EXPECT_EQ(methods, (std::set<std::string>{"joint", "tsai_lenz", "park_martin", "daniilidis"}));
    EXPECT_EQ(result.warning, "");
  }
}

TEST(HandEye, FifteenNoisyStationsGiveAMillimetreAndAFifthOfADegree) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const auto pairs = stations(CameraMount::kOnHand, {}, seed);
    const auto result = calibrate_hand_eye(pairs, CameraMount::kOnHand);
    const HandEyeSolution& joint = result.solutions.front();
    ASSERT_EQ(joint.method, "joint");
    EXPECT_LT(difference(joint.T_A_C, kHandEyeTrue).translation, 0.001) << "seed " << seed;
    EXPECT_LT(difference(joint.T_A_C, kHandEyeTrue).angle, 0.2 * kDegree) << "seed " << seed;
    EXPECT_GT(joint.residual.translation, 0.0003) << "noise cannot vanish, seed " << seed;
    for (const auto& s : result.solutions)
      EXPECT_LT(difference(s.T_A_C, kHandEyeTrue).translation, 0.006) << s.method << ", seed " << seed;
  }
}

TEST(HandEye, OneBadStationDoesNotSpoilTheJointResult) {
  auto pairs = stations(CameraMount::kOnHand, {}, 3, 20);
  pairs[7].T_C_B =
      make_pose({0.04, -0.02, 0.03}) * pairs[7].T_C_B * Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitX());
  const auto result = calibrate_hand_eye(pairs, CameraMount::kOnHand);
  EXPECT_LT(difference(result.solutions.front().T_A_C, kHandEyeTrue).translation, 0.0015);
  EXPECT_LT(difference(result.solutions.front().T_A_C, kHandEyeTrue).angle, 0.3 * kDegree);
}

TEST(HandEye, PointsOutInvertedPosesAndAnInvertedResult) {
  const auto pairs = stations(CameraMount::kOnHand, {}, 4);
  auto arm = pairs, target = pairs;
  for (auto& p : arm) p.T_R_F = p.T_R_F.inverse();
  for (auto& p : target) p.T_C_B = p.T_C_B.inverse();
  EXPECT_EQ(calibrate_hand_eye(pairs, CameraMount::kOnHand).warning, "");
  EXPECT_NE(calibrate_hand_eye(arm, CameraMount::kOnHand).warning.find("arm's poses"), std::string::npos);
  EXPECT_NE(calibrate_hand_eye(target, CameraMount::kOnHand).warning.find("target's poses"),
            std::string::npos);
  EXPECT_FALSE(looks_inverted(pairs, CameraMount::kOnHand, kHandEyeTrue));
  EXPECT_TRUE(looks_inverted(pairs, CameraMount::kOnHand, kHandEyeTrue.inverse()));
}

TEST(HandEye, RefusesStationsThatFixNothing) {
  const auto pairs = stations(CameraMount::kOnHand, {}, 5, 2);
  EXPECT_THROW((void)calibrate_hand_eye(pairs, CameraMount::kOnHand), InvalidArgument);
  std::vector<HandEyePair> same(8, pairs[0]), turned;
  EXPECT_THROW((void)calibrate_hand_eye(same, CameraMount::kOnHand), InvalidArgument);
  for (int i = 0; i < 8; ++i) {  // about one axis only
    const Pose T_R_F = pairs[0].T_R_F * Eigen::AngleAxisd(0.3 * i, Eigen::Vector3d::UnitZ());
    turned.push_back({T_R_F, (T_R_F * kHandEyeTrue).inverse() * make_pose({0.6, 0, 0})});
  }
  EXPECT_THROW((void)calibrate_hand_eye(turned, CameraMount::kOnHand), InvalidArgument);
}

class HandEyeFiles : public ::testing::Test {
 protected:
  void SetUp() override { std::filesystem::create_directories(folder); }
  void TearDown() override { std::filesystem::remove_all(folder); }
  const std::string folder =
      (std::filesystem::temp_directory_path() / ("hand_eye_" + std::to_string(::getpid()))).string();
  const std::string path = folder + "/calibration.yaml";
};

// As easy_handeye writes it (PyYAML, keys sorted); values made up.
constexpr const char* kEasyHandEye =
    "parameters:\n"
    "  eye_on_hand: true\n"
    "  move_group: manipulator\n"
    "  move_group_namespace: /\n"
    "  namespace: /ur10_sr300_eye_on_hand/\n"
    "  robot_base_frame: base_link\n"
    "  robot_effector_frame: tool0\n"
    "  tracking_base_frame: camera_depth_optical_frame\n"
    "  tracking_marker_frame: camera_marker\n"
    "transformation:\n"
    "  qw: 0.7071067811865476\n"
    "  qx: 0.0\n"
    "  qy: 0.0\n"
    "  qz: 0.7071067811865475\n"
    "  x: 0.0123456789\n"
    "  y: -0.0678\n"
    "  z: 0.091\n";

TEST_F(HandEyeFiles, EasyHandeyeIsReadAndWrittenAsItIs) {
  write_file(path, kEasyHandEye);
  const EasyHandEye read = read_easy_handeye(path);
  EXPECT_EQ(read.mount, CameraMount::kOnHand);
  EXPECT_NEAR(read.T_A_C.translation().x(), 0.0123456789, 1e-15);
  EXPECT_NEAR((read.T_A_C.linear() * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(), 0, 1e-12);
  write_easy_handeye(path, read);
  const EasyHandEye again = read_easy_handeye(path);
  EXPECT_EQ(again.parameters, read.parameters);
  EXPECT_LT((again.T_A_C.matrix() - read.T_A_C.matrix()).norm(), 1e-15);
  const std::string text = read_file(path, 100000), expected = kEasyHandEye;
  EXPECT_EQ(text.substr(0, text.find("  qw")), expected.substr(0, expected.find("  qw")));
  EXPECT_EQ(text.substr(text.find("  x:")), expected.substr(expected.find("  x:")));
}

// Each line as PyYAML 6.0 dumps that value: text that looks like something else, nothing, a truth value.
TEST_F(HandEyeFiles, ParametersOfEasyHandeyeKeepTheirTypeAndTheirQuotes) {
  const std::string parameters =
      "parameters:\n"
      "  empty: ''\n"
      "  eye_on_hand: false\n"
      "  freehand_robot_movement: true\n"
      "  label: 'it''s: a # label'\n"
      "  move_group: null\n"
      "  queue_size: 10\n"
      "  serial: '007'\n"
      "  tabbed: \"a\\tb\"\n"
      "  verbose: 'true'\n";
  const std::string rest =
      std::string(kEasyHandEye).substr(std::string(kEasyHandEye).find("transformation:"));
  write_file(path, parameters + rest);
  const EasyHandEye read = read_easy_handeye(path);
  EXPECT_EQ(read.mount, CameraMount::kOnBase);
  ASSERT_EQ(read.parameters.size(), 8U);
  EXPECT_EQ(read.parameters[2], (EasyHandEyeParameter{"label", "it's: a # label", false, true}));
  EXPECT_EQ(read.parameters[3], (EasyHandEyeParameter{"move_group", "", true, false}));
  write_easy_handeye(path, read);
  const std::string text = read_file(path, 100000);
  EXPECT_EQ(text.substr(0, text.find("transformation:")), parameters);
}

TEST_F(HandEyeFiles, AddedParametersAreQuotedWhereTheyMustBe) {
  EasyHandEye own;
  own.parameters = {{"label", "a: b"}, {"odd: key", "- x"}};
  write_easy_handeye(path, own);
  const EasyHandEye read = read_easy_handeye(path);
  ASSERT_EQ(read.parameters.size(), 2U);
  EXPECT_EQ(read.parameters[0].value, "a: b");
  EXPECT_EQ(read.parameters[1].key, "odd: key");
  EXPECT_EQ(read.parameters[1].value, "- x");
}

// As easy_handeye2 writes it (ROS 2's message_to_yaml); values made up.
constexpr const char* kEasyHandEye2 =
    "parameters:\n"
    "  name: ur10_sr300\n"
    "  calibration_type: eye_in_hand\n"
    "  robot_base_frame: base_link\n"
    "  robot_effector_frame: tool0\n"
    "  tracking_base_frame: camera_depth_optical_frame\n"
    "  tracking_marker_frame: camera_marker\n"
    "  freehand_robot_movement: true\n"
    "  move_group_namespace: /\n"
    "  move_group: manipulator\n"
    "transform:\n"
    "  translation:\n"
    "    x: 0.0123456789\n"
    "    y: -0.0678\n"
    "    z: 0.091\n"
    "  rotation:\n"
    "    x: 0.0\n"
    "    y: 0.6\n"
    "    z: 0.0\n"
    "    w: 0.8\n";

TEST_F(HandEyeFiles, EasyHandeye2IsReadAndWrittenInItsOwnFormat) {
  write_file(path, kEasyHandEye2);
  const EasyHandEye read = read_easy_handeye(path);
  EXPECT_TRUE(read.of_ros2);
  EXPECT_EQ(read.mount, CameraMount::kOnHand);
  EXPECT_NEAR(read.T_A_C.translation().y(), -0.0678, 1e-15);
  // 0.6, 0.8 about y: cos 0.28, sin 0.96
  EXPECT_NEAR((read.T_A_C.linear() * Eigen::Vector3d::UnitX() - Eigen::Vector3d(0.28, 0, -0.96)).norm(), 0,
              1e-12);
  ASSERT_EQ(read.parameters.size(), 8U) << "calibration_type is the mount";
  EXPECT_EQ(read.parameters[2].key, "robot_effector_frame");
  write_easy_handeye(path, read);
  const std::string text = read_file(path, 100000), expected = kEasyHandEye2;
  EXPECT_EQ(text.substr(0, text.find("  rotation")), expected.substr(0, expected.find("  rotation")));
  EXPECT_LT((read_easy_handeye(path).T_A_C.matrix() - read.T_A_C.matrix()).norm(), 1e-15);
  const auto refuses = [&](const std::string& from, const std::string& to) {
    std::string changed = kEasyHandEye2;
    changed.replace(changed.find(from), from.size(), to);
    write_file(path, changed);
    EXPECT_THROW((void)read_easy_handeye(path), FileError) << to;
  };
  refuses("eye_in_hand", "eye_on_hand");
  refuses("w: 0.8", "w: 0.2");
  refuses("y: -0.0678", "y: nan");
  refuses("transform:", "transformation:");
  std::string beside = kEasyHandEye2;
  beside.replace(beside.find("eye_in_hand"), 11, "eye_on_base");
  write_file(path, beside);
  EXPECT_EQ(read_easy_handeye(path).mount, CameraMount::kOnBase);
}

TEST_F(HandEyeFiles, BadEasyHandeyeFilesAreRefusedByName) {
  const auto refuses = [&](const std::string& from, const std::string& to) {
    std::string text = kEasyHandEye;
    text.replace(text.find(from), from.size(), to);
    write_file(path, text);
    EXPECT_THROW((void)read_easy_handeye(path), FileError) << to;
  };
  refuses("eye_on_hand: true", "eye_on_hand: maybe");
  refuses("x: 0.0123456789", "x: nan");
  refuses("qw: 0.7071067811865476", "qw: 0.2");
  refuses("transformation:", "transform:");
}

TEST_F(HandEyeFiles, PairsComeBackAsTheyWereWritten) {
  const HandEyeFile file{CameraMount::kOnBase, stations(CameraMount::kOnBase, {}, 6, 4)};
  write_hand_eye_pairs(path, file);
  const HandEyeFile back = read_hand_eye_pairs(path);
  EXPECT_EQ(back.mount, CameraMount::kOnBase);
  ASSERT_EQ(back.pairs.size(), 4U);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_LT(difference(back.pairs[i].T_R_F, file.pairs[i].T_R_F).translation, 1e-6);
    EXPECT_LT(difference(back.pairs[i].T_C_B, file.pairs[i].T_C_B).angle, 1e-6);
  }
}

}  // namespace
}  // namespace stonestack::kinematics
