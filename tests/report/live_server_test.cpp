#include "report/live_server.hpp"

#include <arpa/inet.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <string>
#include <thread>

#include "stonestack/core/error.hpp"

namespace stonestack::report {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

int port_of(const LiveServer& server) {
  return std::stoi(server.address().substr(server.address().rfind(':') + 1));
}

/// A connection of bytes, which knows nothing of HTTP.
class Peer {
 public:
  explicit Peer(const LiveServer& server, in_addr_t to = INADDR_LOOPBACK)
      : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port_of(server)));
    address.sin_addr.s_addr = htonl(to);
    const timeval patience{20, 0};
    ::setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
    connected_ = ::connect(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  }
  ~Peer() { ::close(socket_); }
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;

  [[nodiscard]] bool connected() const { return connected_; }
  void send(const std::string& text) const { (void)::send(socket_, text.data(), text.size(), MSG_NOSIGNAL); }
  /// All bytes until the server closes, or until `end` has come.
  [[nodiscard]] std::string receive(const std::string& end = "") const {
    std::string text;
    char piece[65536];
    for (ssize_t got = 0; (got = ::recv(socket_, piece, sizeof piece, 0)) > 0;) {
      text.append(piece, static_cast<std::size_t>(got));
      if (!end.empty() &&
          text.find(end, text.size() - std::min(text.size(), std::size_t(got) + end.size())) !=
              std::string::npos)
        break;
    }
    return text;
  }

 private:
  int socket_;
  bool connected_ = false;
};

std::string ask(const LiveServer& server, const std::string& request, const std::string& end = "") {
  const Peer peer(server);
  peer.send(request);
  return peer.receive(end);
}

std::string get(const std::string& path, const std::string& host = "localhost",
                const std::string& more = "") {
  return concat("GET ", path, " HTTP/1.1\r\nHost: ", host, "\r\n", more, "\r\n");
}

std::string stop_with(const std::string& headers) {
  return concat("POST /stop HTTP/1.1\r\nHost: 127.0.0.1\r\nContent-Length: 0\r\n", headers, "\r\n");
}

