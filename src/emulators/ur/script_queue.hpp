#pragma once
#include <condition_variable>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "emulators/ur/controller.hpp"

namespace stonestack::emulators {

/// Queue of scripts that have been received and not yet run. No client's scripts hold up a control
/// step that others rely on: a long one is compiled in a thread beside, and of short ones a step takes a
/// handful. What one client sends stays in its order and is run to the last line, even when the client has
/// hung up; clients do not wait for each other.
class ScriptQueue {
 public:
  explicit ScriptQueue(UrController& controller) : controller_(&controller) {}
  ~ScriptQueue();
  ScriptQueue(const ScriptQueue&) = delete;
  ScriptQueue& operator=(const ScriptQueue&) = delete;

  /// A program, a line of URScript or a command such as "power on". `client` identifies the link.
  void put(int client, std::string text);
  /// The client has sent enough for now: what else it sends waits in its socket.
  [[nodiscard]] bool is_full(int client) const;
  /// Before a control step: runs what is ready.
  void turn();

 private:
  struct Compilation {
    std::string source;
    CompiledScript made;
    bool done = false;
  };
  struct Item {
    std::string text;
    std::shared_ptr<Compilation> compilation;  // of a long one, once it was begun
  };
  struct Lane {
    std::deque<Item> items;
    std::size_t characters = 0;
  };

  bool run(Item& item);
  void begin(Item& item);
  void compile_long_ones();

  UrController* controller_;
  std::map<int, Lane> lanes_;  // by client, none empty
  int first_ = 0;              // client whose turn it is to be first
  std::mutex mutex_;           // of what follows
  std::condition_variable changed_;
  std::deque<std::shared_ptr<Compilation>> long_ones_;
  bool ends_ = false;
  std::thread compiler_;
};

}  // namespace stonestack::emulators
