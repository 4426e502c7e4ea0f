#pragma once
#include <functional>
#include <memory>
#include <string>

#include "stonestack/core/rooms.hpp"

/// Private to report/: a page that changes while work goes on, over HTTP.
namespace stonestack::report {

inline constexpr double kFarewell = 3.0;  ///< time that viewers have to receive the end [s]

/// HTTP server on 127.0.0.1. GET / is the page, GET /events its changes as server-sent events, POST /stop
/// with the header X-Stop-Token stops the work. Requests with a Host that is not this machine are refused
/// (DNS rebinding). Whoever publishes never waits for a client: all clients read one list of messages, each
/// at its own pace, and one that does not read is dropped after two seconds.
class LiveServer {
 public:
  /// Serves `page`. `stop` is called from a thread of the server.
  /// @param port 0: any that is free
  /// @throws InvalidArgument if the port is taken
  LiveServer(int port, std::string page, std::function<void()> stop);
  /// Ends all connections.
  ~LiveServer();
  LiveServer(const LiveServer&) = delete;
  LiveServer& operator=(const LiveServer&) = delete;

  /// "http://127.0.0.1:PORT/"
  [[nodiscard]] std::string address() const;
  /// Secret that POST /stop needs: 32 hexadecimal digits, new for each server.
  [[nodiscard]] const std::string& stop_token() const;
  /// Number of clients that receive events.
  [[nodiscard]] int clients() const;
  /// Replaces the page for clients that come from now on.
  void set_page(std::string page);
  /// Sends a message (one line of JSON) to all clients, now and later. `replaces`: it says all that earlier
  /// ones did, which are forgotten.
  void publish(const std::string& event, const std::string& data, bool replaces = false);
  /// Ends the streams: waits until every client has received all messages, `seconds` at most.
  void finish(double seconds);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace stonestack::report