TEST(LiveServer, ServesThePageToThisMachineOnly) {
  LiveServer server(0, "<p>first</p>", [] {});
  EXPECT_THAT(ask(server, get("/")), HasSubstr("<p>first</p>"));
  server.set_page("<p>second</p>");
  for (const std::string host : {"127.0.0.1", "localhost:8080", "LOCALHOST", "[::1]:99", "127.0.0.1:1"})
    EXPECT_THAT(ask(server, get("/", host)), HasSubstr("<p>second</p>")) << host;
  for (const std::string host :
       {"evil.example", "127.0.0.1.evil.example", "localhost.evil.example:80", "", "192.168.1.2", "[::2]"}) {
    const std::string answer = ask(server, get("/", host));
    EXPECT_THAT(answer, StartsWith("HTTP/1.1 403")) << host;
    EXPECT_THAT(answer, Not(HasSubstr("second"))) << host;
  }
  EXPECT_THAT(ask(server, "GET / HTTP/1.1\r\n\r\n"), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(ask(server, get("/", "localhost", "Host: evil.example\r\n")), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(ask(server, get("/events", "evil.example")), StartsWith("HTTP/1.1 403"));
  EXPECT_THAT(ask(server, get("/etc/passwd")), StartsWith("HTTP/1.1 404"));
}

TEST(LiveServer, ListensOnLoopbackAlone) {
  const LiveServer server(0, "", [] {});
  EXPECT_TRUE(Peer(server).connected());
  EXPECT_FALSE(Peer(server, INADDR_LOOPBACK + 1).connected())
      << "127.0.0.2 is another address of this machine";
}

TEST(LiveServer, StopsForTheTokenOnly) {
  std::atomic<int> stops{0};
  LiveServer server(0, "", [&] { ++stops; });
  const std::string& token = server.stop_token();
  EXPECT_EQ(token.size(), 32u);
  std::string other = token;
  other.back() = other.back() == '0' ? '1' : '0';
  for (const std::string& headers :
       {std::string(), "X-Stop-Token: " + other + "\r\n", "X-Stop-Token: " + token + "0\r\n",
        "X-Stop-Token: " + token.substr(1) + "\r\n",
        "X-Stop-Token: " + token + "\r\nOrigin: http://evil.example\r\n",
        "X-Stop-Token: " + token + "\r\nOrigin: null\r\n"})
    EXPECT_THAT(ask(server, stop_with(headers)), StartsWith("HTTP/1.1 403")) << headers;
  EXPECT_THAT(ask(server, get("/stop", "localhost", "X-Stop-Token: " + token + "\r\n")),
              StartsWith("HTTP/1.1 404"));
  EXPECT_EQ(stops, 0);
  EXPECT_THAT(ask(server, stop_with("X-Stop-Token: " + token + "\r\nOrigin: http://localhost:8080\r\n")),
              StartsWith("HTTP/1.1 200"));
  EXPECT_EQ(stops, 1);
  EXPECT_NE(LiveServer(0, "", [] {}).stop_token(), token);
}

TEST(LiveServer, EveryClientReceivesAllMessagesInOrder) {
  LiveServer server(0, "", [] {});
  server.publish("add", "{\"n\":0}");
  const Peer early(server);
  early.send(get("/events"));
  EXPECT_THAT(early.receive("{\"n\":0}"), HasSubstr("id: 0\nevent: add\ndata: {\"n\":0}"));
  server.publish("add", "{\"n\":1}");
  const Peer late(server), back(server);
  late.send(get("/events"));
  back.send(get("/events", "localhost", "Last-Event-ID: 0\r\n"));
  EXPECT_THAT(late.receive("{\"n\":1}"), HasSubstr("{\"n\":0}"));
  EXPECT_THAT(back.receive("{\"n\":1}"), Not(HasSubstr("{\"n\":0}"))) << "it has that already";
  server.publish("end", "{\"n\":2}");
  server.finish(20.0);
  for (const Peer* peer : {&early, &late, &back})
    EXPECT_THAT(peer->receive(), HasSubstr("event: end\ndata: {\"n\":2}"));
  EXPECT_EQ(server.clients(), 0);
}

TEST(LiveServer, AMessageThatReplacesOthersIsTheOnlyOneForNewClients) {
  LiveServer server(0, "", [] {});
  for (int i = 0; i < 3; ++i) server.publish("state", concat("{\"n\":", i, "}"), true);
  const std::string received = ask(server, get("/events"), "{\"n\":2}");
  EXPECT_THAT(received, Not(HasSubstr("{\"n\":0}")));
  EXPECT_THAT(received, Not(HasSubstr("{\"n\":1}")));
}

TEST(LiveServer, AClientThatDoesNotReadIsDroppedAndHoldsNobodyUp) {
  LiveServer server(0, "", [] {});
  const Peer slow(server), quick(server);
  slow.send(get("/events"));
  quick.send(get("/events"));
  while (server.clients() < 2) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  const std::string large(1 << 20, 'x');
  for (int i = 0; i < 32; ++i) server.publish("add", large);  // more than sockets buffer
  server.publish("add", "\"last\"");
  EXPECT_THAT(quick.receive("\"last\"").size(), ::testing::Gt(32u << 20U));
  for (int i = 0; i < 4000 && server.clients() > 1; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_EQ(server.clients(), 1);
}

TEST(LiveServer, ViewersAreLimitedAndTheStopIsAlwaysHeard) {
  std::atomic<bool> stopped{false};
  LiveServer server(0, "", [&] { stopped = true; });
  std::vector<std::unique_ptr<Peer>> peers;
  for (int i = 0; i < 16; ++i) {
    peers.push_back(std::make_unique<Peer>(server));
    peers.back()->send(get("/events"));
  }
  while (server.clients() < 16) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_THAT(ask(server, get("/events")), StartsWith("HTTP/1.1 503"));
  EXPECT_THAT(ask(server, stop_with("X-Stop-Token: " + server.stop_token() + "\r\n")),
              StartsWith("HTTP/1.1 200"));
  EXPECT_TRUE(stopped);
}

TEST(LiveServer, LeavesTheProcessAsItWas) {
  struct sigaction before {
  }, after{};
  sigaction(SIGPIPE, nullptr, &before);
  {
    LiveServer server(0, "", [] {});
    EXPECT_THROW(LiveServer(port_of(server), "", [] {}), InvalidArgument) << "the port is taken";
    const Peer gone(server);
    gone.send(get("/events"));
  }
  sigaction(SIGPIPE, nullptr, &after);
  EXPECT_EQ(before.sa_handler, after.sa_handler);
}

}  // namespace
}  // namespace stonestack::report
