#include "core/socket.hpp"

#include <gmock/gmock.h>
#include <sys/socket.h>

#include <array>
#include <atomic>
#include <numeric>
#include <thread>
#include <vector>

#include "stonestack/core/error.hpp"

namespace stonestack::core {
namespace {

using testing::HasSubstr;
using testing::ThrowsMessage;
using Bytes = std::vector<std::uint8_t>;

constexpr double kSocketSoon = 0.02, kSocketLong = 10.0;  // s

/// Two connected sockets over loopback.
struct Pair {
  TcpListener listener{ListenOptions{}};
  TcpStream client = TcpStream::connect(listener.endpoint(), Deadline::in(kSocketLong));
  TcpStream server = listener.accept(Deadline::in(kSocketLong)).value();
};

TEST(Deadline, IsBoundedAndRefusesNonsense) {
  EXPECT_TRUE(Deadline::in(0).over());
  EXPECT_GT(Deadline::in(5).left(), 4.0);
  EXPECT_LE(Deadline::in(5).or_in(1).left(), 1.0);
  EXPECT_LE(Deadline::in(1).or_in(5).left(), 1.0);
  EXPECT_THROW((void)Deadline::in(-1), InvalidArgument);
  EXPECT_THROW((void)Deadline::in(std::nan("")), InvalidArgument);
}

TEST(Socket, BytesWithoutEndDoNotPutOffTheDeadline) {
  Pair pair;
  std::atomic<bool> enough{false};
  std::thread talker([&] {
    const Bytes some(65536, 'x');
    for (const Deadline end = Deadline::in(kSocketLong); !enough && !end.over();)
      if (!pair.client.write_all(some, Deadline::in(kSocketSoon))) continue;
  });
  EXPECT_EQ(pair.server.read_line(std::size_t{1} << 28U, Deadline::in(0.05)).status, IoStatus::kTimeOut);
  enough = true;
  talker.join();
}

TEST(Socket, CarriesBytesBothWays) {
  Pair pair;
  ASSERT_TRUE(pair.client.write_all("hello", Deadline::in(kSocketLong)));
  Bytes got(5);
  const IoResult result = pair.server.read_exact(got, Deadline::in(kSocketLong));
  EXPECT_TRUE(result);
  EXPECT_EQ(std::string(got.begin(), got.end()), "hello");
  ASSERT_TRUE(pair.server.write_all("back", Deadline::in(kSocketLong)));
  Bytes some(100);
  const IoResult part = pair.client.read_some(some, Deadline::in(kSocketLong));
  EXPECT_TRUE(part);
  EXPECT_GE(part.bytes, 1U);
  EXPECT_EQ(pair.client.name(), to_text(pair.listener.endpoint()));
}

TEST(Socket, AMegabyteInFragmentsArrivesWhole) {
  Pair pair;
  Bytes sent(1U << 20U);
  std::iota(sent.begin(), sent.end(), std::uint8_t{7});
  std::thread writer([&] {
    for (std::size_t at = 0; at < sent.size(); at += 4093)
      if (!pair.client.write_all(std::span(sent).subspan(at, std::min<std::size_t>(4093, sent.size() - at)),
                                 Deadline::in(kSocketLong)))
        return;
  });
  Bytes got(sent.size());
  const IoResult result = pair.server.read_exact(got, Deadline::in(kSocketLong));
  writer.join();
  EXPECT_TRUE(result);
  EXPECT_EQ(got, sent);
}

TEST(Socket, DistinguishesATimeoutFromAClosedPeer) {
  Pair pair;
  Bytes got(4);
  EXPECT_EQ(pair.client.read_some(got, Deadline::in(kSocketSoon)).status, IoStatus::kTimeOut);
  ASSERT_TRUE(pair.server.write_all("ab", Deadline::in(kSocketLong)));
  const IoResult part = pair.client.read_exact(got, Deadline::in(kSocketSoon));
  EXPECT_EQ(part.status, IoStatus::kTimeOut);
  EXPECT_EQ(part.bytes, 2U);
  { const TcpStream gone = std::move(pair.server); }
  EXPECT_EQ(pair.client.read_some(got, Deadline::in(kSocketLong)).status, IoStatus::kClosed);
}

TEST(Socket, AResetAndAWriteToAClosedPeerAreClosedNotASignal) {
  Pair pair;
  const linger at_once{1, 0};
  ASSERT_EQ(::setsockopt(pair.server.descriptor(), SOL_SOCKET, SO_LINGER, &at_once, sizeof at_once), 0);
  { const TcpStream gone = std::move(pair.server); }
  Bytes got(4);
  EXPECT_EQ(pair.client.read_some(got, Deadline::in(kSocketLong)).status, IoStatus::kClosed);
  EXPECT_EQ(pair.client.write_all("x", Deadline::in(kSocketLong)).status, IoStatus::kClosed);
}

TEST(Socket, WritingToAPeerThatDoesNotReadTimesOut) {
  Pair pair;
  const Bytes much(64U << 20U);
  const IoResult result = pair.client.write_all(much, Deadline::in(0.1));
  EXPECT_EQ(result.status, IoStatus::kTimeOut);
  EXPECT_LT(result.bytes, much.size());
}

TEST(Socket, ReadsLinesWhateverThePacketsAre) {
  Pair pair;
  ASSERT_TRUE(pair.server.write_all("one\r\ntwo\n\nthr", Deadline::in(kSocketLong)));
  EXPECT_EQ(pair.client.read_line(100, Deadline::in(kSocketLong)).line, "one");
  EXPECT_EQ(pair.client.read_line(100, Deadline::in(kSocketLong)).line, "two");
  EXPECT_EQ(pair.client.read_line(100, Deadline::in(kSocketLong)).line, "");
  EXPECT_EQ(pair.client.read_line(100, Deadline::in(kSocketSoon)).status, IoStatus::kTimeOut);
  ASSERT_TRUE(pair.server.write_all("ee\nrest", Deadline::in(kSocketLong)));
  EXPECT_EQ(pair.client.read_line(100, Deadline::in(kSocketLong)).line, "three") << "the first half was lost";
  Bytes rest(4);
  ASSERT_TRUE(pair.client.read_exact(rest, Deadline::in(kSocketLong)));
  EXPECT_EQ(std::string(rest.begin(), rest.end()), "rest");
}

TEST(Socket, RefusesALineThatNeverEnds) {
  Pair pair;
  ASSERT_TRUE(pair.server.write_all(std::string(2000, 'x'), Deadline::in(kSocketLong)));
  EXPECT_THROW((void)pair.client.read_line(1024, Deadline::in(kSocketLong)), DeviceError);
}

TEST(Socket, DropsWhatHasArrived) {
  Pair pair;
  ASSERT_TRUE(pair.server.write_all("old\nolder", Deadline::in(kSocketLong)));
  EXPECT_EQ(pair.client.read_line(100, Deadline::in(kSocketLong)).line, "old");
  std::size_t dropped = 0;
  for (const Deadline limit = Deadline::in(kSocketLong); dropped < 5 && !limit.over();)
    dropped += pair.client.discard_input();
  EXPECT_EQ(dropped, 5U);
  EXPECT_EQ(pair.client.read_line(100, Deadline::in(kSocketSoon)).status, IoStatus::kTimeOut);
}

TEST(Socket, ShutWakesAWaitingReader) {
  Pair pair;
  IoResult result;
  std::thread reader([&] {
    Bytes got(1);
    result = pair.client.read_some(got, Deadline::in(60));
  });
  pair.client.shut();
  reader.join();
  EXPECT_EQ(result.status, IoStatus::kClosed);
  EXPECT_TRUE(pair.client.is_shut());
  EXPECT_EQ(pair.client.write_all("x", Deadline::in(kSocketLong)).status, IoStatus::kClosed);
}

TEST(Socket, ARefusedConnectionNamesAddressAndPort) {
  Endpoint nobody;
  {
    const TcpListener listener{ListenOptions{}};
    nobody = listener.endpoint();
  }
  EXPECT_THAT([&] { (void)TcpStream::connect(nobody, Deadline::in(kSocketLong)); },
              ThrowsMessage<DeviceError>(HasSubstr(to_text(nobody) + ": connection refused")));
}

TEST(Socket, AServerThatDoesNotAcceptEndsAtTheDeadline) {
  // A full queue: the kernel answers no further handshake.
  ListenOptions options;
  options.waiting = 0;
  const TcpListener listener(options);
  std::vector<TcpStream> held;
  EXPECT_THAT(
      [&] {
        for (int i = 0; i < 20; ++i)
          held.push_back(TcpStream::connect(listener.endpoint(), Deadline::in(0.05)));
      },
      ThrowsMessage<DeviceError>(HasSubstr("did not answer before the deadline")));
}

TEST(Socket, RefusesBadAddresses) {
  const auto connect = [](const char* address, int port) {
    (void)TcpStream::connect({address, port}, Deadline::in(kSocketSoon));
  };
  for (const char* bad : {"", "192.168.1", "192.168.1.300", "1234", "robot .local", "robot..local", ".local",
                          "robot.local.", "192.168.1.10:502", "http://robot"})
    EXPECT_THROW(connect(bad, 502), InvalidArgument) << bad;
  EXPECT_THROW(connect("127.0.0.1", 0), InvalidArgument);
  EXPECT_THROW(connect("127.0.0.1", 65536), InvalidArgument);
}

// `LOCALHOST` is looked up as every name is; `localhost` is known.
TEST(Socket, AHostIsFoundByItsName) {
  TcpListener listener{ListenOptions{}};
  for (const char* name : {"localhost", "LOCALHOST"}) {
    TcpStream client =
        TcpStream::connect({name, listener.endpoint().port}, Deadline::in(kSocketLong).or_interrupt());
    EXPECT_TRUE(listener.accept(Deadline::in(kSocketLong)).has_value()) << name;
  }
}

// RFC 6761: no server knows a name that ends in .invalid.
TEST(Socket, ANameThatNobodyKnowsIsNamed) {
  EXPECT_THAT(
      [] {
        (void)TcpStream::connect({"ur10.invalid", 502}, Deadline::in(60.0));
      },
      ThrowsMessage<DeviceError>(
          AllOf(HasSubstr("ur10.invalid:502"), HasSubstr("has no IPv4 address"), HasSubstr("spelling"))));
  EXPECT_THAT(
      [] {
        (void)TcpStream::connect({"ur10.invalid", 502}, Deadline::in(0.0));
      },
      ThrowsMessage<DeviceError>(HasSubstr("was not looked up before the deadline")));
}

TEST(Listener, TakesAnyLoopbackAddressAndReportsThePort) {
  ListenOptions options;
  options.address = "127.77.0.3";
  TcpListener listener(options);
  EXPECT_GT(listener.endpoint().port, 0);
  TcpStream client = TcpStream::connect(listener.endpoint(), Deadline::in(kSocketLong));
  EXPECT_TRUE(listener.accept(Deadline::in(kSocketLong)).has_value());
  EXPECT_FALSE(listener.accept(Deadline::in(kSocketSoon)).has_value());
}

TEST(Listener, RefusesOtherAddressesUnlessRequested) {
  ListenOptions options;
  options.address = "0.0.0.0";
  EXPECT_THROW(TcpListener{options}, InvalidArgument);
  options.allow_remote = true;
  EXPECT_NO_THROW(TcpListener{options});
  EXPECT_TRUE(is_loopback("127.255.0.1"));
  EXPECT_TRUE(is_loopback("localhost"));
  EXPECT_FALSE(is_loopback("128.0.0.1"));
}

TEST(Listener, AnOccupiedPortIsNamed) {
  const TcpListener first{ListenOptions{}};
  ListenOptions options;
  options.port = first.endpoint().port;
  EXPECT_THAT([&] { TcpListener{options}; },
              ThrowsMessage<DeviceError>(HasSubstr(to_text(first.endpoint()) + ": cannot listen")));
}

TEST(Listener, CloseWakesAccept) {
  TcpListener listener{ListenOptions{}};
  bool accepted = true;
  std::thread acceptor([&] { accepted = listener.accept(Deadline::in(60)).has_value(); });
  listener.close();
  acceptor.join();
  EXPECT_FALSE(accepted);
  EXPECT_TRUE(listener.is_closed());
}

TEST(Listener, APortIsFreeAgainAfterUse) {
  ListenOptions options;
  {
    Pair pair;
    options.port = pair.listener.endpoint().port;
    ASSERT_TRUE(pair.server.write_all("x", Deadline::in(kSocketLong)));
  }
  EXPECT_NO_THROW(TcpListener{options});
}

}  // namespace
}  // namespace stonestack::core
