#include "stonestack/kinematics/robot_model.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "core/constants.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "temporary_folder.hpp"

namespace stonestack::kinematics {
namespace {

using testing::HasSubstr;

std::string ur10_text() {
  return read_file(STONESTACK_SOURCE_DIR "/data/robots/ur10.urdf", 1 << 20);
}

std::string replaced(std::string text, const std::string& what, const std::string& by) {
  const auto at = text.find(what);
  EXPECT_NE(at, std::string::npos) << what;
  return text.replace(at, what.size(), by);
}

/// Writes `text` to a file and returns read_robot's error; "read" when it was accepted.
std::string answer(const std::string& text) {
  // Of this test alone: others run at the same time and remove theirs.
  const std::string path = concat(test::temporary_folder(), "robot_model_",
                                  testing::UnitTest::GetInstance()->current_test_info()->name(), ".urdf");
  write_file(path, text);
  std::string message = "read";
  try {
    (void)read_robot(path);
  } catch (const FileError& problem) {
    message = problem.what();
    EXPECT_THAT(message, HasSubstr(path));
    EXPECT_EQ(message.find('\n'), std::string::npos) << message;
  }
  std::filesystem::remove(path);
  return message;
}

TEST(RobotModel, KnowsTheSevenArms) {
  EXPECT_THAT(robot_names(), testing::ElementsAre("ur10", "ur10e", "ur16e", "ur3", "ur3e", "ur5", "ur5e"));
}

TEST(RobotModel, DerivesTheDataSheetFromTheUrdf) {
  const RobotModel robot = read_robot("ur10");
  EXPECT_NEAR(robot.d1, 0.1273, 1e-12);
  EXPECT_NEAR(robot.a2, -0.612, 1e-12);
  EXPECT_NEAR(robot.a3, -0.5723, 1e-12);
  EXPECT_NEAR(robot.d4, 0.163941, 1e-12);
  EXPECT_NEAR(robot.d5, 0.1157, 1e-12);
  EXPECT_NEAR(robot.d6, 0.0922, 1e-12);
  EXPECT_LT(robot.dh_offset.cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_TRUE(robot.T_D6_F.isApprox(Pose::Identity(), 1e-12));
  EXPECT_NEAR(robot.T_R_D.linear()(0, 0), -1.0, 1e-12) << "the controller's base is turned by half a turn";
}

TEST(RobotModel, HasLimitsOfTheDataSheet) {
  const RobotModel robot = read_robot("ur10");
  EXPECT_NEAR(robot.upper[0], 2 * kPi, 1e-12);
  EXPECT_NEAR(robot.lower[2], -kPi, 1e-12);
  EXPECT_NEAR(robot.velocity[1], 120.0 * kPi / 180.0, 1e-12);
  EXPECT_NEAR(robot.velocity[3], kPi, 1e-12);
  EXPECT_DOUBLE_EQ(robot.acceleration[0], 1.4);
  EXPECT_DOUBLE_EQ(robot.payload, 10.0);
  EXPECT_DOUBLE_EQ(read_robot("ur3").payload, 3.0);
}

TEST(RobotModel, ReadsCylindersWithSpheresAsCapsules) {
  const RobotModel robot = read_robot("ur10");
  EXPECT_EQ(robot.capsules.size(), 12u) << "the spheres at the ends belong to their cylinders";
  int links = 0;
  for (const auto& capsule : robot.capsules) links |= 1 << capsule.link;
  EXPECT_EQ(links, 0b1111111);
  const auto forearm = std::find_if(robot.capsules.begin(), robot.capsules.end(),
                                    [](const auto& c) { return c.link == 3 && (c.b - c.a).norm() > 0.3; });
  ASSERT_NE(forearm, robot.capsules.end());
  EXPECT_NEAR((forearm->b - forearm->a).norm(), 0.5723, 1e-9);
  EXPECT_NEAR(forearm->a.z(), 0.049042, 1e-9);
}

TEST(RobotModel, UnknownNameListsTheKnownOnes) {
  try {
    (void)read_robot("ur11");
    FAIL();
  } catch (const FileError& problem) {
    EXPECT_THAT(problem.what(), HasSubstr("ur11"));
    EXPECT_THAT(problem.what(), HasSubstr("ur10, ur10e"));
  }
  EXPECT_THROW((void)read_robot("/nowhere/ur10.urdf"), FileError);
  EXPECT_THROW((void)read_robot(""), FileError);
}

TEST(RobotModel, SearchesTheFolderOfTheEnvironmentFirst) {
  const std::string folder = test::temporary_folder() + "robot_model_data";
  write_file(folder + "/robots/mine.urdf", ur10_text());
  ASSERT_EQ(::setenv("STONESTACK_DATA", folder.c_str(), 1), 0);
  EXPECT_THAT(robot_names(), testing::ElementsAre("mine"));
  EXPECT_NEAR(read_robot("mine").d1, 0.1273, 1e-12);
  EXPECT_NEAR(read_robot("ur5").d1, 0.089159, 1e-12) << "those that come along stay known";
  ASSERT_EQ(::unsetenv("STONESTACK_DATA"), 0);
  EXPECT_THROW((void)read_robot("mine"), FileError);
  std::filesystem::remove_all(folder);
}

/// An axis other than z is the same robot: UR's older descriptions have y axes.
TEST(RobotModel, TakesAnyAxisDirection) {
  auto text = ur10_text();
  // Elbow about y of a frame turned so that its y is the old z; the forearm's own frame turns back.
  text = replaced(text, "<origin xyz=\"-0.612 0 0\" rpy=\"0 0 0\"/>\n    <axis xyz=\"0 0 1\"/>",
                  "<origin xyz=\"-0.612 0 0\" rpy=\"1.5707963267948966 0 0\"/>\n    <axis xyz=\"0 1 0\"/>");
  text = replaced(text, "<origin xyz=\"-0.5723 0 0.163941\" rpy=\"0 0 0\"/>",
                  "<origin xyz=\"-0.5723 0.163941 0\" rpy=\"-1.5707963267948966 0 0\"/>");
  const std::string path = test::temporary_folder() + "robot_model_axis.urdf";
  write_file(path, text);
  const RobotModel robot = read_robot(path);
  std::filesystem::remove(path);
  EXPECT_NEAR(robot.a3, -0.5723, 1e-9);
  EXPECT_NEAR(robot.d4, 0.163941, 1e-9);
  EXPECT_FALSE(robot.calibrated);
}

TEST(RobotModel, RefusesBrokenTrees) {
  const auto text = ur10_text();
  EXPECT_EQ(answer(text), "read");
  EXPECT_THAT(answer(replaced(text, "</robot>",
                              "<joint name=\"x\" type=\"fixed\"><parent link=\"base_link\"/><child "
                              "link=\"forearm_link\"/></joint></robot>")),
              HasSubstr("two parents"));
  EXPECT_THAT(
      answer(replaced(text, "</robot>",
                      "<link name=\"a\"/><link name=\"b\"/>"
                      "<joint name=\"x\" type=\"fixed\"><parent link=\"a\"/><child link=\"b\"/></joint>"
                      "<joint name=\"y\" type=\"fixed\"><parent link=\"b\"/><child link=\"a\"/></joint>"
                      "</robot>")),
      HasSubstr("loop"));
  EXPECT_NE(answer(replaced(text, "</robot>", "<link name=\"a\"/></robot>")), "read") << "two roots";
  EXPECT_THAT(answer(replaced(text, "<link name=\"tool0\"/>", "")), HasSubstr("URDF"));
  EXPECT_THAT(answer(replaced(text, "</robot>",
                              "<link name=\"jaw\"/><joint name=\"x\" type=\"prismatic\"><parent "
                              "link=\"tool0\"/><child link=\"jaw\"/><axis xyz=\"1 0 0\"/><limit lower=\"0\" "
                              "upper=\"1\" effort=\"1\" velocity=\"1\"/></joint></robot>")),
              HasSubstr("7 movable joints"));
}

TEST(RobotModel, RefusesBadNumbers) {
  const auto text = ur10_text();
  const std::string limit =
      "<limit lower=\"-6.283185307179586\" upper=\"6.283185307179586\" effort=\"330\" "
      "velocity=\"2.0943951023931953\"/>";
  for (const char* bad : {"", "<limit effort=\"1\" velocity=\"1\"/>",
                          "<limit lower=\"nan\" upper=\"1\" effort=\"1\" velocity=\"1\"/>",
                          "<limit lower=\"-inf\" upper=\"inf\" effort=\"1\" velocity=\"1\"/>",
                          "<limit lower=\"1\" upper=\"-1\" effort=\"1\" velocity=\"1\"/>",
                          "<limit lower=\"20\" upper=\"30\" effort=\"1\" velocity=\"1\"/>",
                          "<limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"0\"/>",
                          "<limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"-2\"/>",
                          "<limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1e999\"/>"})
    EXPECT_NE(answer(replaced(text, limit, bad)), "read") << bad;
  EXPECT_NE(answer(replaced(text, "<mass value=\"4.0\"/>", "<mass value=\"-4\"/>")), "read");
  EXPECT_NE(answer(replaced(text, "<mass value=\"4.0\"/>", "<mass value=\"1,5\"/>")), "read");
  EXPECT_NE(answer(replaced(text, "ixx=\"", "ixx=\"-")), "read");
  EXPECT_NE(answer(replaced(text, "xyz=\"0 0 0.1273\"", "xyz=\"0 0 nan\"")), "read");
  EXPECT_NE(answer(replaced(text, "xyz=\"0 0 0.1273\"", "xyz=\"0 0 1e30\"")), "read");
  EXPECT_NE(answer(replaced(text, "<axis xyz=\"0 0 1\"/>", "<axis xyz=\"0 0 0\"/>")), "read");
  EXPECT_NE(answer(replaced(text, "cylinder radius=\"0.092\"", "cylinder radius=\"-1\"")), "read");
  EXPECT_THAT(answer(replaced(text, "<cylinder radius=\"0.092\" length=\"0.0353\"/>",
                              "<mesh filename=\"package://../../etc/passwd\"/>")),
              testing::AllOf(HasSubstr("'package://../../etc/passwd'"), HasSubstr("base_link_inertia")));
}

TEST(RobotModel, NamesTheJointOfABadNumber) {
  const auto text = ur10_text();
  const std::string elbow = "lower=\"-3.141592653589793\"";
  EXPECT_THAT(answer(replaced(text, elbow, "lower=\"nan\"")),
              testing::AllOf(HasSubstr("nan"), HasSubstr("elbow_joint")));
  EXPECT_THAT(answer(replaced(text, "<limit " + elbow, "<mimic joint=\"wrist_1_joint\"/><limit " + elbow)),
              HasSubstr("joint 'elbow_joint' mimics joint 'wrist_1_joint'"));
}

TEST(RobotModel, RefusesAJointThatHardlyMoves) {
  const auto message =
      answer(replaced(ur10_text(), "velocity=\"2.0943951023931953\"", "velocity=\"1e-300\""));
  EXPECT_THAT(message, testing::AllOf(HasSubstr("shoulder_pan_joint"), HasSubstr("1e-300 rad/s")));
}

TEST(RobotModel, RefusesAMovingLinkThatNothingCovers) {
  auto text = ur10_text();
  const auto link = text.find("<link name=\"forearm_link\">"), end = text.find("</link>", link);
  for (auto at = text.find("<collision>", link); at < text.find("</link>", link);
       at = text.find("<collision>", link))
    text.erase(at, text.find("</collision>", at) + 12 - at);
  ASSERT_LT(link, end);
  EXPECT_THAT(answer(text), HasSubstr("has no collision shape on forearm_link;"));
}

TEST(RobotModel, RefusesMoreShapesThanAreChecked) {
  std::string spheres;
  for (int i = 0; i < 80; ++i)
    spheres += concat("<collision><origin xyz=\"", 0.01 * i,
                      " 0.3 0\"/><geometry><sphere radius=\"0.01\"/>"
                      "</geometry></collision>");
  EXPECT_THAT(
      answer(replaced(ur10_text(), "<link name=\"forearm_link\">", "<link name=\"forearm_link\">" + spheres)),
      testing::AllOf(HasSubstr("collision shapes"), HasSubstr("at most 48")));
}

TEST(RobotModel, ReportsThatTheWholeChainIsALoop) {
  EXPECT_THAT(answer(replaced(ur10_text(), "</robot>",
                              "<joint name=\"x\" type=\"fixed\"><parent link=\"tool0\"/>"
                              "<child link=\"base_link\"/></joint></robot>")),
              HasSubstr("loop"));
}

TEST(RobotModel, TheRobotOfAYamlIsSoughtBesideIt) {
  const std::string folder = test::temporary_folder() + "robot_model_beside";
  write_file(folder + "/arms/mine.urdf", ur10_text());
  write_file(folder + "/cal/mine.yaml", "robot: ../arms/mine.urdf\npayload: 4\n");
  EXPECT_DOUBLE_EQ(read_robot(folder + "/cal/mine.yaml").payload, 4.0);
  write_file(folder + "/cal/twice.yaml", "robot: ur10\nrobot: ur5\n");
  try {
    (void)read_robot(folder + "/cal/twice.yaml");
    ADD_FAILURE() << "two robots in one file";
  } catch (const FileError& problem) {
    EXPECT_THAT(problem.what(), HasSubstr("the key 'robot' stands twice"));
  }
  std::filesystem::remove_all(folder);
}

TEST(RobotModel, RefusesOtherKinematics) {
  const auto text = ur10_text();
  EXPECT_THAT(answer(replaced(text, "xyz=\"-0.612 0 0\" rpy=\"0 0 0\"", "xyz=\"-0.612 0 0\" rpy=\"1 0 0\"")),
              HasSubstr("parallel"));
  EXPECT_THAT(answer(replaced(text, "xyz=\"0 0 0\" rpy=\"1.5707963267948966 0 0\"",
                              "xyz=\"0.2 0 0\" rpy=\"1.5707963267948966 0 0\"")),
              HasSubstr("a UR's meet"));
  EXPECT_THAT(answer(replaced(text, "xyz=\"-0.612 0 0\"", "xyz=\"0 0 0\"")), HasSubstr("lengths"));
}

TEST(RobotModel, RefusesHostileXml) {
  std::string bomb;
  for (int i = 0; i < 30000; ++i) bomb += "<a>";
  EXPECT_NE(answer(bomb), "read");
  std::string deep = "<robot name=\"x\">";
  for (int i = 0; i < 70; ++i) deep += "<a>";
  for (int i = 0; i < 70; ++i) deep += "</a>";
  EXPECT_THAT(answer(deep + "</robot>"), HasSubstr("deeper"));
  for (const char* bad :
       {"", "robot", "<robot", "<robot name=\"<a>\"/>", "<robot name=\"x\"></a></a></a>", "<!-- <robot/>",
        "<!DOCTYPE x [<!ENTITY a \"b\">]><robot name=\"x\"/>", "<robot name=\"x\"/>", "<robot/>",
        "<?xml version=\"1.0\"?>", "<robot name=\"x\"><link/></robot>", "<robot name='x' ='' \"/>"})
    EXPECT_NE(answer(bad), "read") << bad;
  EXPECT_NE(answer(std::string("<robot\0/>", 9)), "read");
  EXPECT_NE(answer(std::string(2 << 20, ' ')), "read") << "larger than a megabyte";
}

/// Every shorter file is refused or read, never a crash.
TEST(RobotModel, SurvivesTruncationAndNoise) {
  const auto text = ur10_text();
  for (std::size_t size = 0; size < text.size(); size += 97) EXPECT_NE(answer(text.substr(0, size)), "read");
  for (std::size_t at = 5; at < text.size(); at += 211) {
    auto noisy = text;
    noisy[at] = static_cast<char>('!' + at % 90);
    (void)answer(noisy);
  }
}

TEST(RobotModel, ReadsTheYamlBesideAUrdf) {
  const std::string path = test::temporary_folder() + "robot_model_extra.urdf";
  const std::string yaml = test::temporary_folder() + "robot_model_extra.yaml";
  write_file(path, ur10_text());
  write_file(yaml, "payload: 7.5\nacceleration: 2\n");
  const RobotModel robot = read_robot(path);
  EXPECT_DOUBLE_EQ(robot.payload, 7.5);
  EXPECT_DOUBLE_EQ(robot.acceleration[5], 2.0);
  write_file(yaml, "payload: -1\n");
  EXPECT_THROW((void)read_robot(path), FileError);
  std::filesystem::remove(path);
  std::filesystem::remove(yaml);
}

}  // namespace
}  // namespace stonestack::kinematics
