#include "emulators/ur/script_queue.hpp"

#include <cstdlib>
#include <iterator>

namespace stonestack::emulators {
namespace {

// A step at 500 Hz has 2 ms for everything; a short script takes some 0.3 us a character, a line at least 10.
constexpr std::size_t kLong = 2000;                // characters: compiled beside
constexpr std::size_t kCharactersAStep = 4000;     // of short ones, all clients together
constexpr int kItemsAStep = 64;                    // all clients together
constexpr std::size_t kMaxItems = 16;              // that wait, of a client that may still send
constexpr std::size_t kMaxCharacters = 1'000'000;  // likewise

std::string trimmed(const std::string& line) {
  const auto first = line.find_first_not_of(" \t\r"), last = line.find_last_not_of(" \t\r");
  return first == std::string::npos ? "" : line.substr(first, last - first + 1);
}

// What a script port understands besides URScript.
bool obey(UrController& c, const std::string& line) {
  if (line == "power on") {
    c.power_on();
  } else if (line == "power off") {
    c.power_off();
  } else if (line == "set robotmode run") {
    c.release_brakes();
  } else if (line == "set unlock protective stop") {
    c.unlock_when_allowed();
  } else if (line == "stop program") {
    c.stop_program();
  } else if (line.rfind("set speed ", 0) == 0) {
    const double speed = std::strtod(line.c_str() + 10, nullptr);
    if (speed >= 0 && speed <= 1) c.speed_slider = speed;
  } else {
    // ur_rtde ends its upload with this line; with nothing loaded there is nothing to run.
    return line == "run program";
  }
  return true;
}

}  // namespace

ScriptQueue::~ScriptQueue() {
  {
    const std::lock_guard guard(mutex_);
    ends_ = true;
  }
  changed_.notify_all();
  if (compiler_.joinable()) compiler_.join();
}

void ScriptQueue::put(int client, std::string text) {
  Lane& lane = lanes_[client];
  lane.characters += text.size();
  lane.items.push_back({std::move(text), nullptr});
}

bool ScriptQueue::is_full(int client) const {
  const auto it = lanes_.find(client);
  return it != lanes_.end() &&
         (it->second.items.size() >= kMaxItems || it->second.characters > kMaxCharacters);
}

void ScriptQueue::turn() {
  int items = 0;
  std::size_t characters = 0;
  const auto serve = [&](Lane& lane) {
    while (!lane.items.empty() && items < kItemsAStep && characters < kCharactersAStep) {
      Item& item = lane.items.front();
      const std::size_t size = item.text.size();
      if (!run(item)) return;
      ++items;
      if (size <= kLong) characters += size;
      lane.characters -= size;
      lane.items.pop_front();
    }
  };
  if (lanes_.empty()) return;
  auto first = lanes_.lower_bound(first_);
  if (first == lanes_.end()) first = lanes_.begin();
  const auto second = std::next(first);
  first_ = second == lanes_.end() ? 0 : second->first;
  for (auto it = first; it != lanes_.end(); ++it) serve(it->second);
  for (auto it = lanes_.begin(); it != first; ++it) serve(it->second);
  std::erase_if(lanes_, [](const auto& lane) { return lane.second.items.empty(); });
}

// False when it is still being compiled.
bool ScriptQueue::run(Item& item) {
  if (item.text.size() <= kLong) {
    if (!obey(*controller_, trimmed(item.text))) controller_->run_script(item.text);
    return true;
  }
  if (!item.compilation) begin(item);
  const std::unique_lock lock(mutex_);
  if (!item.compilation->done) return false;
  controller_->run(std::move(item.compilation->made));
  return true;
}

void ScriptQueue::begin(Item& item) {
  item.compilation = std::make_shared<Compilation>();
  item.compilation->source = item.text;
  const std::lock_guard guard(mutex_);
  long_ones_.push_back(item.compilation);
  if (!compiler_.joinable()) compiler_ = std::thread([this] { compile_long_ones(); });
  changed_.notify_all();
}

void ScriptQueue::compile_long_ones() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return ends_ || !long_ones_.empty(); });
    if (ends_) return;
    const auto next = std::move(long_ones_.front());
    long_ones_.pop_front();
    lock.unlock();
    CompiledScript made = controller_->compile(next->source);
    lock.lock();
    next->made = std::move(made);
    next->done = true;
  }
}

}  // namespace stonestack::emulators
