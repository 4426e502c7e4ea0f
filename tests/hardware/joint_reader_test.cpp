#include "hardware/ur/joint_reader.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "hardware/fake_rtde.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::hardware {
namespace {

/// A controller that offers the joint angles and refuses every input register, as one that another client has
/// taken.
FakeRtdePlan plan_of_joints() {
  FakeRtdePlan plan;
  plan.replies = {{'V', {hex("00 04 56 01")}},
                  {'v', {hex("00 13 76 00000003 0000000F 00000008 00019F63")}},
                  {'O', {hex("00 13 4F 01 'DOUBLE,VECTOR6D'")}},
                  {'I', {hex("00 0A 49 00 'IN_USE'")}},
                  {'S', {hex("00 04 53 01")}}};
  plan.data = [](long n) {
    return encode(encode_data(
        {1, {100.0 + 0.008 * static_cast<double>(n), std::array<double, 6>{0.1, 0.2, 0.3, 0.4, 0.5, 0.6}}}, 2,
        true));
  };
  return plan;
}

UrArmOptions options_at(const FakeRtde& server) {
  UrArmOptions options;
  options.address = server.endpoint().address;
  options.rtde_port = server.endpoint().port;
  options.rtde.attempts = 1;
  options.rtde.stale_after = 5.0;
  return options;
}

TEST(JointReader, ReadsBesideAnotherClientAndSendsNothing) {
  FakeRtde server([](int) { return plan_of_joints(); });
  const JointReader reader(options_at(server));
  const JointReading first = reader.read();
  EXPECT_NEAR(first.q[5], 0.6, 1e-12);
  EXPECT_GE(first.device_time, 100.0);
  EXPECT_GE(reader.read().device_time, first.device_time);
  EXPECT_TRUE(server.requests(RtdeKind::kSetupInputs).empty()) << "another client may have the registers";
  EXPECT_TRUE(server.requests(RtdeKind::kDataPackage).empty());
}

TEST(JointReader, NamesAnArmThatDoesNotAnswer) {
  UrArmOptions options;
  options.address = "127.0.0.1";
  options.rtde_port = 1;
  options.rtde.attempts = 1;
  EXPECT_THAT([&] { JointReader reader(options); },
              testing::ThrowsMessage<DeviceError>(testing::HasSubstr("127.0.0.1:1")));
}

}  // namespace
}  // namespace stonestack::hardware
