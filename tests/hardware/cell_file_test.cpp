#include "stonestack/hardware/cell_file.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "hardware/cell_config.hpp"
#include "stonestack/core/error.hpp"
#include "stonestack/core/file.hpp"
#include "stonestack/kinematics/hand_eye.hpp"
#include "temporary_folder.hpp"

namespace stonestack::hardware {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

class CellFile : public testing::Test {
 protected:
  [[nodiscard]] CellConfig read(const std::string& text) const {
    write_file(path_, text);
    return read_cell_file(path_);
  }
  [[nodiscard]] std::string problem_of(const std::string& text) const {
    try {
      static_cast<void>(read(text));
    } catch (const FileError& error) {
      return error.what();
    }
    return "";
  }
  void TearDown() override { std::filesystem::remove(path_); }

  std::string path_ = test::temporary_folder() + "cell_file_" +
                      testing::UnitTest::GetInstance()->current_test_info()->name() + ".yaml";
};

TEST_F(CellFile, DescribesTheDevicesAndTheirMounts) {
  const CellConfig cell = read(
      "robot: ur5e\n"
      "arm: {address: 192.168.1.10, rtde_port: 31004}\n"
      "gripper: {preset: rtu, device: /dev/ttyUSB0}\n"
      "layout:\n"
      "  T_W_R: {x: 0.1, y: 0, z: 0.02, qx: 0, qy: 0, qz: 0.70710678, qw: 0.70710678}\n"
      "  site: {x: 0.5, y: 0.3}\n");
  EXPECT_EQ(cell.robot, "ur5e");
  EXPECT_EQ(cell.arm.rtde_port, 31004);
  EXPECT_EQ(cell.gripper.preset, "rtu");
  const CellLayout layout = to_layout(cell);
  // The base is turned by a quarter: its x axis is the world's y axis.
  EXPECT_LT((layout.T_W_R * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(0.1, 1, 0.02)).norm(), 1e-6);
  EXPECT_LT((layout.site - Eigen::Vector2d(0.5, 0.3)).norm(), 1e-12);
  EXPECT_TRUE(layout.T_T_C.isApprox(CellLayout{}.T_T_C, 1e-9)) << "what the file leaves out is the default";
}

TEST_F(CellFile, ANamedGripperBringsTipDriverAndStroke) {
  const CellConfig cell = read("hand: robotiq-2f-85\ngripper: {address: 192.168.1.10}\n");
  const CellLayout layout = to_layout(cell);
  EXPECT_EQ(layout.gripper, "robotiq-2f-85");
  EXPECT_NEAR(layout.T_F_T.translation().z(), 0.041 + 0.160, 1e-12);
  EXPECT_TRUE((layout.T_F_T * layout.T_T_C).isApprox(CellLayout{}.T_F_T * CellLayout{}.T_T_C, 1e-9))
      << "the camera stays on the flange";
  EXPECT_EQ(cell.gripper_driver, "robotiq_2f");
  const TwoFingerOptions options = two_finger_options(cell);
  EXPECT_EQ(options.link, "urcap");
  EXPECT_EQ(options.modbus.address, "192.168.1.10");
  EXPECT_EQ(options.modbus.port, 63352);
  EXPECT_EQ(options.max_opening, 0.085);
  EXPECT_EQ(options.max_force, 235.0);
  const CellConfig plain = read("robot: ur10\n");
  EXPECT_EQ(plain.gripper_name, "robotiq-3f");
  EXPECT_EQ(plain.gripper_driver, "robotiq_3f");
  EXPECT_EQ(plain.gripper.modbus.port, 502);
}

TEST_F(CellFile, ItsOwnFiguresGoBeforeTheGrippers) {
  const CellConfig cell = read(
      "hand: robotiq-2f-140\n"
      "gripper: {link: rtu, device: /dev/ttyUSB0, closed_count: 226, port: 63353}\n"
      "layout: {T_F_T: {x: 0, y: 0, z: 0.3, qx: 0, qy: 0, qz: 0, qw: 1}}\n");
  EXPECT_EQ(to_layout(cell).T_F_T.translation().z(), 0.3);
  EXPECT_EQ(two_finger_options(cell).closed_count, 226.0);
  EXPECT_EQ(two_finger_options(cell).modbus.port, 63353);
  EXPECT_EQ(two_finger_options(cell).max_opening, 0.14);
}

TEST_F(CellFile, AGrippersFileLiesBesideTheCellFile) {
  const std::string name = "cell_file_gripper.yaml", path = test::temporary_folder() + name;
  std::string text = read_file(data_path("grippers/robotiq-hand-e.yaml"), std::size_t{1} << 16);
  text.replace(text.find("tip: 0.1565"), 11, "tip: 0.2000");
  write_file(path, text);
  const CellLayout layout = to_layout(read("hand: " + name + "\n"));
  EXPECT_NEAR(layout.T_F_T.translation().z(), 0.241, 1e-12);
  std::filesystem::remove(path);
  EXPECT_THAT(problem_of("hand: " + name + "\n"), HasSubstr(name));
}

TEST_F(CellFile, TheArmsOwnSensorBringsTipMassAndRange) {
  const CellConfig cell = read("robot: ur10e\nforce_torque: {link: ur}\n");
  const CellLayout layout = to_layout(cell);
  EXPECT_NEAR(layout.T_F_T.translation().z(), 0.223, 1e-12) << "the gripper alone";
  EXPECT_EQ(layout.sensor_mass, 0.0);
  EXPECT_TRUE(layout.T_T_C.isApprox(CellLayout{}.T_T_C)) << "the camera stays on the gripper";
  EXPECT_EQ(cell.force_torque.max_force, 100.0);
  EXPECT_EQ(cell.force_torque.max_torque, 10.0);
  EXPECT_EQ(read("robot: ur5e\nforce_torque: {link: ur}\n").force_torque.max_force, 50.0);
  const CellConfig narrow = read("robot: ur10e\nhand: robotiq-2f-85\nforce_torque: {link: ur}\n");
  EXPECT_NEAR(to_layout(narrow).T_F_T.translation().z(), 0.160, 1e-12);
  const CellConfig coupled = read(
      "force_torque: {link: ur, max_force: 80}\n"
      "layout: {sensor_mass: 0.1, T_F_T: {x: 0, y: 0, z: 0.233, qx: 0, qy: 0, qz: 0, qw: 1}}\n");
  EXPECT_EQ(to_layout(coupled).T_F_T.translation().z(), 0.233) << "the file's own figures go before";
  EXPECT_EQ(coupled.sensor_mass, 0.1);
  EXPECT_EQ(coupled.force_torque.max_force, 80.0);
  EXPECT_THAT(problem_of("force_torque: {link: ur, yaw: 0.5}\n"), HasSubstr("axes of the flange"));
  EXPECT_THAT(problem_of("force_torque: {link: usb}\n"), HasSubstr("serial, ur_cap, ur"));
}

TEST_F(CellFile, RefusesADriverThatDoesNotFitTheGripper) {
  EXPECT_THAT(
      problem_of("gripper: {driver: robotiq_2f}\n"),
      AllOf(HasSubstr("gripper.driver is robotiq_2f, the gripper is robotiq-3f"), HasSubstr("robotiq_3f")));
  EXPECT_THAT(problem_of("hand: robotiq-2f-140\ngripper: {driver: robotiq_3f}\n"), HasSubstr("robotiq_2f"));
  EXPECT_THAT(problem_of("gripper: {driver: robotiq}\n"), HasSubstr("write one of robotiq_3f, robotiq_2f"));
  EXPECT_THAT(problem_of("gripper: {link: tcp}\n"), HasSubstr("write one of urcap, rtu"));
  EXPECT_THAT(problem_of("hand: robotiq-2f\n"), AllOf(HasSubstr("robotiq-2f"), HasSubstr("robotiq-2f-85")));
}

TEST_F(CellFile, NamesTheObstaclesAndTheGrippersMass) {
  const CellLayout layout = to_layout(
      read("layout:\n  sensor_mass: 0.3\n  obstacles:\n    - name: wall\n      box: {x: 0.1, y: 1, z: 1}\n"
           "      T_W_O: {x: 0.4, y: 0, z: 0.5, qx: 0, qy: 0, qz: 0, qw: 1}\n"));
  ASSERT_EQ(layout.obstacles.size(), 1u);
  EXPECT_EQ(layout.obstacles[0].name, "wall");
  EXPECT_NEAR(layout.obstacles[0].T_W_O.translation().x(), 0.4, 1e-12);
  EXPECT_DOUBLE_EQ(layout.sensor_mass, 0.3);
  EXPECT_THAT(problem_of("layout: {obstacles: [{name: wall, box: {x: 0, y: 1, z: 1}}]}\n"),
              HasSubstr("layout.obstacles[0].box.x is 0"));
  EXPECT_THAT(problem_of("layout: {obstacles: wall}\n"), HasSubstr("layout.obstacles is not a list"));
  EXPECT_THAT(problem_of("layout: {site: [1, 2]}\n"), HasSubstr("layout.site"));
}

TEST_F(CellFile, TakesTheCameraInTheFlangeFromACalibration) {
  EasyHandEye calibration;
  calibration.T_A_C = make_pose({0.03, -0.06, 0.08}, Eigen::Quaterniond(0.95, 0.05, -0.1, 0.25));
  const std::string name = "cell_file_gripper_eye.yaml";
  write_easy_handeye(test::temporary_folder() + name, calibration);
  const std::string beside = "layout:\n  hand_eye: " + name + "\n";
  const CellLayout layout = to_layout(read(beside));
  EXPECT_TRUE((layout.T_F_T * layout.T_T_C).isApprox(calibration.T_A_C, 1e-12));
  EXPECT_NEAR(layout.T_T_C.translation().z(), 0.08 - 0.264, 1e-12);
  const CellLayout longer =
      to_layout(read("layout:\n  T_F_T: {z: 0.3}\n  hand_eye: " + test::temporary_folder() + name + "\n"));
  EXPECT_NEAR(longer.T_T_C.translation().z(), 0.08 - 0.3, 1e-12);
  // as ROS' easy_handeye writes it
  write_file(test::temporary_folder() + name,
             "parameters:\n  eye_on_hand: true\n  freehand_robot_movement: false\n"
             "  robot_base_frame: base_link\n  robot_effector_frame: tool0\n"
             "  tracking_base_frame: camera_depth_optical_frame\n  tracking_marker_frame: aruco\n"
             "transformation: {qw: 1.0, qx: 0.0, qy: 0.0, qz: 0.0, x: 0.01, y: 0.02, z: 0.1}\n");
  EXPECT_NEAR(to_layout(read(beside)).T_T_C.translation().z(), 0.1 - 0.264, 1e-12);

  EXPECT_THAT(problem_of(beside + "  T_T_C: {x: 0, y: 0.1, z: -0.1, qx: 0, qy: 0, qz: 0, qw: 1}\n"),
              AllOf(HasSubstr(path_), HasSubstr("layout.T_T_C and layout.hand_eye")));
  EXPECT_THAT(problem_of(beside + "  T_T_C: {qw: 1}\n"), HasSubstr("layout.T_T_C and layout.hand_eye"))
      << "also where the numbers are the default";
  EXPECT_THAT(problem_of("layout: {hand_eye: none.yaml}\n"), HasSubstr("none.yaml"));
  calibration.mount = CameraMount::kOnBase;
  write_easy_handeye(test::temporary_folder() + name, calibration);
  EXPECT_THAT(problem_of(beside), AllOf(HasSubstr(name), HasSubstr("beside the arm")));
  std::filesystem::remove(test::temporary_folder() + name);
}

TEST_F(CellFile, RefusesWhatCannotBe) {
  EXPECT_THAT(problem_of("layout: {T_T_C: {qw: 0.5}}\n"), HasSubstr("layout.T_T_C"));
  EXPECT_THAT(problem_of("arm: {rtde_prt: 30004}\n"), HasSubstr("did you mean arm.rtde_port"));
  EXPECT_THAT(problem_of("layout: {site: {x: .nan}}\n"), HasSubstr("layout.site.x"));
  EXPECT_THAT(problem_of("layout: {site: {x: 900}}\n"), HasSubstr("900"));
  EXPECT_THAT(problem_of("layout: {site: {x: 900}}\n"), HasSubstr("config cell"));
  EXPECT_NE(problem_of("arm: [1, 2\n"), "");
}

TEST_F(CellFile, NamesFileAndWordsThatItMayHave) {
  const auto refuses = [&](const std::string& text, const std::string& what, const std::string& instead) {
    EXPECT_THAT(problem_of(text), AllOf(HasSubstr(path_), HasSubstr(what), HasSubstr(instead)));
  };
  refuses("gripper: {preset: tcp2020}\n", "gripper.preset is 'tcp2020'", "tcp2018, tcp2014, rtu");
  refuses("gripper: {mode: pinc}\n", "gripper.mode is 'pinc'", "basic, pinch, wide, scissor");
  refuses("force_torque: {link: usb}\n", "force_torque.link is 'usb'", "serial, ur_cap");
  refuses("camera: {driver: kinect}\n", "camera.driver is 'kinect'", "stream, v4l2, realsense, recorded");
  refuses("camera: {driver: v4l2, v4l2: {fx: 400, fy: 400}}\n", "camera.v4l2: depth_scale is not given", "");
  refuses("arm: {address: 127.0.0.1}\ngripper: {}\narm: {address: 127.0.0.2}\n", "'arm' stands twice",
          "line 3");
}

TEST_F(CellFile, NamesTheFileThatHasNoAddressOfTheArm) {
  const auto problem = [&](const std::string& text) -> std::string {
    try {
      HardwareCell(read(text));
    } catch (const FileError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_THAT(problem(""), AllOf(HasSubstr(path_), HasSubstr("arm.address is missing")));
  EXPECT_THAT(problem("robot: ur10\n"), HasSubstr("arm.address is missing"));
}

TEST_F(CellFile, NamesTheFileWhoseCameraLacksSettings) {
  const std::string folder = test::temporary_folder() + "cell_file_frames";
  std::filesystem::create_directories(folder);
  write_file(folder + "/frames.z16", "not yet a frame");
  CellConfig cell = read("camera: {driver: recorded, recorded: {path: " + folder +
                         "/frames.z16, format: z16, fx: 400, fy: 400}}\n");
  try {
    static_cast<void>(make_camera(cell));
    ADD_FAILURE() << "a depth scale is never guessed";
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), AllOf(HasSubstr(path_), HasSubstr("depth_scale")));
  }
  std::filesystem::remove_all(folder);
}

TEST_F(CellFile, TheTemplateForALabIsReadable) {
  bool simulate = true;
  const CellConfig cell = read_cell_file(data_path("cells/lab-ur10.yaml"), {field("simulate", simulate, "")});
  EXPECT_FALSE(simulate);
  EXPECT_EQ(cell.camera, "v4l2");
}

}  // namespace
}  // namespace stonestack::hardware
