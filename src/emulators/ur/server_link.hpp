#pragma once
#include <memory>
#include <string>
#include <vector>

#include "core/socket.hpp"
#include "emulators/ur/controller.hpp"

namespace stonestack::emulators {

/// One client of one port. Everything happens between two control steps and never waits.
class ServerLink {
 public:
  /// Treatment of a client that does not read.
  enum class Unread { kDisconnected, kSkipped };
  /// Of what the client sends at most so many times 8192 bytes are taken a step: the rest waits, so that no
  /// client keeps the step from the others.
  ServerLink(TcpStream stream, UrController& controller, Unread unread = Unread::kDisconnected,
             int reads_a_step = 1);
  virtual ~ServerLink() = default;

  /// Reads what has come, and writes what is still to go.
  void pump();
  /// After every control step.
  virtual void after_step() {}
  [[nodiscard]] bool dead() const { return dead_; }
  void close() { dead_ = true; }
  /// The link stays open, but from now on nothing is heeded or written: a session that died silently. It ends
  /// when the client closes it.
  void mute() { mute_ = true; }
  /// Packages that were left out because the client did not read.
  [[nodiscard]] long skipped() const { return skipped_; }

 protected:
  virtual void receive(std::string_view bytes) = 0;
  /// Nothing more is read in this step.
  [[nodiscard]] virtual bool has_enough() const { return false; }
  /// Sends all of it, sooner or later; data beyond the buffer is skipped, or ends the link.
  void send(std::string_view bytes);
  /// Sends it now or, if the client is behind, not at all.
  void offer(std::string_view bytes);
  [[nodiscard]] UrController& controller() { return *controller_; }

 private:
  void flush();

  TcpStream stream_;
  UrController* controller_;
  Unread unread_;
  int reads_a_step_;
  std::string pending_;
  double behind_since_ = -1.0;  // s, controller time
  bool dead_ = false, mute_ = false;
  long skipped_ = 0;
};

/// A listening port with its links.
class ServerPort {
 public:
  using MakeLink = std::function<std::unique_ptr<ServerLink>(TcpStream stream)>;
  ServerPort(const ListenOptions& options, MakeLink make);

  void accept();
  void pump();
  void after_step();
  /// Stops listening, closes every link; `reopen` takes the same port again.
  void shut();
  void reopen();
  void close_links() { links_.clear(); }
  void mute_links();
  [[nodiscard]] int port() const { return options_.port; }
  [[nodiscard]] const std::vector<std::unique_ptr<ServerLink>>& links() const { return links_; }

 private:
  ListenOptions options_;
  MakeLink make_;
  std::unique_ptr<TcpListener> listener_;
  std::vector<std::unique_ptr<ServerLink>> links_;
  bool cannot_accept_ = false;  // and has reported it
};

}  // namespace stonestack::emulators
