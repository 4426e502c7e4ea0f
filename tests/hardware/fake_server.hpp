#pragma once
#include <atomic>
#include <functional>
#include <thread>

#include "core/socket.hpp"
#include "stonestack/core/error.hpp"

namespace stonestack::hardware {

/// A server on a free loopback port whose behaviour is a function: `serve(stream, n)` is called with the n-th
/// connection (from 0), one after the other, and the connection is closed when it returns.
class FakeServer {
 public:
  using Serve = std::function<void(TcpStream&, int)>;
  explicit FakeServer(Serve serve) : serve_(std::move(serve)), thread_([this] { run(); }) {}
  ~FakeServer() { stop(); }
  FakeServer(const FakeServer&) = delete;
  FakeServer& operator=(const FakeServer&) = delete;

  void stop() {
    ending_ = true;
    listener_.close();
    if (thread_.joinable()) thread_.join();
  }
  [[nodiscard]] Endpoint endpoint() const { return listener_.endpoint(); }
  [[nodiscard]] int port() const { return listener_.endpoint().port; }
  [[nodiscard]] bool ending() const { return ending_; }
  [[nodiscard]] int connections() const { return connections_; }

 private:
  void run() {
    while (!ending_) {
      auto stream = listener_.accept(Deadline::in(0.05));
      if (!stream) continue;
      try {
        serve_(*stream, connections_++);
      } catch (const Error&) {  // the client is gone, which a test may want
      }
    }
  }

  Serve serve_;
  std::atomic<bool> ending_{false};
  std::atomic<int> connections_{0};
  TcpListener listener_{ListenOptions{}};
  std::thread thread_;
};

/// Waits up to `seconds` for something that another thread brings about.
inline bool eventually(const std::function<bool()>& holds, double seconds = 5.0) {
  const Deadline deadline = Deadline::in(seconds);
  while (!holds()) {
    if (deadline.over()) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

}  // namespace stonestack::hardware
