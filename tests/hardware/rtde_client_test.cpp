#include "hardware/ur/rtde_client.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "hardware/fake_rtde.hpp"
#include "stonestack/core/clock.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::hardware {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

const std::string kAccept = hex("00 04 56 01"), kRefuse = hex("00 04 56 00");
const std::string kRtdeVersion = hex("00 13 76 00000003 0000000F 00000008 00019F63");
const std::string kRtdeStarted = hex("00 04 53 01");
const std::string kRtdeText = hex("00 0C 4D 02 'Hi' 04 'RTDE' 02");

/// timestamp and actual_q of the n-th step, all joints equal.
std::string data(double time, double q = 0.5) {
  return encode(encode_data({1, {time, std::array<double, 6>{q, q, q, q, q, q}}}, 2, true));
}

std::string steady(long n) {
  return data(100.0 + 0.008 * static_cast<double>(n));
}

FakeRtdePlan good_plan() {
  FakeRtdePlan plan;
  plan.replies = {{'V', {kAccept}},
                  {'v', {kRtdeVersion}},
                  {'O', {hex("00 13 4F 01 'DOUBLE,VECTOR6D'")}},
                  {'I', {hex("00 09 49 01 'INT32'")}},
                  {'S', {kRtdeStarted}}};
  plan.data = steady;
  return plan;
}

RtdeRecipe recipe(const UrVersion&) {
  return {{"actual_q"}, {}, {{"input_int_register_24"}}};
}

RtdeOptions quick() {
  RtdeOptions options;
  options.connect_timeout = options.reply_timeout = 0.3;
  options.silent_after = 0.2;
  options.retry_pause = 0.02;
  options.attempts = 2;
  options.boot_timeout = 1.0;
  options.stale_after = 0.15;
  return options;
}

std::string error_of(FakeRtde& server, const RtdeRecipeFor& wanted = recipe,
                     const RtdeOptions& options = quick()) {
  try {
    const RtdeClient client(server.endpoint(), wanted, options);
  } catch (const DeviceError& error) {
    return error.what();
  }
  return {};
}

TEST(RtdeClient, SetsUpReadsAndWrites) {
  FakeRtde server([](int) { return good_plan(); });
  RtdeClient client(server.endpoint(), recipe, quick());
  EXPECT_EQ(client.protocol(), 2);
  EXPECT_EQ(client.version(), (UrVersion{3, 15, 8, 106339}));
  const auto next = client.wait_for_next(Deadline::in(1.0));
  ASSERT_TRUE(next);
  EXPECT_GE(next->device_time(), 100.0);
  EXPECT_LE(std::abs(next->host_time() - host_seconds()), 60.0) << "the clock of all devices";
  EXPECT_EQ((next->get<std::array<double, 6>>("actual_q"))[5], 0.5);
  EXPECT_FALSE(next->has("actual_qd"));
  EXPECT_THROW(static_cast<void>(next->get<double>("actual_q")), InvalidArgument);
  client.send(0, {std::int32_t{258}});
  ASSERT_TRUE(eventually([&] { return !server.requests(RtdeKind::kDataPackage).empty(); }));
  EXPECT_EQ(encode(server.requests(RtdeKind::kDataPackage)[0]), hex("00 08 55 01 00 00 01 02"));
  EXPECT_EQ(encode(server.requests(RtdeKind::kSetupOutputs)[0]),
            hex("00 1D 4F 40 5F 40 00 00 00 00 00 'timestamp,actual_q'"));
  EXPECT_EQ(client.counts().sessions, 1);
}

TEST(RtdeClient, FallsBackToProtocol1) {
  FakeRtde server([](int) {
    FakeRtdePlan plan = good_plan();
    plan.replies['V'] = {kRefuse, kAccept};
    plan.replies['O'] = {hex("00 12 4F 'DOUBLE,VECTOR6D'")};
    plan.data = [](long n) {
      return encode(
          encode_data({0, {100.0 + 0.008 * static_cast<double>(n), std::array<double, 6>{}}}, 1, true));
    };
    return plan;
  });
  RtdeClient client(server.endpoint(), recipe, quick());
  EXPECT_EQ(client.protocol(), 1);
  EXPECT_GE(client.sample().device_time(), 100.0);
  const auto asked = server.requests(RtdeKind::kProtocolVersion);
  ASSERT_EQ(asked.size(), 2u);
  EXPECT_EQ(decode_protocol_request(asked[1]), 1);
}

