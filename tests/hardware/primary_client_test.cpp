#include "hardware/ur/primary_client.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <limits>
#include <mutex>

#include "hardware/fake_server.hpp"
#include "hardware/safety_state.hpp"
#include "protocol/big_endian.hpp"
#include "protocol/hex.hpp"

namespace stonestack::hardware {
namespace {

using Kind = PrimaryMessage::Kind;
using testing::AllOf;
using testing::HasSubstr;

// Frames written by hand: size, type 20, time stamp, source, kind, and what belongs to it.
const std::string kVersion =
    hex("00000033 14 0000000000000001 FE 03 09 'URControl' 03 0F 00000008 00019F63 '05-11-2021,00:00'");
const std::string kReadOnly =
    hex("00000026 14 0000000000000002 FD 06 000000D2 00000000 00000003 00000000 00000000 'no!'");
const std::string kStarted =
    hex("0000002E 14 0000000000000003 FD 07 00000000 00000000 13 'PROGRAM_XXX_STARTED' 'stk'");
const std::string kException = hex("00000022 14 0000000000000004 FD 0A 00000007 00000003 'type error!'");
const std::string kSafety = hex("00000020 14 0000000000000005 FD 05 000000D2 00000001 03 00000000 00000000");
const std::string kPrimaryClientText = hex("00000013 14 0000000000000006 FE 00 'abcd'");
const std::string kState = hex("00000008 10 01 02 03");

PrimaryMessage message(const std::string& bytes) {
  PrimaryStream stream;
  stream.feed(bytes);
  auto found = stream.next();
  EXPECT_TRUE(found) << stream.problem();
  return found.value_or(PrimaryMessage{});
}

TEST(PrimaryWire, Messages) {
  const PrimaryMessage version = message(kVersion);
  EXPECT_EQ(version.kind, Kind::kVersion);
  EXPECT_EQ(version.version, (UrVersion{3, 15, 8, 106339}));
  EXPECT_EQ(version.title, "URControl");
  EXPECT_EQ(version.source, -2);
  const PrimaryMessage error = message(kReadOnly);
  EXPECT_TRUE(is_read_only_error(error));
  EXPECT_EQ(error.level, 3);
  EXPECT_EQ(error.text, "no!");
  const PrimaryMessage key = message(kStarted);
  EXPECT_EQ(key.title, "PROGRAM_XXX_STARTED");
  EXPECT_EQ(key.text, "stk");
  EXPECT_FALSE(is_read_only_error(key));
  const PrimaryMessage exception = message(kException);
  EXPECT_EQ(exception.kind, Kind::kRuntimeException);
  EXPECT_EQ(exception.line, 7);
  EXPECT_EQ(exception.column, 3);
  EXPECT_EQ(exception.text, "type error!");
  EXPECT_EQ(exception.timestamp, 4u);
  EXPECT_EQ(message(kSafety).level, 3);
  EXPECT_EQ(message(kPrimaryClientText).text, "abcd");
}

TEST(PrimaryWire, EncodesTheSameBytes) {
  for (const auto& bytes : {kVersion, kReadOnly, kStarted, kException, kSafety, kPrimaryClientText})
    EXPECT_EQ(encode(message(bytes)), bytes);
}

TEST(PrimaryWire, CutAtEveryByteAndOtherPackagesPassedOver) {
  const std::string bytes = kVersion + kState + kException + kState;
  for (std::size_t cut = 0; cut <= bytes.size(); ++cut) {
    PrimaryStream stream;
    int count = 0;
    for (const auto& part : {bytes.substr(0, cut), bytes.substr(cut)}) {
      stream.feed(part);
      while (stream.next()) ++count;
    }
    EXPECT_EQ(count, 2) << "cut at " << cut;
    EXPECT_EQ(stream.passed_over(), 2);
  }
}

TEST(PrimaryWire, BrokenLengthsAndShortBodies) {
  for (const char* bytes : {"00000000 14", "00000004 14", "FFFFFFFF 14", "00010001 14", "80000000 10"}) {
    PrimaryStream stream;
    stream.feed(hex(bytes));
    EXPECT_FALSE(stream.next());
    EXPECT_NE(stream.problem(), "") << bytes;
  }
  PrimaryStream stream;
  stream.feed(hex("00000005 14  00000010 14 0000000000000004 FD 0A 00") + kPrimaryClientText);
  EXPECT_EQ(stream.next().value_or(PrimaryMessage{}).text, "abcd") << "a message cut short is passed over";
  EXPECT_EQ(stream.passed_over(), 2);
}

/// A robot state with another part before the kinematics, of which `table` holds theta, a, d and alpha of all
/// joints and the first `kept` bytes are there.
std::string state_with(const std::array<double, 24>& table, std::size_t kept = std::string::npos) {
  std::string kinematics;
  for (int joint = 0; joint < 6; ++joint) put(kinematics, std::uint32_t{7});  // checksums
  put(kinematics, table);
  put(kinematics, std::uint32_t{2});  // status of the calibration
  kinematics.erase(std::min(kept, kinematics.size()));
  std::string parts = hex("00000007 00 0102");
  put(parts, static_cast<std::uint32_t>(kinematics.size() + 5));
  put(parts, std::uint8_t{5});
  parts += kinematics;
  std::string package;
  put(package, static_cast<std::uint32_t>(parts.size() + 5));
  put(package, std::uint8_t{16});
  return package + parts;
}

TEST(PrimaryWire, KinematicsOfAStateAreReadAndBrokenOnesLeftOut) {
  std::array<double, 24> table{};
  for (std::size_t k = 0; k < table.size(); ++k) table[k] = 0.5 * static_cast<double>(k);
  PrimaryStream stream;
  stream.feed(kState + state_with(table, 28));
  EXPECT_FALSE(stream.next());
  EXPECT_FALSE(stream.kinematics()) << "cut off within theta";
  table[9] = std::numeric_limits<double>::quiet_NaN();
  stream.feed(state_with(table));
  EXPECT_FALSE(stream.next());
  EXPECT_FALSE(stream.kinematics()) << "not a number";
  table[9] = -1.0;
  stream.feed(state_with(table) + kVersion + kState);
  EXPECT_TRUE(stream.next());
  ASSERT_TRUE(stream.kinematics());
  EXPECT_EQ(stream.kinematics()->theta[5], 2.5);
  EXPECT_EQ(stream.kinematics()->a[3], -1.0);
  EXPECT_EQ(stream.kinematics()->d[0], 6.0);
  EXPECT_EQ(stream.kinematics()->alpha[5], 11.5);
  EXPECT_EQ(stream.problem(), "");
}

TEST(PrimaryWire, TheSafetyChecksumOfAStateIsReadAndABrokenOneLeftOut) {
  PrimaryStream stream;
  stream.feed(kState + state_with_safety("57F428", 3));
  EXPECT_FALSE(stream.next());
  EXPECT_FALSE(stream.safety_checksum()) << "cut off";
  stream.feed(state_with_safety("57F4285B"));
  EXPECT_FALSE(stream.next());
  ASSERT_TRUE(stream.safety_checksum());
  EXPECT_EQ(*stream.safety_checksum(), 0x57F4285BU);
  stream.feed(state_with_safety("00000001") + kState);
  EXPECT_FALSE(stream.next());
  EXPECT_EQ(*stream.safety_checksum(), 1U) << "the newest state that says one";
  EXPECT_EQ(stream.problem(), "");
  EXPECT_EQ(checksum_text(0x57F4285BU), "57F4285B");
  EXPECT_EQ(parse_checksum("57f4285B"), 0x57F4285BU);
  for (const char* none : {"", "57F4285", "57F4285B0", "57F4285G", "-7F4285B", "0x57F428"})
    EXPECT_FALSE(parse_checksum(none)) << none;
}

TEST(PrimaryWire, AnotherSafetyConfigurationIsNamedWithBothChecksums) {
  EXPECT_EQ(describe_other_safety(std::nullopt, ""), "");
  EXPECT_EQ(describe_other_safety(1U, ""), "");
  EXPECT_EQ(describe_other_safety(1U, "00000001"), "");
  EXPECT_THAT(describe_other_safety(2U, "00000001"), AllOf(HasSubstr("00000002"), HasSubstr("00000001")));
  EXPECT_THAT(describe_other_safety(std::nullopt, "00000001"),
              AllOf(HasSubstr("says no checksum"), HasSubstr("00000001")));
  EXPECT_THROW(static_cast<void>(describe_other_safety(1U, "1")), InvalidArgument);
}

/// Speaks `hello` to every client and keeps what they send.
struct FakePrimary {
  explicit FakePrimary(std::string hello, std::function<std::string(const std::string&, int)> answer = {})
      : server([this, hello = std::move(hello), answer = std::move(answer)](TcpStream& stream, int n) {
          if (!stream.write_all(hello, Deadline::in(1.0))) return;
          while (!server.ending()) {
            std::array<std::uint8_t, 4096> bytes{};
            const IoResult read = stream.read_some(bytes, Deadline::in(0.02));
            if (read.status == IoStatus::kClosed) return;
            const std::string text(reinterpret_cast<const char*>(bytes.data()), read.bytes);
            {
              const std::lock_guard lock(mutex);
              received += text;
            }
            if (text.empty() || !answer) continue;
            if (!stream.write_all(answer(text, n), Deadline::in(1.0))) return;
          }
        }) {}
  ~FakePrimary() { server.stop(); }
  std::string text() {
    const std::lock_guard lock(mutex);
    return received;
  }
  std::mutex mutex;
  std::string received;
  FakeServer server;
};

int closed_port() {
  const TcpListener listener{ListenOptions{}};
  return listener.endpoint().port;
}

TEST(PrimaryClient, SendsAndHears) {
  FakePrimary robot(kVersion, [](const std::string&, int) { return kState + kStarted + kException; });
  PrimaryClient client("127.0.0.1", {{robot.server.port()}, 0.5, 0.5});
  client.send("def a():\nend\n");
  std::vector<PrimaryMessage> heard;
  ASSERT_TRUE(eventually([&] {
    for (auto& m : client.take_messages()) heard.push_back(m);
    return heard.size() >= 3;
  }));
  EXPECT_EQ(heard[0].kind, Kind::kVersion);
  EXPECT_EQ(heard[2].line, 7);
  EXPECT_EQ(robot.text(), "def a():\nend\n");
  EXPECT_THROW(client.send("def a():\nend"), InvalidArgument);
}

TEST(PrimaryClient, FallsBackToTheNextPort) {
  FakePrimary robot(kVersion);
  const int closed = closed_port();
  const PrimaryClient client("127.0.0.1", {{closed, robot.server.port()}, 0.5, 0.5});
  EXPECT_EQ(client.port(), robot.server.port());
  try {
    const PrimaryClient none("127.0.0.1", {{closed, closed}, 0.5, 0.5});
    FAIL();
  } catch (const DeviceError& error) {
    EXPECT_THAT(error.what(), HasSubstr(std::to_string(closed)));
    EXPECT_THAT(error.what(), HasSubstr("security settings"));
  }
}

TEST(PrimaryClient, DistinguishesAControllerFromOtherListeners) {
  const auto problem_of = [](const std::string& hello) -> std::string {
    FakePrimary server(hello);
    const PrimaryClient client("127.0.0.1", {{server.server.port()}, 0.5, 0.5});
    try {
      client.wait_until_heard(Deadline::in(hello.empty() ? 0.2 : 20.0));
    } catch (const DeviceError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(problem_of(kVersion), "");
  EXPECT_EQ(problem_of(kPrimaryClientText + kState), "");
  EXPECT_THAT(problem_of(""), AllOf(HasSubstr("127.0.0.1:"), HasSubstr("neither its version"),
                                    HasSubstr("arm.primary_port")));
  EXPECT_THAT(problem_of("HTTP/1.1 400 Bad Request\r\n"), HasSubstr("no UR controller: package of"));
}

TEST(PrimaryClient, TheSafetyChecksumIsNotWaitedForWhereStatesLackIt) {
  FakePrimary says(kState + state_with_safety("57F4285B"));
  const PrimaryClient client("127.0.0.1", {{says.server.port()}, 0.5, 0.5});
  EXPECT_EQ(client.wait_for_safety_checksum(Deadline::in(20)), 0x57F4285BU);
  FakePrimary silent(kState + kState + kState);
  const PrimaryClient other("127.0.0.1", {{silent.server.port()}, 0.5, 0.5});
  const Deadline patience = Deadline::in(600);
  EXPECT_FALSE(other.wait_for_safety_checksum(patience));
  EXPECT_FALSE(patience.over());
}

TEST(PrimaryClient, ConnectsAgainWhenTheStreamIsLostOrGarbage) {
  std::atomic<int> scripts{0};
  FakePrimary robot("", [&scripts](const std::string&, int n) {
    ++scripts;
    return n == 0 ? hex("00000000 14") : kPrimaryClientText;
  });
  PrimaryClient client("127.0.0.1", {{robot.server.port()}, 0.5, 0.5});
  client.send("a\n");
  ASSERT_TRUE(eventually([&] { return scripts >= 1; }));
  ASSERT_TRUE(eventually([&] {
    client.send("b\n");
    return robot.server.connections() >= 2;
  }));
  EXPECT_TRUE(eventually([&] { return !client.take_messages().empty(); }));
  client.reconnect();
  EXPECT_TRUE(eventually([&] { return robot.server.connections() >= 3; }));
}

}  // namespace
}  // namespace stonestack::hardware
