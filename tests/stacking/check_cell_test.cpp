#include "stonestack/stacking/check_cell.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "core/socket.hpp"
#include "hardware/cell_config.hpp"
#include "stacking/check_hand_eye.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::stacking {
namespace {

using testing::HasSubstr;
using Verdict = CellCheck::Verdict;

/// A port on which nobody listens.
int closed_port() {
  return TcpListener(ListenOptions{}).endpoint().port;
}

/// A cell none of whose devices is there.
CellConfig deserted_cell() {
  CellConfig cell;
  const int port = closed_port();
  cell.arm.address = "127.0.0.1";
  cell.arm.rtde_port = cell.arm.primary_port = cell.arm.dashboard_port = port;
  cell.arm.secondary_port = cell.arm.realtime_port = 0;
  cell.arm.rtde.attempts = 1;
  cell.gripper.modbus.address = "127.0.0.1";
  cell.gripper.modbus.port = port;
  cell.force_torque.link = "ur_cap";
  cell.force_torque.port = port;
  cell.stream.address = "127.0.0.1";
  cell.stream.port = port;
  return cell;
}

TEST(CheckCell, EveryDeviceIsCheckedThoughAnotherFails) {
  std::vector<std::string> lines;
  CellCheckOptions options;
  options.on_check = [&](const CellCheck& check) { lines.push_back(to_text(check)); };
  const CellReport report = check_cell(deserted_cell(), options);
  std::vector<std::string> steps;
  for (const CellCheck& check : report.checks) steps.push_back(check.device + ", " + check.step);
  EXPECT_EQ(steps,
            (std::vector<std::string>{"arm, RTDE", "arm, Dashboard", "arm, script port", "gripper, status",
                                      "force sensor, reading", "camera, frames", "cell file, hand-eye"}));
  EXPECT_EQ(report.failed(), 6);
  ASSERT_EQ(lines.size(), report.checks.size());
  for (std::size_t i = 0; i + 1 < lines.size(); ++i) {
    EXPECT_THAT(lines[i], testing::StartsWith("FAIL  " + steps[i] + ": "));
    EXPECT_THAT(lines[i], HasSubstr("127.0.0.1")) << "the address is named";
  }
  EXPECT_THAT(lines.back(), testing::StartsWith("note  cell file, hand-eye: "));
}

/// The gripper of a 2-finger cell is asked over its own link.
TEST(CheckCell, AnAbsentTwoFingerGripperIsNamed) {
  CellConfig cell("robotiq-2f-85");
  const int port = closed_port();
  cell.arm.address = "127.0.0.1";
  cell.arm.rtde_port = cell.arm.primary_port = cell.arm.dashboard_port = port;
  cell.arm.secondary_port = cell.arm.realtime_port = 0;
  cell.arm.rtde.attempts = 1;
  cell.gripper.modbus.port = cell.force_torque.port = cell.stream.port = port;
  cell.force_torque.link = "ur_cap";
  std::string line;
  CellCheckOptions options;
  options.on_check = [&](const CellCheck& check) {
    if (check.device == "gripper") line = to_text(check);
  };
  (void)check_cell(cell, options);
  EXPECT_THAT(line, HasSubstr("(URCap)"));
  EXPECT_THAT(line, HasSubstr("URCap is installed"));
}

TEST(CheckCell, TheReportIsJson) {
  CellReport report;
  report.checks = {{"arm", "RTDE", Verdict::kPassed, "protocol 2"},
                   {"gripper", "status", Verdict::kNote, "not activated"},
                   {"camera", "frames", Verdict::kFailed, "stale \"frame\""}};
  const auto data = nlohmann::json::parse(cell_report_json(report));
  EXPECT_EQ(data.at("schema"), "stonestack.doctor/1");
  const auto& findings = data.at("findings");
  ASSERT_EQ(findings.size(), 3U);
  EXPECT_EQ(
      findings[0],
      (nlohmann::json{
          {"device", "arm"}, {"step", "RTDE"}, {"good", true}, {"to_do", false}, {"text", "protocol 2"}}));
  EXPECT_EQ(findings[1].at("good"), true);
  EXPECT_EQ(findings[1].at("to_do"), true);
  EXPECT_EQ(findings[2].at("good"), false);
  EXPECT_EQ(findings[2].at("text"), "stale \"frame\"");
  EXPECT_EQ(report.failed(), 1);
}

TEST(CheckCell, AnArmWithoutAddressIsMissingInTheCellFile) {
  CellConfig cell = deserted_cell();
  cell.file = "lab.yaml";
  cell.arm.address.clear();
  const CellReport report = check_cell(cell);
  ASSERT_EQ(report.checks.size(), 5U);
  EXPECT_EQ(report.checks.front().device, "cell file");
  EXPECT_THAT(report.checks.front().text, HasSubstr("lab.yaml: arm.address is missing"));
}

// Without a view of the table only a mount that cannot be is refused.
TEST(CheckHandEye, JudgesNumbersAloneWithoutAView) {
  CellConfig cell;
  const Found standard = check_hand_eye(cell, {});
  EXPECT_TRUE(standard.to_do);
  EXPECT_THAT(standard.text, HasSubstr("the arm has not said where it is"));
  CellView view;
  view.q = Joints::Zero();
  EXPECT_THAT(check_hand_eye(cell, view).text, HasSubstr("there is no depth image"));
  cell.camera = "recorded";
  EXPECT_THAT(check_hand_eye(cell, view).text, HasSubstr("a recording"));
  const Pose T_C_T = to_layout(cell).T_T_C.inverse();
  const Eigen::Quaterniond q(T_C_T.linear());
  const Eigen::Vector3d p = T_C_T.translation();
  cell.T_T_C = {p.x(), p.y(), p.z(), q.x(), q.y(), q.z(), q.w()};
  try {
    (void)check_hand_eye(cell, {});
    FAIL() << "the inverse has the camera in front of the finger tips";
  } catch (const DeviceError& problem) {
    EXPECT_THAT(problem.what(), HasSubstr("in front of the finger tips"));
    EXPECT_THAT(problem.what(), HasSubstr("they may be T_C_T"));
  }
}

}  // namespace
}  // namespace stonestack::stacking