TEST(RtdeClient, RefusedVersionsAndStart) {
  FakeRtde neither([](int) {
    FakeRtdePlan plan = good_plan();
    plan.replies['V'] = {kRefuse};
    return plan;
  });
  EXPECT_THAT(error_of(neither), HasSubstr("refuses protocol 2 and 1"));
  FakeRtde no_start([](int) {
    FakeRtdePlan plan = good_plan();
    plan.replies['S'] = {hex("00 04 53 00")};
    return plan;
  });
  EXPECT_THAT(error_of(no_start), HasSubstr("refuses to start"));
}

TEST(RtdeClient, TextsBeforeEveryReplyAndBytesOneByOne) {
  FakeRtde server([](int) {
    FakeRtdePlan plan = good_plan();
    plan.before_reply = kRtdeText + kRtdeText;
    plan.byte_by_byte = true;
    return plan;
  });
  RtdeClient client(server.endpoint(), recipe, quick());
  EXPECT_GE(client.sample().device_time(), 100.0);
  const auto texts = client.take_texts();
  ASSERT_EQ(texts.size(), 10u);
  EXPECT_EQ(texts.back().message, "Hi");
  EXPECT_EQ(texts.back().source, "RTDE");
}

TEST(RtdeClient, DropsOptionalOutputsThatAreNotFound) {
  const auto wanted = [](const UrVersion&) {
    return RtdeRecipe{{"actual_q"}, {"tcp_offset", "payload"}, {}};
  };
  FakeRtde server([](int) {
    FakeRtdePlan plan = good_plan();
    plan.replies['O'] = {hex("00 27 4F 00 'DOUBLE,VECTOR6D,NOT_FOUND,NOT_FOUND'"),
                         hex("00 13 4F 01 'DOUBLE,VECTOR6D'")};
    return plan;
  });
  RtdeClient client(server.endpoint(), wanted, quick());
  EXPECT_THAT(client.missing(), ElementsAre("tcp_offset", "payload"));
  const auto setups = server.requests(RtdeKind::kSetupOutputs);
  ASSERT_EQ(setups.size(), 2u);
  EXPECT_EQ(encode(setups[1]), hex("00 1D 4F 40 5F 40 00 00 00 00 00 'timestamp,actual_q'"));
}

TEST(RtdeClient, NamesWhatIsRequiredAndMissing) {
  FakeRtde output([](int) {
    FakeRtdePlan plan = good_plan();
    plan.replies['O'] = {hex("00 14 4F 00 'DOUBLE,NOT_FOUND'")};
    return plan;
  });
  EXPECT_THAT(error_of(output), AllOf(HasSubstr("actual_q"), HasSubstr("3.15.8"), HasSubstr("127.0.0.1:")));
  FakeRtde input([](int) {
    FakeRtdePlan plan = good_plan();
    plan.replies['I'] = {hex("00 0D 49 00 'NOT_FOUND'")};
    return plan;
  });
  EXPECT_THAT(error_of(input), HasSubstr("input_int_register_24"));
}

TEST(RtdeClient, NamesAFieldOfAnotherTypeThanItMustHave) {
  FakeRtde time([](int) {
    FakeRtdePlan plan = good_plan();
    plan.replies['O'] = {hex("00 13 4F 01 'UINT32,VECTOR6D'")};
    return plan;
  });
  EXPECT_THAT(error_of(time),
              AllOf(HasSubstr("timestamp as UINT32, not as DOUBLE"), HasSubstr("127.0.0.1:")));
  FakeRtde joints([](int) {
    FakeRtdePlan plan = good_plan();
    plan.replies['O'] = {hex("00 11 4F 01 'DOUBLE,DOUBLE'")};
    return plan;
  });
  EXPECT_THAT(error_of(joints), HasSubstr("actual_q as DOUBLE, not as VECTOR6D"));
  FakeRtde input([](int) {
    FakeRtdePlan plan = good_plan();
    plan.replies['I'] = {hex("00 0A 49 01 'DOUBLE'")};
    return plan;
  });
  EXPECT_THAT(error_of(input), HasSubstr("input_int_register_24 as DOUBLE, not as INT32"));
}

TEST(RtdeClient, ATypeThatChangesLaterIsALostLink) {
  FakeRtde server([](int connection) {
    FakeRtdePlan plan = good_plan();
    if (connection > 0) plan.replies['O'] = {hex("00 13 4F 01 'UINT32,VECTOR6D'")};
    plan.drop_after_data = true;
    plan.data = [](long n) { return n > 20 ? std::string() : steady(n); };
    return plan;
  });
  RtdeClient client(server.endpoint(), recipe, quick());
  ASSERT_TRUE(eventually([&] { return server.connections() >= 3; }));
  try {
    static_cast<void>(client.version());
    ADD_FAILURE() << "the link must be down";
  } catch (const DeviceError& error) {
    EXPECT_THAT(error.what(), HasSubstr("timestamp as UINT32"));
  }
}

