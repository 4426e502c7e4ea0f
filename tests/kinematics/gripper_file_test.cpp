#include "kinematics/gripper_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "temporary_folder.hpp"

namespace stonestack::kinematics {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

std::string replaced(std::string text, const std::string& old, const std::string& now) {
  const std::size_t at = text.find(old);
  EXPECT_NE(at, std::string::npos) << old;
  return at == std::string::npos ? text : text.replace(at, old.size(), now);
}

std::string shipped() {
  return read_file(data_path("grippers/robotiq-2f-85.yaml"), std::size_t{1} << 16);
}

const std::string& gripper_test_path() {
  static const std::string path = test::temporary_folder() + "gripper_file_test.yaml";
  return path;
}

/// The error of the shipped file with one text in place of another.
std::string problem_with(const std::string& old, const std::string& now) {
  write_file(gripper_test_path(), replaced(shipped(), old, now));
  try {
    (void)read_gripper_file(gripper_test_path());
  } catch (const FileError& error) {
    return error.what();
  }
  return "";
}

TEST(GripperFile, ReadsWhatComesWithStonestack) {
  EXPECT_THAT(gripper_file_names(),
              testing::ElementsAre("robotiq-2f-140", "robotiq-2f-85", "robotiq-3f", "robotiq-hand-e"));
  for (const std::string& name : gripper_file_names()) {
    const GripperFile file = read_gripper_file(name);
    EXPECT_EQ(file.name, name);
    EXPECT_EQ(file.against, name == "robotiq-3f" ? 2 : 1);
  }
  const GripperFile file = read_gripper_file("robotiq-2f-85");
  EXPECT_EQ(file.max_opening, 0.085);
  EXPECT_EQ(file.max_force, 235.0);
  EXPECT_EQ(file.tips.front().advance, 0.0135);
  EXPECT_EQ(file.boxes.size(), 8u);
  EXPECT_TRUE(file.boxes.back().camera);
}

TEST(GripperFile, ReadsAFileOfOnesOwn) {
  write_file(gripper_test_path(), replaced(shipped(), "max: 235", "max: 200"));
  EXPECT_EQ(read_gripper_file(gripper_test_path()).max_force, 200.0);
}

TEST(GripperFile, NamesFileKeyUnitAndRange) {
  EXPECT_THAT(
      problem_with("max_opening: 0.085", "max_opening: 85"),
      AllOf(HasSubstr("gripper_file_test.yaml"), HasSubstr("max_opening must be in [0.005, 0.5] m, got 85")));
  EXPECT_THAT(problem_with("mass: 0.925", "mass: heavy"),
              HasSubstr("mass must be a number in [0.01, 20] kg"));
  EXPECT_THAT(problem_with("mass: 0.925", "mass: nan"), HasSubstr("mass must be a number"));
}

TEST(GripperFile, AsksWhatWasMeant) {
  EXPECT_THAT(problem_with("min_object:", "min_objekt:"), HasSubstr("did you mean min_object"));
  EXPECT_THAT(problem_with("  friction:", "  frictoin:"), HasSubstr("did you mean pad.friction"));
}

TEST(GripperFile, RefusesWhatIsMissing) {
  EXPECT_THAT(problem_with("payload: 5.0", "# payload"), HasSubstr("payload is missing [kg]"));
  EXPECT_THAT(problem_with("schema: stonestack.gripper/1", "schema: stonestack.gripper/2"),
              HasSubstr("not stonestack.gripper/1"));
}

TEST(GripperFile, RefusesFiguresThatContradictEachOther) {
  EXPECT_THAT(problem_with("min_object: 0.005", "min_object: 0.09"), HasSubstr("0.09 is not below 0.085"));
  EXPECT_THAT(problem_with("grip: 120", "grip: 500"),
              HasSubstr("force.grip 500 N does not lie in 20 to 235"));
  EXPECT_THAT(problem_with("spacing: 0", "spacing: 0.05"), HasSubstr("against is 1"));
  EXPECT_THAT(problem_with("against: 1", "against: 2"), HasSubstr("does not hold two fingers"));
  EXPECT_THAT(problem_with("opening: 0.02,", "opening: 0.005,"), HasSubstr("tips[2].opening is 0.005"));
  EXPECT_THAT(problem_with("{opening: 0.085, advance: 0}", "{opening: 0.085, advance: 0.001}"),
              HasSubstr("where the advance is 0"));
}

TEST(GripperFile, RefusesBoxesThatAreNone) {
  EXPECT_THAT(problem_with("z: 0.105}, centre", "z: -0.105}, centre"),
              HasSubstr("boxes[4].size.z is -0.105"));
  EXPECT_THAT(problem_with("camera: true", "camera: yes"), HasSubstr("boxes[7].camera is 'yes'"));
  EXPECT_THAT(problem_with("camera: true", "kamera: true"), HasSubstr("boxes[7].kamera is not a key"));
  std::string one_sided = shipped();
  for (std::size_t at = 0; (at = one_sided.find("finger_side: -1", at)) != std::string::npos;)
    one_sided.replace(at, 15, "finger_side: 1");
  write_file(gripper_test_path(), one_sided);
  EXPECT_THROW((void)read_gripper_file(gripper_test_path()), FileError);
}

TEST(GripperFile, NamesTheGrippersThatThereAre) {
  try {
    (void)read_gripper_file("robotiq-2f-58");
    ADD_FAILURE();
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr("gripper 'robotiq-2f-58'"), HasSubstr("robotiq-2f-85")));
  }
  EXPECT_THROW((void)read_gripper_file("no/such/file.yaml"), FileError);
}

}  // namespace
}  // namespace stonestack::kinematics
