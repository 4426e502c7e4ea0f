#include "hardware/robotiq/gripper_words.hpp"

#include <gmock/gmock.h>

#include "stonestack/core/error.hpp"

namespace stonestack::hardware {
namespace {

using Words = std::vector<std::uint16_t>;
using WordStatus = ThreeFingerStatus;
using Object = ThreeFingerStatus::Axis::Object;

// WordStatus bytes of the manual's TCP examples, two a word.
const Words kMoving{0x39C0, 0x00FF, 0x080F, 0x0008, 0x1000, 0x080F, 0x0089, 0x0000};
const Words kGripped{0xB9EA, 0x00FF, 0xBC00, 0x00C1, 0x0000, 0xBD00, 0x0089, 0x0000};

TEST(GripperWords, TheMovingExampleOfTheManual) {
  const WordStatus s = decode_gripper_status(kMoving);
  EXPECT_TRUE(s.active);
  EXPECT_TRUE(s.go);
  EXPECT_EQ(s.stage, WordStatus::Stage::kReady);
  EXPECT_EQ(s.motion, WordStatus::Motion::kMoving);
  EXPECT_EQ(s.axes[0].request, 255);
  EXPECT_EQ(s.axes[0].position, 8);
  EXPECT_NEAR(s.axes[0].current, 0.15, 1e-12);
  EXPECT_EQ(s.axes[3].position, 0x89);
  EXPECT_EQ(s.axes[3].object, Object::kAtRequest);
}

TEST(GripperWords, TheGrippedExampleOfTheManual) {
  const WordStatus s = decode_gripper_status(kGripped);
  EXPECT_EQ(s.motion, WordStatus::Motion::kAllStopped);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(s.axes[i].object, Object::kContactClosing) << i;
  EXPECT_EQ(s.axes[0].position, 0xBC);
  EXPECT_EQ(s.axes[1].position, 0xC1);
  EXPECT_EQ(s.axes[2].position, 0xBD);
}

TEST(GripperWords, RequestsMatchTheManual) {
  GripperRequest activate;
  EXPECT_EQ(encode(activate).at(0), 0x0100);
  GripperRequest close;
  close.go = true;
  close.axes.fill({255, 255, 255});
  const Words words = encode(close);
  EXPECT_EQ((Words{words[0], words[1], words[2]}), (Words{0x0900, 0x00FF, 0xFFFF}));
}

TEST(GripperWords, IndividualControlFillsEveryAxis) {
  GripperRequest request;
  request.go = request.individual_fingers = request.individual_scissor = true;
  request.mode = GripperMode::kPinch;
  request.axes = {{{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {10, 11, 12}}};
  EXPECT_EQ(encode(request), (Words{0x0B0C, 0x0001, 0x0203, 0x0405, 0x0607, 0x0809, 0x0A0B, 0x0C00}));
}

TEST(GripperWords, RefusesWhatIsOutOfRange) {
  GripperRequest request;
  request.go = true;
  request.axes[0].position = 256;
  EXPECT_THROW((void)encode(request), InvalidArgument);
  EXPECT_THROW((void)decode_gripper_status({1, 2, 3}), InvalidArgument);
  EXPECT_THROW((void)gripper_layout("tcp"), InvalidArgument);
  EXPECT_THROW((void)parse_gripper_mode("fist"), InvalidArgument);
}

TEST(GripperWords, EveryFaultHasAKindAndARemedy) {
  EXPECT_EQ(gripper_fault_text(0), "");
  EXPECT_EQ(gripper_fault_kind(0x7), GripperFaultKind::kPriority);
  EXPECT_EQ(gripper_fault_kind(0xB), GripperFaultKind::kMinor);
  EXPECT_EQ(gripper_fault_kind(0xF), GripperFaultKind::kMajor);
  for (int fault = 1; fault < 16; ++fault) EXPECT_GT(gripper_fault_text(fault).size(), 30U) << fault;
  EXPECT_THAT(gripper_fault_text(0xF), testing::HasSubstr("0x0F: an automatic release is complete"));
}

}  // namespace
}  // namespace stonestack::hardware