TEST(RtdeClient, ATimestampBeyondAllTimesIsRefused) {
  FakeRtde server([](int) {
    FakeRtdePlan plan = good_plan();
    plan.data = [](long n) { return n == 5 ? data(1e300) : n == 8 ? data(-1e300) : steady(n); };
    return plan;
  });
  RtdeClient client(server.endpoint(), recipe, quick());
  ASSERT_TRUE(eventually([&] { return client.counts().accepted > 30; }));
  EXPECT_EQ(client.counts().refused, 2);
  EXPECT_EQ(client.counts().skipped, 2) << "the refused ones leave gaps, no others";
  EXPECT_EQ(client.counts().sessions, 1);
}

TEST(RtdeClient, RetriesAnInputInUseThenNamesIt) {
  const auto busy_until = [](int free_from) {
    return [free_from](int connection) {
      FakeRtdePlan plan = good_plan();
      if (connection < free_from) plan.replies['I'] = {hex("00 0A 49 00 'IN_USE'")};
      return plan;
    };
  };
  FakeRtde freed(busy_until(3));
  {
    const RtdeClient client(freed.endpoint(), recipe, quick());
    EXPECT_EQ(freed.connections(), 4);
  }
  FakeRtde never(busy_until(1000));
  EXPECT_THAT(error_of(never), AllOf(HasSubstr("input_int_register_24 is in use"), HasSubstr("PROFINET")));
  EXPECT_EQ(never.connections(), 5) << "bounded";
}

TEST(RtdeClient, MalformedRepliesAreErrors) {
  for (const auto& [letter, bytes] : std::map<char, std::string>{{'V', hex("00 05 56 01 01")},
                                                                 {'v', hex("00 04 76 03")},
                                                                 {'O', hex("00 0A 4F 01 'DOUBLE'")},
                                                                 {'I', hex("00 03 49")},
                                                                 {'S', hex("00 03 53")}}) {
    FakeRtde server([letter = letter, bytes = bytes](int) {
      FakeRtdePlan plan = good_plan();
      plan.replies[letter] = {bytes};
      return plan;
    });
    EXPECT_NE(error_of(server), "") << letter;
  }
}

TEST(RtdeClient, SilenceAndClosedPortsAreErrorsInTime) {
  for (const char silent : {'V', 'v', 'O', 'I', 'S'}) {
    FakeRtde server([silent](int) {
      FakeRtdePlan plan = good_plan();
      plan.replies.erase(silent);
      return plan;
    });
    EXPECT_THAT(error_of(server), HasSubstr("no reply to '" + std::string(1, silent))) << silent;
  }
  Endpoint closed;
  {
    const TcpListener listener{ListenOptions{}};
    closed = listener.endpoint();
  }
  EXPECT_THROW(RtdeClient(closed, recipe, quick()), DeviceError);
}

TEST(RtdeClient, WaitsUntilTheControllerHasBooted) {
  const auto booting = [](int) {
    FakeRtdePlan plan = good_plan();
    plan.data = [](long n) { return n < 5 ? data(1.0 + 0.008 * static_cast<double>(n)) : std::string(); };
    return plan;
  };
  FakeRtde server(booting);
  EXPECT_THAT(error_of(server), HasSubstr("booted"));
  FakeRtde long_enough([](int) {
    FakeRtdePlan plan = good_plan();
    plan.data = [](long n) { return data(1.0 + 0.008 * static_cast<double>(n)); };
    return plan;
  });
  EXPECT_EQ(error_of(long_enough), "") << "a second of data shows it too";
}

TEST(RtdeClient, SetsUpAnewAfterADroppedSession) {
  FakeRtde server([](int connection) {
    FakeRtdePlan plan = good_plan();
    plan.drop_after_data = connection == 0;
    plan.data = [connection](long n) {
      return connection == 0 && n > 20 ? "" : steady(n + 1000L * connection);
    };
    return plan;
  });
  RtdeClient client(server.endpoint(), recipe, quick());
  ASSERT_TRUE(eventually([&] { return client.counts().sessions >= 2; }));
  ASSERT_TRUE(client.wait_for_next(Deadline::in(1.0)));
  EXPECT_GE(client.sample().device_time(), 108.0);
  for (const RtdeKind kind :
       {RtdeKind::kProtocolVersion, RtdeKind::kSetupOutputs, RtdeKind::kSetupInputs, RtdeKind::kStart})
    EXPECT_GE(server.requests(kind).size(), 2u);
}

TEST(RtdeClient, OldStateIsAnErrorAndSilenceALostLink) {
  FakeRtde server([](int connection) {
    FakeRtdePlan plan = good_plan();
    plan.data = [connection](long n) { return connection == 0 && n <= 20 ? steady(n) : std::string(); };
    return plan;
  });
  RtdeClient client(server.endpoint(), recipe, quick());
  EXPECT_NO_THROW(static_cast<void>(client.sample()));
  const auto is_stale = [&] {
    try {
      static_cast<void>(client.sample());
    } catch (const DeviceError& error) {
      EXPECT_THAT(error.what(), HasSubstr("old"));
      return true;
    }
    return false;
  };
  ASSERT_TRUE(eventually(is_stale));
  EXPECT_TRUE(eventually([&] { return server.connections() >= 2; })) << "silent link set up anew";
  EXPECT_TRUE(is_stale()) << "a link without data does not make the old state fresh";
}

TEST(RtdeClient, OutOfStepOrGarbageMeansANewConnection) {
  for (const char* garbage : {"00 00 55", "00 02 55 00", "FF FF 55 00", "00 05 63 00 00"}) {
    FakeRtde server([garbage](int connection) {
      FakeRtdePlan plan = good_plan();
      plan.data = [connection, garbage](long n) {
        return connection == 0 && n == 10 ? hex(garbage) : steady(n + 1000L * connection);
      };
      return plan;
    });
    RtdeClient client(server.endpoint(), recipe, quick());
    EXPECT_TRUE(eventually([&] { return client.counts().sessions >= 2; })) << garbage;
  }
}

TEST(RtdeClient, RefusesWhatIsNotFiniteRepeatedOrOfAnotherRecipe) {
  FakeRtde server([](int) {
    FakeRtdePlan plan = good_plan();
    plan.data = [](long n) {
      const double time = 100.0 + 0.008 * static_cast<double>(n);
      if (n == 3) return data(time, NAN);
      if (n == 6) return data(time, INFINITY);
      if (n == 9) return data(time - 0.05, 9.0);  // out of order
      if (n == 12) return hex("00 0C 55 02") + std::string(8, '\0');
      return data(time, 0.5);
    };
    return plan;
  });
  RtdeClient client(server.endpoint(), recipe, quick());
  ASSERT_TRUE(eventually([&] { return client.counts().accepted > 30; }));
  EXPECT_EQ(client.counts().refused, 4);
  EXPECT_EQ(client.counts().skipped, 4) << "the refused ones leave gaps";
  EXPECT_EQ(client.counts().sessions, 1);
  EXPECT_EQ((client.sample().get<std::array<double, 6>>("actual_q"))[0], 0.5);
}

TEST(RtdeClient, AFrozenClockIsNotFresh) {
  FakeRtde server([](int connection) {
    FakeRtdePlan plan = good_plan();
    plan.data = [connection](long n) { return connection == 0 ? steady(std::min(n, 10L)) : steady(10); };
    return plan;
  });
  RtdeClient client(server.endpoint(), recipe, quick());
  ASSERT_TRUE(eventually([&] { return client.counts().sessions >= 3; })) << "three repeats end a session";
  EXPECT_TRUE(eventually([&] {
    try {
      return client.sample().device_time() > 100.1;
    } catch (const DeviceError&) {
      return true;
    }
  }));
}

TEST(RtdeClient, NothingOddIsSent) {
  FakeRtde server([](int) {
    FakeRtdePlan plan = good_plan();
    plan.replies['I'] = {hex("00 0A 49 01 'DOUBLE'")};
    return plan;
  });
  RtdeClient client(
      server.endpoint(),
      [](const UrVersion&) {
        return RtdeRecipe{{"actual_q"}, {}, {{"input_double_register_24"}}};
      },
      quick());
  EXPECT_THROW(client.send(0, {NAN}), InvalidArgument);
  EXPECT_THROW(client.send(0, {std::int32_t{1}}), InvalidArgument);
  EXPECT_THROW(client.send(0, {}), InvalidArgument);
  EXPECT_THROW(client.send(1, {1.0}), InvalidArgument);
  EXPECT_NO_THROW(client.send(0, {1.0}));
}

}  // namespace
}  // namespace stonestack::hardware
